"""apps/page/page.c and its assets: one page, whole in itself, whatever the texts are."""

import json
import re
from html.parser import HTMLParser

import pytest
from helper_programs import complaint, helper
from support import REPOSITORY

ASSETS = REPOSITORY / "apps/page/assets"
NASTY = """</script><script>alert(1)</script><!-- "quoted" & 'single' {{data}} {{title}} ünï \\u003c"""


class Page(HTMLParser):
    """Elements, attributes and the text within each kind of element."""

    VOID = {"meta", "link", "br", "img", "input", "hr"}

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.elements, self.text = [], [], {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, (tag, self.open)
        self.open.pop()

    def handle_data(self, data):
        if self.open:
            self.text.setdefault(self.open[-1], []).append(data)

    def of(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.fixture(scope="module", params=["Knee", NASTY], ids=["plain", "nasty"])
def page(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "page.html"
    helper("page_demo", path, 100_000, request.param)
    text = path.read_text(encoding="utf-8")
    return request.param, text, Page(text)


def test_page_is_well_formed(page):
    _, text, parsed = page
    assert text.startswith("<!DOCTYPE html>\n") and parsed.open == []
    assert [tag for tag, _ in parsed.elements].count("script") == 3
    assert "{{library}}" not in text and "{{style}}" not in text


def test_texts_stand_as_they_were_given(page):
    said, _, parsed = page
    for tag in ("title", "h1", "p", "figcaption", "th"):
        assert said in parsed.text[tag], tag
    assert any(said in a.get("aria-label", "") for a in parsed.of("canvas"))
    assert "The identified model explains" in parsed.text["p"][0]
    assert {"93.5", "1.20", "80.8", "2.31"} <= set(parsed.text["td"])


def test_page_asks_no_network_for_anything(page):
    _, _, parsed = page
    for tag, attributes in parsed.elements:
        for name in ("src", "href", "action", "srcset", "data"):
            assert attributes.get(name, "data:,").startswith("data:"), (tag, attributes)
    own = "".join((ASSETS / name).read_text() for name in ("page.html", "page.css", "page.js"))
    assert not re.search(r"https?:|//[a-z]|@import|url\(|fetch\(|XMLHttp", own.replace("// ", ""))
    policy = [a["content"] for a in parsed.of("meta") if a.get("http-equiv") == "Content-Security-Policy"]
    assert policy and policy[0].startswith("default-src 'none'")


def test_charts(page):
    said, _, parsed = page
    data = [text for text in parsed.text["script"] if text.startswith("[{")]
    assert len(data) == 1 and "<" not in data[0]
    charts = json.loads(data[0], parse_constant=lambda name: pytest.fail(name))
    assert [chart["form"] for chart in charts] == ["lines", "bars", "dots"]
    canvases = sum(1 + ("below" in chart) for chart in charts)
    assert len(parsed.of("canvas")) == canvases == 4
    lines, bars, dots = charts
    assert lines["title"] == said and bars["labels"] == ["stribeck", said, "none"]
    assert [series["role"] for series in lines["series"]] == ["measured", "predicted"]
    assert lines["below"]["series"][0]["role"] == "residual"
    for chart in (lines, lines["below"], dots):
        for series in chart["series"]:
            assert len(series["t"]) == len(series["y"]) <= 2000
            assert series["t"] == sorted(series["t"])
            assert None in series["y"]  # the gap
    # 100 s at 1 kHz keep their extremes
    assert max(y for y in lines["below"]["series"][0]["y"] if y is not None) == pytest.approx(0.05, abs=1e-4)


def test_every_role_has_a_colour():
    style = (ASSETS / "page.css").read_text()
    light, dark = style.split("prefers-color-scheme: dark")
    for role in "measured predicted residual nominal identified extended noise accent ink line paper".split():
        assert f"--{role}: #" in light and f"--{role}: #" in dark.split("}")[0], role


def test_page_stays_small(tmp_path):
    """An hour at 1 kHz makes a page hardly larger than a minute does."""
    sizes = []
    for samples in (60_000, 3_600_000):
        helper("page_demo", tmp_path / "page.html", samples, "x")
        sizes.append((tmp_path / "page.html").stat().st_size)
    assert max(sizes) < 450_000 and sizes[1] < 1.1 * sizes[0]


def test_page_that_cannot_be_written(tmp_path):
    message = complaint("page_demo", tmp_path / "none/page.html", 10, "x", status=1)
    assert message.endswith("page.html: cannot be written: No such file or directory")
