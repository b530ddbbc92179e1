"""tools/talus/diagnosis/tilt_source.py: a bench that leans or an encoder's zero, by a camera whose zero is known."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm
from support import REPOSITORY, run

import talus
from talus.diagnosis import command, tilt_source
from talus.diagnosis.effects import EFFECTS
from talus.known import camera

LEG = REPOSITORY / "models/leg.yaml"
TILT_RAD, ZERO_RAD = 0.03, 0.002


# ---- the formula -----------------------------------------------------------------------


@pytest.mark.parametrize("mean, tilt, deviation", [(0.001, 0.005, 0.001), (0.004, 0.005, 0.003), (-0.002, -0.004, 1e-4)])
def test_the_formula_is_that_of_two_normal_distributions(mean, tilt, deviation):
    bench, encoder = tilt_source.likelihoods(mean, tilt, deviation, ZERO_RAD)
    wanted = norm.logpdf(mean, tilt, math.hypot(ZERO_RAD, deviation)) - norm.logpdf(mean, 0.0, ZERO_RAD)
    assert encoder - bench == pytest.approx(wanted, rel=1e-9)


@pytest.fixture
def seen(monkeypatch):
    """A search and a fit in which the camera's mean and a tilt are given."""

    def made(mean, tilt=None, zero_rad=ZERO_RAD):
        monkeypatch.setattr(tilt_source, "camera_less_encoder_rad", lambda search, fit: mean)
        monkeypatch.setattr(tilt_source, "standard_errors", lambda search, fit: [[1e-4]])
        chosen = [] if tilt is None else [SimpleNamespace(effect="gravity_tilt")]
        return SimpleNamespace(camera_zero_rad=zero_rad, dataset=SimpleNamespace(effects=EFFECTS)), SimpleNamespace(chosen=chosen, strengths=[[tilt]])

    return made


def test_what_is_as_likely_by_the_camera_stays_open(seen):
    found = tilt_source.of(*seen(0.5 * TILT_RAD, TILT_RAD))
    assert found["encoder"] == pytest.approx(0.5, abs=0.1) and found["bench"] + found["encoder"] == pytest.approx(1.0)


def test_probabilities_are_right_as_often_as_they_say(seen):
    """20,000 benches of either kind, with tilts about as large as the camera's zero is known."""
    rng = np.random.default_rng(1)
    tilts, zeros, encoder = rng.normal(0, 2 * ZERO_RAD, 20000), rng.normal(0, ZERO_RAD, 20000), rng.uniform(size=20000) < 0.5
    said = np.array([tilt_source.of(*seen(zero + off * tilt, tilt))["encoder"] for tilt, zero, off in zip(tilts, zeros, encoder)])
    for low in (0.0, 0.2, 0.4, 0.6, 0.8):
        some = (said >= low) & (said < low + 0.2)
        assert np.mean(encoder[some]) == pytest.approx(np.mean(said[some]), abs=4 * 0.5 / math.sqrt(some.sum()))


def test_a_cause_that_tilts_nothing_must_let_camera_and_encoder_agree(seen):
    tilted, other = tilt_source.witness(*seen(TILT_RAD, TILT_RAD)), tilt_source.witness(*seen(TILT_RAD))
    assert tilted - other == pytest.approx(0.5 * (TILT_RAD / ZERO_RAD) ** 2 + math.log(0.5), abs=0.01)
    assert tilt_source.witness(*seen(0.0, TILT_RAD)) - tilt_source.witness(*seen(0.0)) == pytest.approx(math.log(0.5), abs=1e-6)


def test_without_a_camera_or_its_zero_nothing_is_said(seen):
    assert tilt_source.of(*seen(None, TILT_RAD)) is None and tilt_source.of(*seen(TILT_RAD)) is None
    assert tilt_source.witness(*seen(None)) == tilt_source.witness(*seen(TILT_RAD, TILT_RAD, None)) == 0.0
    found = tilt_source.of(*seen(TILT_RAD, TILT_RAD, None))
    assert found["encoder"] is found["bench"] is None and "--camera-zero" in tilt_source.words(found)


# ---- whole diagnoses -------------------------------------------------------------------


def bench(folder, cause):
    """The recording of a bench with a camera, and what is wrong with it."""
    case = camera.Case(1, list(camera.CAUSES).index(cause))
    wrong = {"gravity_tilt": camera.Cause("base", "", {"tilt_rad": TILT_RAD}), "encoder_offset": camera.Cause("knee", "", offset_rad=TILT_RAD)}
    path = folder / "run.csv"
    camera.write_columns(path, camera.filmed(case, wrong[cause], 4, folder))
    return path


@pytest.mark.long
@pytest.mark.parametrize("cause, source, off_rad", [
    ("gravity_tilt", "bench", 0.0), ("encoder_offset", "encoder", -TILT_RAD)])  # fmt: skip
def test_the_report_says_which_it_is(cause, source, off_rad, tmp_path):
    """The twin's camera is aligned with the bench. A leaning bench could be a current's zero, an encoder's not: the camera saw it."""
    path = bench(tmp_path, cause)
    said = run("talus-gap", "--quick", "--model", LEG, "--report", tmp_path / "gap.json", "--html", tmp_path / "gap.html",
               "--camera-zero", ZERO_RAD, path).stderr  # fmt: skip
    report = json.loads((tmp_path / "gap.json").read_text())
    (effect,) = report["effects"]
    assert effect["effect"] == "gravity_tilt" and abs(effect["parameters"]["tilt_rad"]) == pytest.approx(TILT_RAD, rel=0.05)
    assert effect["source"][source] > 0.99 and effect["source"]["camera_less_encoder_rad"] == pytest.approx(off_rad, abs=2e-4)
    assert source == "bench" or (report["confusable"] == [] and report["verdict"]["probability"] > 0.99)
    words = {"bench": "the bench leans", "encoder": "the encoder's zero is off"}[source]
    assert words in said and words.replace("'", "&#x27;") in (tmp_path / "gap.html").read_text()


@pytest.mark.parametrize("given, wanted", [({}, None), ({"camera_zero_rad": ZERO_RAD}, ZERO_RAD)])
def test_python_takes_the_cameras_zero(given, wanted, monkeypatch):
    class Seen(Exception):
        pass

    def diagnose(options, *_):
        raise Seen(options.camera_zero_rad)

    monkeypatch.setattr(command, "diagnose", diagnose)
    with pytest.raises(Seen) as seen:
        talus.diagnose(LEG, "run.csv", **given)
    assert seen.value.args == (wanted,)


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "far"])
def test_a_zero_that_is_no_angle_is_refused(text, tmp_path):
    line = run("talus-gap", "--model", LEG, "--report", tmp_path / "gap.json", f"--camera-zero={text}", "run.csv", status=2).stderr
    assert f"--camera-zero: expected an angle in rad above 0, found '{text}'" in line
