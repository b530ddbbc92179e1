"""`make docs`: the pages as a site, without a warning, each link to a place that is there."""

import html.parser
import subprocess
import sys
from urllib.parse import unquote

import pytest
from support import REPOSITORY

pytestmark = [pytest.mark.long, pytest.mark.release, pytest.mark.builds]
SITE = REPOSITORY / "build/docs"


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
    pages = ["README", "README.zh", "CHANGELOG", "tests/README", *(f"docs/{path.stem}" for path in (REPOSITORY / "docs").glob("*.md"))]
    margin = set(site["docs/model.html"].links)
    for name in pages:
        assert f"{name}.html" in site
        assert name == "docs/model" or any(link.endswith(f"{name.split('/')[-1]}.html") for link in margin), name


def test_every_link_leads_to_a_place(site):
    assert sum(len(page.links) for page in site.values()) > 2000
    assert {name: found for name, page in site.items() if (found := sorted(set(lost(page, site))))} == {}


def test_a_link_that_leads_nowhere_is_found(tmp_path, site):
    here = SITE / "bad.html"
    here.write_text('<a href="none.html">x</a> <a href="README.html#none">y</a> <a href="README.html">z</a>')
    try:
        assert list(lost(Page(here), site)) == ["none.html", "README.html#none"]
    finally:
        here.unlink()
