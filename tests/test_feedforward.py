"""talus-feedforward --twin: what a model's feedforward brings a bench in lock-step, beside none, a CAD model's and, where an
effect was hidden in the bench, the plain model's. The bench is the twin, whose mechanics test_simulate.py holds to others."""

import json
import math
import re

import pytest
import yaml
from support import REPOSITORY, run

MODELS = REPOSITORY / "models"
GAIT = MODELS / "gait.csv"
JOINTS = ("knee", "ankle")
HIDDEN = {
    "asymmetric_friction": ("knee", "{coulomb_Nm: 0.3, viscous_Nms_rad: 0.1}"),
    "gravity_tilt": ("base", "{tilt_rad: 0.05}"),
}


def compare(folder, truth, *models):
    """{"none" or a model's file name: its run}, each run {joint: figures}."""
    run("talus-feedforward", "--twin", truth, "--play", GAIT, "--report", folder / "r.json", *models)
    runs = json.loads((folder / "r.json").read_text())["runs"]
    return {(one["model"] or "none").rsplit("/", 1)[-1]: one for one in runs}


def bench(folder, effect=None):
    """(model of the bench, a recording of it) with an effect hidden in it."""
    truth, recording = folder / "truth.yaml", folder / "bench.csv"
    hidden = f"effects:\n  - {{effect: {effect}, joint: {HIDDEN[effect][0]}, parameters: {HIDDEN[effect][1]}}}\n" if effect else ""
    truth.write_text((MODELS / "leg_bench.yaml").read_text() + hidden)
    run("talus-sim", "--model", truth, "--out", recording, "--duration", 40)
    return truth, recording


def identified(folder, recording):
    run("talus-identify", "--model", MODELS / "leg_cad.yaml", "--out", folder / "fitted.yaml", recording)
    return folder / "fitted.yaml"


def check_limits(runs):
    """Current at every tick, the drive's and the feedforward's."""
    for one in runs.values():
        assert one["ticks"] == 7000
        for figures in (one[joint] for joint in JOINTS):
            assert 0.0 < figures["peak_current_A"] < figures["current_limit_A"] and figures["ticks_at_limit"] == 0
            assert figures["feedforward_peak_current_A"] <= figures["feedforward_current_limit_A"]


def test_the_identified_model_helps(tmp_path):
    """A quarter of the error without, and 60 % of the CAD model's; of the feedback's share of the torque, too."""
    truth, recording = bench(tmp_path)
    runs = compare(tmp_path, truth, MODELS / "leg_cad.yaml", identified(tmp_path, recording))
    check_limits(runs)
    for joint in JOINTS:
        none, cad, fitted = (runs[name][joint] for name in ("none", "leg_cad.yaml", "fitted.yaml"))
        for figure in ("error_rms_rad", "feedback_share"):
            print(f"{joint} {figure}: {fitted[figure] / none[figure]:.3f} of none, {fitted[figure] / cad[figure]:.3f} of CAD")
            assert fitted[figure] <= 0.25 * none[figure]
            assert fitted[figure] <= 0.60 * cad[figure]


@pytest.mark.parametrize("of_model", [0.7, 1.3])
def test_it_helps_with_other_friction_than_the_models(tmp_path, of_model):
    """Oil that is warm, or cold: less than half of the error without feedforward is left, at the default share of friction."""
    truth = tmp_path / "truth.yaml"
    model = yaml.safe_load((MODELS / "leg_bench.yaml").read_text())
    for joint in (model[name] for name in JOINTS):
        joint["friction"] = {name: of_model * value for name, value in joint["friction"].items()}
    truth.write_text(yaml.safe_dump(model))
    runs = compare(tmp_path, truth, MODELS / "leg.yaml")
    for joint in JOINTS:
        left = runs["leg.yaml"][joint]["error_rms_rad"] / runs["none"][joint]["error_rms_rad"]
        print(f"{joint}, {of_model} of the model's friction: {left:.3f} of none")
        assert left <= 0.5


@pytest.mark.long
@pytest.mark.parametrize("effect", ["asymmetric_friction", "gravity_tilt"])
def test_an_effect_that_was_found_helps_more(tmp_path, effect):
    truth, recording = bench(tmp_path, effect)
    report, extended = tmp_path / "gap.json", tmp_path / "extended.yaml"
    run("talus-gap", "--quiet", "--model", MODELS / "leg_cad.yaml", "--report", report, "--save-model", extended, recording)
    assert json.loads(report.read_text())["verdict"]["effect"] == effect
    runs = compare(tmp_path, truth, identified(tmp_path, recording), extended)
    check_limits(runs)
    for figure in ("error_rms_rad", "feedback_share"):
        plain, more = runs["fitted.yaml"]["knee"][figure], runs["extended.yaml"]["knee"][figure]
        print(f"{effect} {figure}: {more / plain:.3f} of the plain model's")
        assert more <= 0.70 * plain


def test_nothing_is_held_back_within_the_limits(tmp_path):
    """Once the controller has come in, no bit of its status stands; less current, and it says so and keeps to it."""
    status = compare(tmp_path, MODELS / "leg_bench.yaml", MODELS / "leg.yaml")["leg.yaml"]["status_ticks"]
    assert status.pop("zero") < 70 and status.pop("stale measured") <= 6
    assert set(status.values()) == {0}
    options = ("--knee-current", 0.5, "--ankle-current", 0.5, "--report", tmp_path / "weak.json")
    run("talus-feedforward", "--twin", MODELS / "leg_bench.yaml", "--play", GAIT, *options, MODELS / "leg.yaml")
    weak = json.loads((tmp_path / "weak.json").read_text())["runs"][1]
    assert weak["status_ticks"]["torque limit"] > 100
    assert weak["knee"]["feedforward_peak_current_A"] == pytest.approx(0.5, abs=1e-4 / 0.1031)  # a step of the bus's field


def test_the_page_shows_what_the_report_says(tmp_path):
    """The sentence, and lines whose peaks are between what the report says."""
    models = (MODELS / "leg_cad.yaml", MODELS / "leg.yaml")
    run("talus-feedforward", "--twin", MODELS / "leg_bench.yaml", "--play", GAIT, "--report", tmp_path / "r.json",
        "--html", tmp_path / "p.html", *models)  # fmt: skip
    fitted, text = json.loads((tmp_path / "r.json").read_text())["runs"][2], (tmp_path / "p.html").read_text()
    left = [f"{fitted[joint]['error_percent_of_none']:.1f} %" for joint in JOINTS]
    assert f"{left[0]} of the knee&#39;s and {left[1]} of the ankle&#39;s" in text.replace("'", "&#39;")
    charts = json.loads(re.search(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL)[1])
    assert len(charts) == 4  # angle above error, torque above its parts, of both joints
    for joint, (angle, torque) in zip(JOINTS, (charts[:2], charts[2:]), strict=True):
        error, parts = angle["below"], torque["below"]
        assert [s["name"] for s in angle["series"]] == ["measured", "desired"] and angle["title"].startswith(joint)
        assert len(error["series"]) == 3 and [s["name"] for s in torque["series"]] == ["feedforward", "feedback"]
        assert [s["name"] for s in parts["series"]] == ["inertia", "gravity", "friction", "effects"]
        none, _, peak = (max(map(abs, one["y"])) for one in error["series"])
        assert 1e3 * fitted[joint]["error_rms_rad"] <= peak <= 0.25 * none
        assert max(abs(v) for v in torque["series"][0]["y"]) == pytest.approx(0.1031 * fitted[joint]["feedforward_peak_current_A"], rel=0.02)
    (tmp_path / "model.yaml").write_bytes(models[1].read_bytes())
    said = run("talus-feedforward", "--twin", MODELS / "leg_bench.yaml", "--play", GAIT, "--html", "model.yaml", "model.yaml",
               status=2, cwd=tmp_path).stderr  # fmt: skip
    assert "--html" in said and (tmp_path / "model.yaml").read_bytes() == models[1].read_bytes()


def test_the_same_every_time(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        compare(tmp_path / name, MODELS / "leg_bench.yaml", MODELS / "leg_cad.yaml")
    assert (tmp_path / "a/r.json").read_bytes() == (tmp_path / "b/r.json").read_bytes()


def test_the_gait_is_what_its_first_lines_say():
    rows = [line.split(",") for line in GAIT.read_text().splitlines() if not line.startswith("#")][1:]
    assert len(rows) == 351
    for t, knee, ankle in (map(float, row) for row in rows):
        p, w = 2 * math.pi * t / 1.2, (1 - math.cos(math.pi * min(1.0, t, 7 - t))) / 2
        assert knee == pytest.approx(w * (0.05 + 0.45 * math.sin(p) + 0.12 * math.sin(2 * p + 0.6)), abs=6e-7)
        assert ankle == pytest.approx(w * (0.02 + 0.18 * math.sin(p + 2.2) + 0.08 * math.sin(2 * p - 0.4)), abs=6e-7)


COGGING = "effects:\n  - {effect: cogging, joint: knee, parameters: {sine_Nm: 0.01, cosine_Nm: 0, per_turn: 12, fades_Hz: 0}}\n"


@pytest.mark.parametrize(("truth", "change", "options", "words"), [
    ("leg.yaml", "", (), ["leg.yaml", "bus:", "missing key"]),
    ("leg_bench.yaml", COGGING, (), ["model.yaml", "cogging", "knee", "no fast form"]),
    ("leg_bench.yaml", "", ("--speed-lag", 1), ["--speed-lag"]),
    ("leg_bench.yaml", "", ("--knee-current", 0), ["model.yaml", "limit"]),
    ("leg_bench.yaml", "", ("--play", "far.csv"), ["far.csv", "reach"]),
    ("leg_bench.yaml", "", ("--play", "short.csv"), ["short.csv", "rows"]),
])  # fmt: skip
def test_bad_input_is_one_line_and_nothing_is_written(tmp_path, truth, change, options, words):
    (tmp_path / "model.yaml").write_text((MODELS / "leg.yaml").read_text() + change)
    (tmp_path / "far.csv").write_text("time_s,knee_rad,ankle_rad\n0,0,0\n2,1.5,0\n4,0,0\n")
    (tmp_path / "short.csv").write_text("time_s,knee_rad,ankle_rad\n0,0,0\n")
    (tmp_path / "r.json").write_text("as it was")
    play = () if "--play" in options else ("--play", GAIT)
    said = run("talus-feedforward", "--twin", MODELS / truth, *play, *options, "--report", "r.json", "model.yaml",
               status=2, cwd=tmp_path).stderr  # fmt: skip
    lines = [line for line in said.splitlines() if not line.startswith("Try ")]
    assert all(word in lines[0] for word in words) and len(said.splitlines()) <= 2, said
    assert (tmp_path / "r.json").read_text() == "as it was"


@pytest.mark.parametrize(("options", "words"), [
    ((), ["--twin", "--can"]), (("--can", "can0", "--twin", "x"), ["--twin", "--can"]), (("--can", "can0"), ["--out"]),
    (("--can", "can0", "--out", "r"), ["--limits"]), (("--can", "can0", "--out", "r", "--limits", "knee.speed=1", "second.yaml"), ["one MODEL"]),
    (("--twin", "x", "--out", "r"), ["--can"]), (("--can", "can0", "--out", "r", "--limits", "x", "--report", "r.json"), ["--twin"]),
    (("--can", "no-such-bus", "--out", "r", "--limits", "knee.speed=1"), ["no-such-bus", "interface"]),
])  # fmt: skip
def test_what_does_not_go_together_is_refused(tmp_path, options, words):
    said = run("talus-feedforward", "--play", GAIT, *options, MODELS / "leg_bench.yaml", status=2, cwd=tmp_path).stderr
    assert all(word in said for word in words), said
    assert not list(tmp_path.iterdir())
