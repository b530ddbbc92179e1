"""tools/talus: scores and panels against the rule in SciPy and the programs' reports, and pages as the programs'."""

import json

import numpy as np
import pytest
import talus
from scoring_reference import score as reference
from support import REPOSITORY, run
from test_page import NASTY
from test_page import Page as Parsed

MODELS = {plant: REPOSITORY / "models" / f"{plant}.yaml" for plant in ("leg", "pendulum", "slider")}
EFFORT = {"leg": (("knee_current_A", 0.1031), ("ankle_current_A", 0.1031)), "pendulum": (("joint_current_A", 9 * 0.091),),
          "slider": (("slider_force_N", 1.0),)}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    for plant, model in MODELS.items():
        run("talus-sim", "--model", model, "--out", folder / f"{plant}.csv", "--duration", 12)
    return folder


@pytest.mark.parametrize("plant", MODELS)
def test_measured_is_the_effort_column_in_newton_metres(plant, folder):
    recording = talus.Recording.read(folder / f"{plant}.csv")
    shown = talus.measured(talus.Model.read(MODELS[plant]), recording)
    assert shown == pytest.approx(np.array([scale * recording.columns[name] for name, scale in EFFORT[plant]]))


def test_measured_with_a_load_sensor_is_the_load():
    t = np.arange(300) * 0.01
    columns = {"time_s": t, "joint_rad": np.sin(t), "joint_current_A": np.cos(t), "joint_load_Nm": 3 * np.cos(2 * t)}
    model = talus.Model.read(MODELS["pendulum"])
    assert talus.measured(model, talus.Recording(columns)) == pytest.approx(columns["joint_load_Nm"][None, :])


@pytest.mark.parametrize("plant", MODELS)
def test_score_is_the_rule(plant, folder):
    """A made-up prediction, and rows that do not count."""
    model, plain = talus.Model.read(MODELS[plant]), talus.Recording.read(folder / f"{plant}.csv")
    valid = np.ones(len(plain.t))
    valid[1000:1100] = 0
    recording = talus.Recording({**plain.columns, "valid": valid})
    shown = talus.measured(model, recording)
    predicted = 0.9 * shown + 0.01 * np.sin(plain.t)
    speed = np.nan_to_num(talus.Regression(model, recording).motion()["speed"])
    for j, (joint, found) in enumerate(talus.score(model, recording, predicted).items()):
        want = reference(plain.t, shown[j], predicted[j], speed[j], valid)
        got = (found["rms"], found["measured_rms"], found["relative_percent"], found["reversal_rms"])
        assert joint == model.joints[j] and got == pytest.approx(want, rel=1e-9)
        assert found["samples"] > 2000 and found["samples_left_out"] > 0


@pytest.mark.parametrize("plant", MODELS)
def test_panels_show_what_the_report_says(plant, folder):
    """RMS of a panel's residuals under the given and the identified model, and those of R.json."""
    fitted, report = folder / f"{plant}.yaml", folder / f"{plant}.json"
    run("talus-identify", "--model", MODELS[plant], "--out", fitted, "--report", report, folder / f"{plant}.csv")
    models = {"nominal": talus.Model.read(MODELS[plant]), "identified": talus.Model.read(fitted)}
    panels = talus.panels(models, talus.Recording.read(folder / f"{plant}.csv"))
    for panel, (joint, said) in zip(panels, json.loads(report.read_text())["error"].items(), strict=True):
        assert panel.joint == joint and panel.scored.sum() == said["samples"]
        for name in models:
            rms = np.sqrt(np.nanmean(panel.residual(name) ** 2))
            assert rms == pytest.approx(said[f"{name}_rms"], rel=1e-6)


def test_panels_are_parted_where_the_recording_is():
    t = np.concatenate((np.arange(500) * 0.01, 9 + np.arange(500) * 0.01))
    columns = {"time_s": t, "joint_rad": np.sin(3 * t), "joint_torque_Nm": np.cos(3 * t)}
    (panel,) = talus.panels({"m": talus.Model.read(MODELS["pendulum"])}, talus.Recording(columns))
    gaps = np.flatnonzero(np.isnan(panel.measured))
    assert len(gaps) == 2 and 4.9 < panel.t[gaps[0]] < 5.1 and gaps[1] == len(panel.t) - 1
    assert (np.diff(panel.t) >= 0).all() and not panel.scored[gaps].any()


@pytest.mark.parametrize("text", ["Knee", NASTY], ids=["plain", "nasty"])
def test_page(text, tmp_path):
    page, t = talus.Page(text, text), np.linspace(0, 1, 50)
    page.heading(text)
    page.paragraph(text)
    page.table(text, [text, "b"], [[text, "93.5"], ["ankle", text]])
    y = np.where(t > 0.5, np.nan, t)
    page.chart(text, "time [s]", "torque [Nm]", [(text, "measured", t, y)], below=("residual [Nm]", [("r", "residual", t, -y)]))
    page.chart("one", "time [s]", "torque [Nm]", [("a", "nominal", t, t)])
    page.write(tmp_path / "page.html")
    parsed = Parsed((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert parsed.open == []
    for tag in ("title", "h1", "h2", "p", "caption", "th", "td", "figcaption"):
        assert text in parsed.text[tag], tag
    assert len(parsed.of("canvas")) == 3
    (data,) = (script for script in parsed.text["script"] if script.startswith("[{"))
    first, second = json.loads(data, parse_constant=lambda name: pytest.fail(name))
    assert first["title"] == first["series"][0]["name"] == text and "below" not in second
    assert first["series"][0]["y"].count(None) == 25 and first["below"]["series"][0]["role"] == "residual"
    for tag, attributes in parsed.elements:
        for name in ("src", "href", "action", "srcset", "data"):
            assert attributes.get(name, "data:,").startswith("data:"), (tag, attributes)


def test_bars_of_a_page_have_roles_and_stand_side_by_side(tmp_path):
    page = talus.Page("a", "b")
    with page.side_by_side():
        page.bars("knee", "RMS [mNm]", [["as given", "10.0"], "identified"], [10.0, 2.5], ["nominal", "identified"])
        page.bars("ankle", "RMS [mNm]", ["as given"], [1.0])
    page.write(tmp_path / "page.html")
    parsed = Parsed((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert parsed.open == [] and len(parsed.of("canvas")) == 2
    assert [a["class"] for a in parsed.of("div")].count("columns") == 1
    (data,) = (script for script in parsed.text["script"] if script.startswith("[{"))
    knee, ankle = json.loads(data)
    assert knee["values"] == [10.0, 2.5] and knee["roles"] == ["nominal", "identified"] and "roles" not in ankle
    assert knee["labels"] == [["as given", "10.0"], "identified"]


def test_page_of_a_program_and_of_python_draw_alike(folder, tmp_path):
    """The same kinds of parts, in the same elements and classes, as talus-identify writes them."""
    run("talus-identify", "--model", MODELS["slider"], "--out", tmp_path / "f.yaml", "--html", tmp_path / "c.html",
        folder / "slider.csv")  # fmt: skip
    page = talus.Page("a", "b")
    page.table("c", ["d"], [["e"]])
    page.chart("f", "x", "y", [("g", "measured", [0.0, 1.0], [0.0, 1.0])], below=("z", []))
    page.write(tmp_path / "python.html")

    def shapes(file):
        parsed = Parsed((tmp_path / file).read_text(encoding="utf-8"))
        return {(tag, a.get("class"), a.get("scope"), a.get("role")) for tag, a in parsed.elements}

    assert shapes("python.html") - {("td", None, None, None)} <= shapes("c.html")
