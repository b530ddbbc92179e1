"""The page of talus-gap in a real browser: nothing complains, nothing is asked of a network, every figure is drawn, and
its numbers are those of GAP.json; on a desk, on a phone and on paper."""

import json
import re

import pytest
from browser import PROGRAM, Browser
from support import REPOSITORY, run
from test_gap_command import simulate

pytestmark = [pytest.mark.long, pytest.mark.alone]  # Chromium is given so many seconds to answer

LEG = REPOSITORY / "models/leg.yaml"
HIDDEN = {("nonlinear_viscous", "knee"): {"size_Nm": 0.25, "exponent": 2.0}}
WIDTHS = {"desk": (1100, 900, False), "phone": (390, 844, True)}
CANVASES = """[...document.querySelectorAll("figure canvas")].map((canvas) => {
  const of = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  const colours = new Set();
  for (let i = 0; i < of.length; i += 4) if (of[i + 3]) colours.add((of[i] << 16) | (of[i + 1] << 8) | of[i + 2]);
  const box = canvas.getBoundingClientRect();
  return {name: canvas.ariaLabel, colours: [...colours].slice(0, 9999), width: box.width, right: box.right};
})"""
TABLES = """[...document.querySelectorAll("table")].map((table) => ({
  caption: table.caption.innerText, rows: [...table.rows].map((row) => [...row.cells].map((cell) => cell.innerText))
}))"""
CHARTS = 'JSON.parse(document.getElementById("charts").textContent)'
SHOWN = """[...document.querySelectorAll("figure canvas")].map((canvas) => {
  const chart = Chart.getChart(canvas);
  return {labels: chart.data.labels, data: chart.data.datasets.map((set) => set.data.map((d) => (typeof d === "number" ? d : d.y)))};
})"""
UNITS = {"mNm": 1e-3, "Nm": 1.0, "mrad": 1e-3, "rad": 1.0, "%": 1e-2}


@pytest.fixture(scope="module")
def browser():
    if not PROGRAM:
        pytest.fail("NO BROWSER: Chromium is missing, so no page was looked at; tools/setup browser installs it")
    with Browser() as running:
        yield running


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """(folder, GAP.json) of a bench with a cause; page.html beside it."""
    folder = tmp_path_factory.mktemp("browser")
    recording = simulate(folder, HIDDEN, duration_s=40)
    run("talus-gap", "--model", LEG, "--report", folder / "gap.json", "--html", folder / "page.html", recording)
    return folder, json.loads((folder / "gap.json").read_text())


@pytest.fixture(scope="module", params=WIDTHS)
def page(request, browser, case):
    width, height, mobile = WIDTHS[request.param]
    return browser.open(case[0] / "page.html", width, height, mobile=mobile)


def figure(text):
    """A figure with its unit, in SI."""
    number, _, unit = text.partition(" ")
    return float(number) * UNITS[unit]


def table(page, caption):
    """{first cell: {column: cell}} of a table."""
    (found,) = [t for t in page.evaluate(TABLES) if t["caption"].startswith(caption)]
    head, *rows = found["rows"]
    return {row[0]: dict(zip(head[1:], row[1:], strict=True)) for row in rows}


def test_nothing_complains_and_nothing_is_asked_of_a_network(page, case):
    assert page.complaints() == []
    assert page.requests() == [f"file://{case[0] / 'page.html'}"]


def test_every_figure_is_drawn(page, case):
    canvases = page.evaluate(CANVASES)
    names = " | ".join(canvas["name"] for canvas in canvases)
    assert len(canvases) == sum(1 + ("below" in chart) for chart in page.evaluate(CHARTS))
    for what in ("knee: torque error", "ankle: torque error", "knee: motion error", "ankle: motion error",
                 "What could explain the gap", "knee: mean error over velocity", "knee: the 12 s of leg.csv", "ankle: the 12 s of leg.csv",
                 "Trajectory"):  # fmt: skip
        assert what in names, what
    for canvas in canvases:
        assert canvas["width"] > 200, canvas["name"]
        # beside ink and grid, and what lies between them by smoothing, something stands in a series' colour
        coloured = [c for c in canvas["colours"] if max(channels(c)) - min(channels(c)) > 60]
        assert len(canvas["colours"]) > 5 and coloured, canvas["name"]


def channels(colour):
    return colour >> 16, colour >> 8 & 255, colour & 255


def test_what_is_drawn_is_what_the_report_says(page, case):
    report = case[1]
    names = [canvas["name"] for canvas in page.evaluate(CANVASES)]
    shown = dict(zip(names, page.evaluate(SHOWN), strict=True))
    for joint, gap in report["gap"].items():
        bars = shown[f"{joint}: torque error"]
        want = [gap[f"{key}_rms"] for key in ("nominal", "identified", "extended", "noise_floor")]
        assert bars["data"] == [[pytest.approx(1e3 * x, rel=1e-9) for x in want]]
        assert [figure(label[1]) for label in bars["labels"]] == pytest.approx(want, rel=1e-3)
    for joint, motion in report["motion"].items():
        want = [1e3 * motion["identified_rms"], 1e3 * motion["extended_rms"]]
        assert shown[f"{joint}: motion error"]["data"] == [pytest.approx(want, rel=1e-9)]
    said = shown["What could explain the gap"]["data"][0]
    every = [report["verdict"], *report["alternatives"]]
    assert said == [e["probability"] for e in every[:len(said)]]


def test_tables_say_what_the_report_says(page, case):
    report = case[1]
    said = table(page, "RMS of measured − predicted [mNm]")
    for joint, gap in report["gap"].items():
        row = said[joint]
        for column, key in (("as given", "nominal_rms"), ("identified", "identified_rms"), ("with effects", "extended_rms"),
                            ("noise floor", "noise_floor_rms"), ("near standstill", "reversal_rms")):  # fmt: skip
            assert figure(f"{row[column]} mNm") == pytest.approx(gap[key], rel=1e-3)
        shares = [100 * gap[f"{key}_rms"] / gap["measured_rms"] for key in ("identified", "extended")]
        assert [float(x) for x in re.findall(r"[\d.]+", row["of the measured"])] == pytest.approx(shares, abs=6e-3)
        assert figure(row["closed"]) == pytest.approx(gap["closed_fraction"], abs=6e-4)
        interval = [float(x) / 100 for x in re.findall(r"-?[\d.]+", row["in another motion (95 %)"])]
        assert interval == pytest.approx(gap["closed_interval"], abs=6e-4)
    (effect,) = report["effects"]
    row = table(page, "1. viscous friction")
    for name, value in effect["parameters"].items():
        shown, *half = (float(x) for x in row[name]["value"].split(" ± "))
        assert shown == pytest.approx(value, rel=1e-3)
        interval = effect["interval"].get(name)
        assert half == ([] if interval is None else [pytest.approx((interval[1] - interval[0]) / 2, rel=0.06)])
    assert effect["interval"], "no parameter has an interval"
    places = page_places(page)
    for one, (name, share, deviations) in zip(report["where"], places):
        assert name == f"{one['joint']}, {one['coordinate'].replace('_', ' ')}"
        assert share == pytest.approx(one["share"], abs=6e-4) and deviations == pytest.approx(one["deviations"], rel=6e-3)


def page_places(page):
    for name, row in table(page, "Before any effect").items():
        yield name, figure(row["share"]), float(row["deviations"].replace(",", ""))


def test_the_first_sentence_names_the_cause(page, case):
    verdict = case[1]["verdict"]
    assert (verdict["effect"], verdict["joint"]) == ("nonlinear_viscous", "knee")
    lead = page.evaluate('document.querySelector("p.lead").innerText')
    assert "viscous friction that is not proportional to speed" in lead and "at the knee" in lead
    assert f"probability {'over 0.99' if verdict['probability'] > 0.99 else format(verdict['probability'], '.2f')}" in lead
    assert case[1]["next_experiment"]["why"] in page.evaluate("document.body.innerText")


def test_nothing_sticks_out_sideways(page):
    """Wide tables scroll within themselves; the page does not."""
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    width = page.evaluate("innerWidth")
    assert all(canvas["right"] <= width for canvas in page.evaluate(CANVASES))


def test_it_can_be_printed(browser, case):
    """On paper nothing can be scrolled: tables fit, and charts are drawn anew in the paper's width."""
    page = browser.open(case[0] / "page.html", 1100, 900)
    assert page.paper().startswith(b"%PDF")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    width = page.evaluate('document.querySelector("main").clientWidth')
    assert width < 720
    tables = page.evaluate('[...document.querySelectorAll("table")].map((table) => table.getBoundingClientRect().right)')
    assert tables and max(tables) <= width
    sizes = page.evaluate('[...document.querySelectorAll("figure canvas")].map((c) => [c.width, c.clientWidth])')
    assert all(0 < drawn == pytest.approx(shown, abs=1) and shown <= width for drawn, shown in sizes)
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.evaluate('document.querySelector("main").clientWidth') > 1000
    assert page.complaints() == []


def test_a_page_that_complains_is_noticed(browser, tmp_path):
    """The checks above can fail: a page that throws, and asks a network for something."""
    bad = tmp_path / "bad.html"
    bad.write_text("<script>console.error('odd')</script><img src='http://127.0.0.1:9/x.png'><script>throw Error('worse')</script>")
    page = browser.open(bad, 800, 600)
    assert len(page.complaints()) >= 2
    assert "http://127.0.0.1:9/x.png" in page.requests()
