"""The docs site: README.md and docs/ as they stand, as pages, and the reference: docstrings and headers. `make docs` runs it;
but for python.md beside this file nothing is written for it alone."""

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import c_header  # noqa: E402
import docstring  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
HEADERS = {  # each with what it includes beneath it
    "include/talus/talus": sorted(f"include/talus/{path.stem}" for path in (ROOT / "include/talus").glob("*.h") if path.stem not in ("talus", "experimental")),
    "include/talus/experimental": sorted(f"include/talus/experimental/{path.stem}" for path in (ROOT / "include/talus/experimental").glob("*.h")),
}
PAGES = {
    "Start": ["docs/demo", "docs/python", "README.zh", "CHANGELOG"],
    "Commands": [f"docs/{path.stem}" for path in sorted((ROOT / "docs").glob("talus-*.md"))],
    "Formats": ["docs/recording", "docs/model", "docs/trajectory", "docs/bus"],
    "Reference": ["tools/docs/python", *HEADERS],
    "Method": ["docs/equations", "docs/signal", "docs/effects", "docs/diagnosis", "docs/controller", "docs/marker", "docs/plants"],
}
NAMED = {"README", *(page for pages in PAGES.values() for page in pages)}
PAGES["How good, how made"] = [*sorted({f"docs/{path.stem}" for path in (ROOT / "docs").glob("*.md")} - NAMED), "tests/README"]

project = "talus"
release = ".".join(re.findall(r"TL_VERSION_(?:MAJOR|MINOR|PATCH) +(\d+)", (ROOT / "include/talus/version.h").read_text()))
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
root_doc = "README"
include_patterns = ["README.md", "README.zh.md", "CHANGELOG.md", "docs/*.md", "tests/README.md", "tools/docs/python.md", "include/**.h", "examples/firmware/*.h"]
source_suffix = {".md": "markdown", ".h": "markdown"}
myst_heading_anchors = 6  # as GitHub has them
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_type_aliases = {"ArrayLike": "ArrayLike", "Array": "Array"}  # NumPy spells them out in four lines
html_theme = "furo"
html_title = f"talus {release}"
html_extra_path = ["index.html"]
html_show_copyright = False
html_copy_source = False


def add_contents(_app, name, source):
    """The pages beside the front page: README.md names them all in a table, a site wants them in its margin. Headers become
    pages, those that include the others with them beneath."""
    if name.startswith("include/"):
        source[0] = c_header.page(source[0])
    if name.startswith("examples/"):
        source[0] = f"---\norphan: true\n---\n# {Path(name).name}.h\n\n```c\n{source[0]}```\n"
    beneath = [(f":caption: {caption}", pages) for caption, pages in PAGES.items()] if name == root_doc else [("", HEADERS.get(name, []))]
    for caption, pages in beneath:
        source[0] += "\n".join(["\n```{toctree}", ":hidden:", caption, "", *(f"/{page}" for page in pages), "```\n"])


def setup(app):
    app.connect("source-read", add_contents)
    app.connect("autodoc-process-docstring", docstring.mark)
