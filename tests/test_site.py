"""`make docs`: the pages as a site, without a warning, each link to a place that is there, and in its reference all that is public."""

import html.parser
import re
import subprocess
import sys
from urllib.parse import unquote

import pytest
import talus
from support import REPOSITORY
from test_docstrings import public_face

pytestmark = [pytest.mark.long, pytest.mark.release, pytest.mark.builds]
SITE = REPOSITORY / "build/docs"
HEADERS = sorted((REPOSITORY / "include").rglob("*.h"))


@pytest.fixture(scope="module")
def site():
    make = ["make", "-C", str(REPOSITORY), f"PYTHON={sys.executable}", "docs-site"]
    done = subprocess.run(make, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return {path.relative_to(SITE).as_posix(): Page(path) for path in SITE.rglob("*.html")}


class Page(html.parser.HTMLParser):
    """Where a page's links lead, and the places that it has."""

    def __init__(self, path):
        super().__init__()
        self.path, self.links, self.ids = path, [], {""}
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.ids.add(given.get("id", ""))
        self.links += [given[key] for key in ("href", "src") if given.get(key)]


def lost(page, site):
    """Links of a page to files of the site, or places in them, that are not there."""
    for link in page.links:
        file, _, place = link.split("?")[0].partition("#")
        if link.startswith(("http:", "https:", "data:", "mailto:")):
            continue
        target = (page.path.parent / unquote(file)).resolve() if file else page.path
        known = site.get(target.relative_to(SITE).as_posix()) if target.is_relative_to(SITE) else None
        if not target.exists() or known and unquote(place) not in known.ids:
            yield link


def test_every_page_is_there_and_in_the_margin(site):
    pages = ["README", "README.zh", "CHANGELOG", "tests/README", "tools/docs/python", *(f"docs/{path.stem}" for path in (REPOSITORY / "docs").glob("*.md"))]
    pages += [str(path.relative_to(REPOSITORY).with_suffix("")) for path in HEADERS]
    margin = set(site["docs/model.html"].links)
    for name in pages:
        assert f"{name}.html" in site
        assert name == "docs/model" or any(link.endswith(f"{name.split('/')[-1]}.html") for link in margin), name


def test_every_link_leads_to_a_place(site):
    assert sum(len(page.links) for page in site.values()) > 2000
    assert {name: found for name, page in site.items() if (found := sorted(set(lost(page, site))))} == {}


def test_each_public_function_and_type_of_c_has_an_entry_on_its_headers_page(site):
    """The functions as the compiler's preprocessor and cffi see them."""
    functions = [name for name in dir(talus.lib) if name.startswith("tl_") and callable(getattr(talus.lib, name))]
    types = [name for path in HEADERS for name in re.findall(r"^typedef (?:struct|enum) (\w+)", path.read_text(), re.MULTILINE)]
    entries = {name for page in site for name in site[page].ids if page.startswith("include/")}
    assert len(functions) > 250 and len(types) > 50
    assert [name for name in functions + types if f"c.{name}" not in entries] == []
    for name in functions:
        home = next(path for path in HEADERS if re.search(rf"\b{name}\(", re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.DOTALL)))
        assert f"c.{name}" in site[home.relative_to(REPOSITORY).with_suffix(".html").as_posix()].ids


def test_each_public_name_of_python_has_an_entry(site):
    entries = site["tools/docs/python.html"].ids
    assert [name for name in [*talus.__all__, *public_face(talus)] if f"talus.{name}" not in entries] == []


def test_what_a_header_says_of_a_function_leads_to_it(site):
    assert "#c.tl_track_init" in site["include/talus/kinematics.html"].links  # a comment there names it
    assert "../../docs/signal.html" in site["include/talus/kinematics.html"].links


def test_a_link_that_leads_nowhere_is_found(tmp_path, site):
    here = SITE / "bad.html"
    here.write_text('<a href="none.html">x</a> <a href="README.html#none">y</a> <a href="README.html">z</a>')
    try:
        assert list(lost(Page(here), site)) == ["none.html", "README.html#none"]
    finally:
        here.unlink()
