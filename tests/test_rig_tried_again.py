"""tests/rig/conftest.py: what fails in a guest that stood still is tried again, and said; what fails in one that ran fails."""

import subprocess
import sys

import pytest
from support import REPOSITORY

CONFTEST = """
import importlib.util, sys
sys.path[:0] = [{tests!r}, {rig!r}]
spec = importlib.util.spec_from_file_location("rig_conftest", {rig!r} + "/conftest.py")
rig = importlib.util.module_from_spec(spec)
spec.loader.exec_module(rig)

class Watch:
    def each_within(self, begin_ns, end_ns):
        return [{pause_ms} * 1_000_000, 1_000_000]

rig.watch_of = lambda stash: Watch()
pytest_runtest_protocol, pytest_terminal_summary = rig.pytest_runtest_protocol, rig.pytest_terminal_summary
"""
TEST = """
from pathlib import Path

def test_it(tmp_path):
    count = Path(__file__).parent / "count"
    before = int(count.read_text()) if count.exists() else 0
    count.write_text(str(before + 1))
    assert before >= {failures} and not any(tmp_path.iterdir())
    (tmp_path / "mine").touch()
"""


@pytest.mark.parametrize(("failures", "pause_ms", "runs", "passes"), [
    (0, 150, 1, True), (1, 150, 2, True), (2, 150, 3, True), (3, 150, 3, False),  # three tries in all
    (1, 99, 1, False)])  # fmt: skip
def test_only_in_a_guest_that_stood_still(tmp_path, failures, pause_ms, runs, passes):
    (tmp_path / "conftest.py").write_text(CONFTEST.format(tests=str(REPOSITORY / "tests"), rig=str(REPOSITORY / "tests/rig"), pause_ms=pause_ms))
    (tmp_path / "test_it.py").write_text(TEST.format(failures=failures))
    done = subprocess.run([sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", tmp_path], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == (0 if passes else 1), done.stdout + done.stderr
    assert (tmp_path / "count").read_text() == str(runs)
    assert ("1 passed" if passes else "1 failed") in done.stdout
    assert done.stdout.count("test_it: 150 ms at a time; ") == runs - 1
    assert (f"tried again, for the guest stood still: {runs - 1}" in done.stdout) is (runs > 1)
