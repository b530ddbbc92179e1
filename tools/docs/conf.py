"""The docs site: README.md and docs/ as they stand, as pages. `make docs` runs it; nothing is written for it alone."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = {
    "Start": ["docs/demo", "docs/python", "README.zh", "CHANGELOG"],
    "Commands": [f"docs/{path.stem}" for path in sorted((ROOT / "docs").glob("talus-*.md"))],
    "Formats": ["docs/recording", "docs/model", "docs/trajectory", "docs/bus"],
    "Method": ["docs/equations", "docs/signal", "docs/effects", "docs/diagnosis", "docs/controller", "docs/marker", "docs/plants"],
}
NAMED = {"README", *(page for pages in PAGES.values() for page in pages)}
PAGES["How good, how made"] = [*sorted({f"docs/{path.stem}" for path in (ROOT / "docs").glob("*.md")} - NAMED), "tests/README"]

project = "talus"
release = ".".join(re.findall(r"TL_VERSION_(?:MAJOR|MINOR|PATCH) +(\d+)", (ROOT / "include/talus/version.h").read_text()))
extensions = ["myst_parser"]
root_doc = "README"
include_patterns = ["README.md", "README.zh.md", "CHANGELOG.md", "docs/*.md", "tests/README.md"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 6  # as GitHub has them
html_theme = "furo"
html_title = f"talus {release}"
html_extra_path = ["index.html"]
html_show_copyright = False
html_copy_source = False


def add_contents(_app, name, source):
    """The pages beside the front page: README.md names them all in a table, a site wants them in its margin."""
    if name == root_doc:
        for caption, pages in PAGES.items():
            source[0] += "\n".join(["\n```{toctree}", ":hidden:", f":caption: {caption}", "", *pages, "```\n"])


def setup(app):
    app.connect("source-read", add_contents)
