"""Which tests one process runs, where several share them, and in which order; and what stepped aside is counted and named at the end
of every run."""

from pathlib import PurePath

import pytest


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Those of a file run in one process, for they share what is slow to make; any that is free takes one marked `spread`. The longest
    come first, so that no process works alone at the end."""
    items.sort(key=lambda item: not item.get_closest_marker("longest"))
    for item in items:
        if not item.get_closest_marker("spread"):
            item.add_marker(pytest.mark.xdist_group(item.path.name))


def pytest_terminal_summary(terminalreporter):
    skipped = terminalreporter.stats.get("skipped", [])
    terminalreporter.section(f"skipped: {len(skipped)}")
    for report in skipped:
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        name = report.nodeid.removesuffix("@" + PurePath(report.fspath).name)  # of the group that one process runs
        terminalreporter.write_line(f"{name}: {reason.removeprefix('Skipped: ')}")
