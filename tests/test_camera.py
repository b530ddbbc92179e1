"""The check of what a camera adds (tools/talus/known): the draw, the benches, and every figure on reports made by hand."""

import json

import numpy as np
import pytest
import yaml

from talus.known import camera, camera_scores, running
from talus.known.command import main

# ---- the draw and the benches ----------------------------------------------------------


def test_causes_come_in_turn_and_do_not_depend_on_the_count():
    cases = camera.draw(3, 15)
    assert [case.effect for case in cases] == [*camera.CAUSES, *camera.CAUSES, "encoder_offset"]
    assert len({case.name for case in cases}) == 15 and cases[:4] == camera.draw(3, 4)
    assert cases[0].drawn() == camera.draw(3, 1)[0].drawn() != camera.draw(4, 1)[0].drawn()


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(camera, "LENGTH_S", 3)


def test_every_bench_can_be_simulated(short, tmp_path):
    for case in [*camera.draw(1, 7), *(case for case in camera.draw(2, 40) if case.effect == "base_compliance")]:
        columns = camera.filmed(case, *case.drawn(), tmp_path)
        assert {"shank_rad", "foot_rad", "ankle_joint_rad"} <= set(columns) and np.isfinite(list(columns.values())).all()


def mean_off(case, folder):
    """Of the camera's shank angle less the knee encoder's [rad], and the cause."""
    cause, seed = case.drawn()
    columns = camera.filmed(case, cause, seed, folder)
    return np.mean(columns["shank_rad"] - columns["knee_motor_rad"] / 51), cause


def test_a_camera_sees_an_encoders_zero_and_no_tilt(short, tmp_path):
    """750 pictures of 1 mrad: their mean is known to 0.04 mrad, and tracks the cause."""
    offset, tilt = camera.draw(5, 2)
    off_rad, cause = mean_off(offset, tmp_path)
    assert off_rad == pytest.approx(-cause.offset_rad, abs=2e-4) and abs(cause.offset_rad) >= 0.005
    assert abs(mean_off(tilt, tmp_path)[0]) < 2e-4


def test_a_torque_constant_is_the_true_models():
    case = camera.draw(1, 5)[4]
    cause, _ = case.drawn()
    true, given = yaml.safe_load(camera.true_model(case.effect, cause)), yaml.safe_load(camera.model_of("leg").read_text())
    (factor,) = cause.scale.values()
    assert true[cause.joint]["torque_constant_Nm_A"] == pytest.approx(factor * given[cause.joint]["torque_constant_Nm_A"])
    assert "effects" not in true and abs(factor - 1) >= 0.03


# ---- every figure, by hand -------------------------------------------------------------


def report(effect, joint, probability, *confusable, withheld=False, encoder=None):
    """One that talus-gap might have given; `encoder`: how likely a tilt is the encoder's zero."""
    groups = [{"effects": [effect, *confusable], "joint": joint}] if confusable else []
    verdict = {"effect": effect, "joint": joint, "probability": probability, "withheld": withheld}
    source = {"bench": None if encoder is None else 1 - encoder, "encoder": encoder, "camera_less_encoder_rad": 0.0}
    listed = [{"effect": effect, "source": source}] if effect == "gravity_tilt" else []
    return {"verdict": verdict, "confusable": groups, "effects": listed}


def result(effect, joint, without, with_camera, mean_mrad=0.0):
    return {"case": f"000-{effect}", "effect": effect, "joint": joint, "size": "some", "without": without, "report": with_camera,
            "camera_less_knee_mrad": mean_mrad}  # fmt: skip


def every_kind():
    linkage, tilt = report("linkage_error", "ankle", 0.99), report("gravity_tilt", "base", 0.99)
    return [
        result("linkage_error", "ankle", report("linkage_error", "ankle", 0.6, "encoder_eccentricity"), linkage),
        result("linkage_error", "ankle", linkage, report("linkage_error", "ankle", 0.99, withheld=True)),
        result("elasticity", "knee", report("elasticity", "ankle", 0.9), report("elasticity", "knee", 0.9)),
        result("torque_constant", "knee", None, report("none", "none", 0.9)),
        result("gravity_tilt", "base", tilt, tilt, 0.02),
        result("encoder_offset", "knee", tilt, tilt, -40.0),
    ]


def test_a_case_by_hand():
    rows = [camera_scores.judge(one) for one in every_kind()]
    answers = [tuple(row[f"{what}_{when}"] for when in ("without", "with") for what in ("exact", "alone")) for row in rows]
    no, yes = False, True
    assert answers == [(yes, no, yes, yes), (yes, yes, yes, no), (no, no, yes, yes), (no, no, yes, yes),
                       (yes, no, yes, no), (no, no, no, no)]  # fmt: skip
    assert rows[0]["without"] == "linkage_error 0.60 or encoder_eccentricity" and rows[3]["without"] == "failed"
    assert rows[4]["with"] == "gravity_tilt 0.99 or encoder_offset"


@pytest.mark.parametrize("encoder, cause, alone", [(0.01, "gravity_tilt", True), (0.2, "gravity_tilt", False), (0.6, "encoder_offset", False),
                                                   (0.99, "encoder_offset", True)])  # fmt: skip
def test_a_tilt_is_what_the_camera_says_it_is(encoder, cause, alone):
    found = report("gravity_tilt", "base", 0.9, encoder=encoder)
    other = {"gravity_tilt": "encoder_offset", "encoder_offset": "gravity_tilt"}[cause]
    truth = cause, {"gravity_tilt": "base", "encoder_offset": "knee"}[cause]
    assert camera_scores.read(found, truth) == (f"{cause} 0.90" + ("" if alone else f" or {other}"), True, alone,
                                                      [] if alone else [other])
    assert camera_scores.read(found, (other, "base"))[1:3] == (False, False)


@pytest.mark.parametrize("verdict, right, wrong", [(("none", "none", 0.9), True, False), (("unknown", "none", 0.9), False, False),
                                                   (("torque_constant", "knee", 0.9), False, True), (("load_friction", "knee", 0.9), False, True),
                                                   (("load_friction", "knee", 0.45), False, False)])  # fmt: skip
def test_identification_takes_up_a_torque_constant(verdict, right, wrong):
    row = camera_scores.judge(result("torque_constant", "knee", None, report(*verdict)))
    assert (row["exact_with"], row["wrong_with"]) == (right, wrong)


def test_bars_and_causes_by_hand():
    rows = [camera_scores.judge(one) for one in every_kind()]
    bars = {bar.name: (bar.value, bar.count, bar.met) for bar in camera_scores.bars(rows)}
    assert list(bars.values()) == [(1 / 6, 6, None), (3 / 6, 6, None), (3 / 5, 5, False), (1 / 2, 4, False), (1.0, 1, False), (0.0, 6, True), (1.0, 2, None)]
    assert camera_scores.by_cause(rows)[3] == {"effect": "torque_constant", "cases": 1, "exact_without": 0, "alone_without": 0,
                                               "exact_with": 1, "alone_with": 1}  # fmt: skip
    assert [group["cases"] for group in camera_scores.by_cause(rows)] == [1, 1, 1, 1, 2]


def test_the_command(short, tmp_path, monkeypatch, capsys):
    """Both recordings differ by the camera's columns alone."""
    heads, asked = [], []

    def diagnosed(model, recording, folder, *options):
        asked.append(options)
        heads.append(recording.read_text().splitlines()[0].split(","))
        return {"status": 0, "report": report("gravity_tilt", "base", 0.9)}

    monkeypatch.setattr(running, "diagnosed", diagnosed)
    assert main(["camera", "--count", "2", "--out", str(tmp_path)]) == 0
    assert set(heads[1]) - set(heads[0]) == {"shank_rad", "foot_rad"} and heads[0] == heads[2]
    assert asked == [(), ("--camera-zero", "0.002")] * 2
    found = json.loads((tmp_path / "camera.json").read_text())
    assert [row["effect"] for row in found["cases"]] == ["encoder_offset", "gravity_tilt"]
    assert found["bars"][-1]["value"] == 1.0 and "gravity_tilt 0.90 or encoder_offset" in capsys.readouterr().out
    assert "0 causes are named exactly and alone" in (tmp_path / "camera.html").read_text()
