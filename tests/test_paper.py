"""`make paper` on short recordings: the page stands alone, its numbers are right and those of paper.json."""

import json
import math
import os
import re
import subprocess
import sys
from html.parser import HTMLParser

import numpy as np
import pytest
import yaml
from paper import bench, linkage, published, slips
from paper.markup import number
from scoring_reference import score
from support import BUILD, REPOSITORY

import talus
from talus import lib

pytestmark = pytest.mark.long
SECONDS = 16
JOINTS = ("knee", "ankle")
VOID = {"meta", "link", "br", "hr", "img", "input"}


def make_page(folder, seconds=SECONDS):
    command = [
        sys.executable,
        str(REPOSITORY / "tools/paper/run"),
        "--out",
        str(folder),
        "--seconds",
        str(seconds),
    ]
    environment = {**os.environ, "TALUS_BUILD": str(BUILD)}
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=500, env=environment)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_page(tmp_path_factory.mktemp("paper"))


@pytest.fixture(scope="module")
def results(folder):
    return json.loads((folder / "paper.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def html(folder):
    return (folder / "index.html").read_text(encoding="utf-8")


def table_of(folder, name):
    return np.genfromtxt(folder / "recordings" / name, delimiter=",", names=True)


# ---- the page ------------------------------------------------------------------------


class Page(HTMLParser):
    """Checks nesting; collects names, what refers to them, and every address."""

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.inner, self.outer, self.text = [], [], [], [], []

    def handle_starttag(self, tag, attributes):
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attributes:
            if name == "id":
                self.ids.append(value)
            elif name in ("href", "src", "xlink:href"):
                (self.inner if value.startswith("#") else self.outer).append(value)
            self.inner += re.findall(r"url\((#[^)]*)\)", value or "")

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("style", "title"):
            self.text.append(data)


@pytest.fixture(scope="module")
def page(html):
    parser = Page()
    parser.feed(html)
    parser.close()
    assert parser.open == []
    return parser


def test_page_needs_nothing_else(page, html):
    assert set(page.outer) == {"data:,", "paper.json"}
    assert "<script" not in html and "@import" not in html
    style = html[html.index("<style>") : html.index("</style>")]
    assert "url(" not in style


def test_names_are_unique_and_every_reference_has_its_target(page):
    assert len(page.ids) == len(set(page.ids))
    assert {name[1:] for name in page.inner} <= set(page.ids)


def test_every_figure_and_table_is_there(page, html):
    text = " ".join(page.text)
    for wanted in ("Figure 3", "Figure 6", "Figure 7", "Figure 8", "Table 2", "Table 3", "Table 4"):
        assert wanted in text
    assert html.count("<svg ") == 2 + 2 + 1 + 4 + 2 + 4  # figures 7, 8, singular values, 6, slips, 3
    assert text.count("not identifiable") >= 3
    assert "nan" not in re.findall(r"[a-z]+", text.lower())


def test_text_holds_the_numbers_of_the_file(page, results):
    lead = " ".join(page.text)
    for joint in JOINTS:
        for case in ("cad", "identified"):
            assert number(1e3 * results["errors"][case][joint]["rms_Nm"]) in lead
        assert f"{results['reduction_percent'][joint]:.2f} %" in lead
        assert f"{published.REDUCTION_PERCENT[joint]:.2f} %" in lead
    assert "2,926" in lead and "1,463" in lead


@pytest.mark.parametrize(
    "value, digits, text",
    [
        (0.0076, 2, "0.0076"),
        (-12.345, 3, "−12.3"),
        (2926.4, 4, "2,926"),
        (9.996, 3, "10.0"),
        (0, 3, "0"),
        (None, 3, "–"),
        (2.43e-6, 2, "2.4 · 10<sup>−6</sup>"),
        (123456.0, 2, "1.2 · 10<sup>5</sup>"),
        (0.1 + 0.2, 3, "0.300"),
    ],
)
def test_numbers_are_written_for_readers(value, digits, text):
    assert number(value, digits) == text


# ---- the published figures -------------------------------------------------------------


def test_published_reductions_follow_from_the_published_errors():
    for joint, (before, after) in published.RMSE_NM.items():
        assert 100 * (1 - after / before) == pytest.approx(published.REDUCTION_PERCENT[joint], abs=0.005)


# ---- excitation ------------------------------------------------------------------------


def series_14(t, amplitude):
    """(14) at its printed base frequency: acceleration of sum over i = 1..5 of A sin + A/2 cos."""
    w = 5 * np.pi * np.arange(1, 6)[:, None]
    return -(w**2 * (amplitude * np.sin(w * t) + amplitude / 2 * np.cos(w * t))).sum(axis=0)


def test_what_the_printed_excitation_asks_for(results):
    asked = {(p["joint"], p["quantity"]): abs(p["peak"]) for p in results["excitation"]["asked"]}
    t = np.linspace(0, 0.4, 40001)
    for joint, amplitude in (("knee", 0.2), ("ankle", 0.1)):
        assert asked[joint, "acceleration"] == pytest.approx(np.abs(series_14(t, amplitude)).max(), rel=1e-6)
    assert results["excitation"]["printed_base_hz"] == 2.5


def test_every_plan_is_slower_and_within_the_limits(results):
    plans = results["excitation"]["planned"]
    assert len(plans) == 8
    for plan in plans.values():
        assert plan["base_hz"] == pytest.approx(2.5 * plan["speed"]) and plan["speed"] < 1
        assert max(p["excess"] for p in plan["peaks"]) <= 0
        nearest = max(abs(p["peak"]) / abs(p["limit"]) for p in plan["peaks"])
        assert nearest == pytest.approx(1, abs=0.01)  # and no slower than it must be


def test_drawn_phases_keep_the_amplitudes(results):
    printed, drawn, other = bench.series(), bench.series(3), bench.series(4)
    for j in range(2):
        for i in range(5):
            size = math.hypot(printed.sine[j][i], printed.cosine[j][i])
            assert math.hypot(drawn.sine[j][i], drawn.cosine[j][i]) == pytest.approx(size, rel=1e-12)
            assert drawn.sine[j][i] != other.sine[j][i]


# ---- the legs and what was identified ----------------------------------------------------


def leaves(tree, path=()):
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from leaves(value, (*path, key))
        else:
            yield (*path, key), value


def test_the_leg_as_built_differs_as_far_as_said(folder):
    drawn = dict(leaves(bench.design()))
    built = dict(leaves(yaml.safe_load((folder / "recordings/truth.yaml").read_text(encoding="utf-8"))))
    assert drawn.keys() == built.keys()
    changed = {path for path in drawn if drawn[path] != built[path]}
    assert len(changed) == 10
    for path in changed:
        off = abs(built[path] / drawn[path] - 1) / bench.SPREAD[path[-1]]
        assert 0.5 <= off <= 1 + 1e-12


def test_three_names_stand_for_two_numbers(results):
    unknown = {name for name, of in results["identification"]["parameters"].items() if not of["identifiable"]}
    assert unknown == {"ankle_motor_com_m", "shank_com_m", "shank_inertia_kg_m2"}
    values = results["identifiability"]["singular_values"]
    assert len(values) == 10 and values[9] < 1e-12 * values[0] < 1e-6 * values[8]


def test_the_other_leg_has_the_same_inertia_and_moment(results):
    i, mass = results["identifiability"], bench.design()
    shank, motor = mass["shank"]["mass_kg"], mass["ankle_motor"]["mass_kg"]

    def of(p):
        ds, dma, inertia = p["shank_com_m"], p["ankle_motor_com_m"], p["shank_inertia_kg_m2"]
        return shank * ds + motor * dma, inertia + shank * ds**2 + motor * dma**2

    assert of(i["same_torque_leg"]) == pytest.approx(of(i["truth"]), rel=1e-12)
    assert i["same_torque_leg"]["ankle_motor_com_m"] == pytest.approx(1.2 * i["truth"]["ankle_motor_com_m"])
    assert i["largest_difference_Nm"] < 1e-14


def test_identified_parameters_come_near_the_truth(results):
    """On 3 x 16 s; the foot's inertia is the weakest (its standard deviation is some per cent)."""
    deviation = results["identification"]["deviation_percent"]
    for name, percent in deviation.items():
        assert abs(percent) < (10 if name.startswith("foot") else 2), name
    ratio = results["identification"]["cost"] / results["identification"]["least_squares_cost"]
    assert 1 - 1e-9 <= ratio < 1 + 1e-9


# ---- errors ----------------------------------------------------------------------------


@pytest.mark.parametrize("case", ["cad", "identified", "truth"])
def test_errors_are_the_scored_ones(folder, results, case):
    recording, predicted = table_of(folder, "unseen.csv"), table_of(folder, f"{case}_predicted.csv")
    model = talus.Model.read(bench.DESIGN)
    unseen = talus.Recording({name: recording[name] for name in recording.dtype.names})
    speed = talus.Regression(model, unseen).motion()["speed"]
    for j, joint in enumerate(JOINTS):
        measured = 0.1031 * recording[f"{joint}_current_A"]
        expected = score(recording["time_s"], measured, predicted[f"{joint}_motor_torque_Nm"], speed[j])
        found = results["errors"][case][joint]
        assert found["rms_Nm"] == pytest.approx(expected[0], rel=1e-6)
        assert found["relative_percent"] == pytest.approx(expected[2], rel=1e-6)


def test_identification_beats_the_drawing_and_the_noise_bounds_it(results):
    errors = results["errors"]
    for joint in JOINTS:
        cad, found, noise = (errors[case][joint]["rms_Nm"] for case in ("cad", "identified", "noise_alone"))
        assert noise < found < 0.5 * cad
        assert results["reduction_percent"][joint] == pytest.approx(100 * (1 - found / cad))
        assert found < 1.05 * errors["truth"][joint]["rms_Nm"]


# ---- the linkage -------------------------------------------------------------------------


def closed_form(q):
    """Motor angle and ratio by the linkage's equations, AB = 90, BO = 40, AC = 35 mm, BOF = 84.75 deg."""
    ab, bo, ac, lead, bof = 0.090, 0.040, 0.035, 0.002, math.radians(84.75)

    def nut(phi):
        return bo * np.cos(phi) + np.sqrt(ab**2 - (ac - bo * np.sin(phi)) ** 2)

    phi = math.pi - bof - q
    reach = ac - bo * np.sin(phi)
    ratio = bo * np.sin(phi) - reach * bo * np.cos(phi) / np.sqrt(ab**2 - reach**2)
    return 2 * math.pi / lead * (nut(phi) - nut(math.pi - bof)), 2 * math.pi / lead * ratio


def test_table_2_gives_back_the_linkage(results):
    q = np.radians(np.linspace(-30, 30, 3001))
    motor, ratio = closed_form(q)
    for fit in results["linkage"]["fits"]:
        turns = np.outer(q, np.arange(1, fit["order"] + 1)) * fit["omega_1_rad"]
        a, b = np.array(fit["a"]), np.array(fit["b"])
        assert len(a) == fit["order"] + 1 and len(b) == fit["order"]
        series = a[0] + np.cos(turns) @ a[1:] + np.sin(turns) @ b
        weights = np.arange(1, fit["order"] + 1) * fit["omega_1_rad"]
        slope = np.cos(turns) @ (weights * b) - np.sin(turns) @ (weights * a[1:])
        assert np.abs(series - motor).max() <= fit["motor_error_rad"] + 1e-12
        assert np.abs(slope / ratio - 1).max() <= fit["ratio_error"] + 1e-12
    errors = [fit["ratio_error"] for fit in results["linkage"]["fits"]]
    assert max(errors) < published.RATIO_ERROR


def test_omega_of_the_published_error_reaches_it(results):
    model = talus.Model.read(bench.DESIGN)
    reference = linkage.ankle_drive(model)
    for order, omega in results["linkage"]["omega_of_published_error_1_rad"].items():
        error = linkage.error(linkage.fit(reference, int(order), omega, omega), reference)[1]
        assert error == pytest.approx(published.RATIO_ERROR, rel=0.05)


# ---- slips -------------------------------------------------------------------------------


def rows_of(model, folder):
    table = table_of(folder, "train1.csv")
    return slips.Prepared(model, {name: np.ascontiguousarray(table[name]) for name in table.dtype.names})


def test_all_slips_together_are_the_librarys_paper_form(folder):
    """Here Lagrange's columns and what the slips change of them, there the print's own equations. They differ
    only around stops, where the library bridges the whole row, by what the filter leaves of that."""
    lagrange, paper = talus.Model.read(bench.DESIGN), talus.Model.read(bench.DESIGN)
    paper.struct.form = lib.TL_FORM_PAPER
    ours = slips.Rows([rows_of(lagrange, folder)], slips.SLIPS).joint
    theirs = slips.Rows([rows_of(paper, folder)]).joint
    for (x, y), (x_paper, y_paper) in zip(ours, theirs):
        np.testing.assert_allclose(y, y_paper, atol=1e-15)
        size = np.sqrt((x_paper**2).mean(axis=0))
        difference = np.abs(x - x_paper)
        assert np.all(np.sqrt((difference**2).mean(axis=0)) <= 0.02 * size)
        assert np.all(np.median(difference, axis=0) <= 1e-3 * size)


def test_each_slip_moves_what_it_should(folder):
    model = talus.Model.read(bench.DESIGN)
    prepared = rows_of(model, folder)
    base = list(model.base)
    correct = slips.Rows([prepared]).joint
    moved = {}
    for slip in slips.SLIPS:
        changed = slips.Rows([prepared], (slip,)).joint
        moved[slip] = {
            (joint, base[k])
            for joint, (x, _), (x0, _) in zip(JOINTS, changed, correct)
            for k in range(len(base))
            if not np.array_equal(x[:, k], x0[:, k])
        }
    friction = {"ankle_coulomb", "ankle_viscous"}
    assert moved["rotor"] == {("ankle", "ankle_rotor_inertia")}
    assert moved["sign"] == {("knee", name) for name in friction}
    assert moved["speed"] == {("ankle", name) for name in friction}


def test_the_programs_agree_on_the_print(results):
    """form: paper by talus-identify and talus-predict, against the slips of this page."""
    for kind in ("train", "printed"):
        ours, theirs = (results["slips"][name][kind]["other_phases_rms_Nm"] for name in ("all", "paper_form"))
        for joint in JOINTS:
            assert ours[joint] == pytest.approx(theirs[joint], rel=0.05)


def test_no_slip_predicts_better_than_the_correct_equations(results):
    correct = results["slips"]["none"]["train"]["other_phases_rms_Nm"]
    for name in (*slips.SLIPS, "all"):
        wrong = results["slips"][name]["train"]["other_phases_rms_Nm"]
        assert max(wrong[j] / correct[j] for j in JOINTS) > 2
        assert min(wrong[j] / correct[j] for j in JOINTS) > 0.98
    assert results["slips"]["none"]["train"]["other_phases_rms_Nm"]["knee"] == pytest.approx(
        results["errors"]["identified"]["knee"]["rms_Nm"], rel=0.01
    )


# ---- settings ------------------------------------------------------------------------------


def test_the_papers_settings_cost_what_the_page_says(results):
    s = results["settings"]
    default = s["default"]
    assert default["errors"] == results["errors"]["identified"]
    for joint in JOINTS:
        assert (
            s["paper_window"]["errors_own_window"][joint]["rms_Nm"] > 2 * default["errors"][joint]["rms_Nm"]
        )
    for name in ("foot_moment", "foot_inertia"):
        assert s["weights"]["base_sigma"][name] > 1.3 * default["base_sigma"][name]


def test_the_same_run_gives_the_same_bytes(folder, tmp_path):
    again = make_page(tmp_path)
    for name in ("paper.json", "index.html"):
        assert (folder / name).read_bytes() == (again / name).read_bytes()
