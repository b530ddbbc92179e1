"""Results in Python: arrays, data frames, pictures; their numbers are the programs' own."""

import importlib
import json
import os
import pickle
import subprocess
import sys

import matplotlib
import numpy
import pandas
import pytest
import talus
from support import BUILD, REPOSITORY, run

matplotlib.use("Agg")
PENDULUM, LEG = REPOSITORY / "models/pendulum.yaml", REPOSITORY / "models/leg.yaml"
STRIBECK = "\neffects: [{effect: stribeck, joint: joint, parameters: {extra_Nm: 0.3, speed_rad_s: 0.2, exponent: 1}}]\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Recordings of an arm, with a gap, and of a leg; and what talus-predict says of them."""
    there = tmp_path_factory.mktemp("results")
    for name, model, seconds in (("arm", PENDULUM, 20), ("leg", LEG, 12)):
        run("talus-sim", "--model", model, "--out", there / f"{name}.csv", "--duration", seconds, "--seed", 3)
        run("talus-predict", "--model", model, "--out", there / f"{name}_predicted.csv", "--report", there / f"{name}.json", there / f"{name}.csv")
    return there


@pytest.fixture(scope="module")
def diagnosis():
    truth = talus.Model.from_text(PENDULUM.read_text() + STRIBECK)
    return talus.diagnose(PENDULUM, [talus.simulate(truth, duration_s=30, seed=3), talus.simulate(truth, duration_s=20, seed=4)])


def rms(values):
    return float(numpy.sqrt(numpy.mean(values**2)))


def close(figures):
    """Of the libraries' windows, so that a test leaves none."""
    for figure in figures:
        importlib.import_module("matplotlib.pyplot").close(figure)


@pytest.mark.parametrize(("name", "model"), [("arm", PENDULUM), ("leg", LEG)])
def test_a_comparison_has_the_numbers_of_talus_predict(name, model, folder):
    found = talus.compare(talus.Model.read(model), talus.Recording.read(folder / f"{name}.csv"))
    written = [line.split(",") for line in (folder / f"{name}_predicted.csv").read_text().splitlines()[1:]]
    assert [float(row[0]) for row in written] == found.t.tolist()
    as_written = [[float(f"{x:.12g}") for x in row] for row in found.predicted.T]  # with the digits of the file
    assert as_written == [[float(word) for word in row[1:]] for row in written]
    for joint, error in json.loads((folder / f"{name}.json").read_text())["error"].items():
        for key in ("rms", "measured_rms", "relative_percent", "samples"):
            assert found.error[joint][key] == pytest.approx(error[key], rel=1e-9), key
    assert numpy.array_equal(numpy.asarray(found), found.predicted) and numpy.array_equal(found.residual, found.measured - found.predicted)


def test_the_measured_series_of_a_leg_is_its_current_times_the_torque_constant(folder):
    model, recording = talus.Model.read(LEG), talus.Recording.read(folder / "leg.csv")
    constants = [model.struct.drive[j].torque_constant_Nm_A for j in range(2)]
    shown = [k * recording.columns[f"{joint}_current_A"] for k, joint in zip(constants, model.joints, strict=True)]
    numpy.testing.assert_allclose(talus.compare(model, recording).measured, shown, rtol=1e-15)


@pytest.mark.long
def test_panels_of_a_diagnosis_give_the_figures_of_its_report(diagnosis):
    gap = diagnosis.report["gap"]["joint"]
    assert [panel.recording for panel in diagnosis.panels] == ["recording-1.csv", "recording-2.csv"]
    for name in ("nominal", "identified", "extended"):
        left = numpy.concatenate([panel.residual(name)[panel.scored] for panel in diagnosis.panels])
        assert rms(left) == pytest.approx(gap[f"{name}_rms"], rel=1e-12)
    shown = numpy.concatenate([panel.measured[panel.scored] for panel in diagnosis.panels])
    assert rms(shown) == pytest.approx(gap["measured_rms"], rel=1e-12)
    assert gap["extended_rms"] < 0.7 * gap["identified_rms"]


def test_panels_of_a_diagnosis_are_parted_where_the_recording_is(diagnosis):
    for panel in diagnosis.panels:
        gaps = numpy.flatnonzero(numpy.isnan(panel.measured))
        assert gaps[-1] == len(panel.t) - 1 and not panel.scored[gaps].any()
        assert (numpy.diff(panel.t) >= 0).all()


def test_a_diagnosis_that_is_withheld_has_no_panel():
    model = talus.Model.read(PENDULUM)
    still = {"time_s": numpy.arange(2000) / 250, "joint_rad": numpy.zeros(2000), "joint_current_A": numpy.zeros(2000)}
    withheld = talus.diagnose(model, talus.Recording(still))
    assert withheld.panels == [] and withheld.report["verdict"]["withheld"]
    close([withheld.plot()])


def test_results_are_data_frames(diagnosis, folder):
    arm = talus.Recording.read(folder / "arm.csv")
    frame = arm.to_pandas()
    assert list(frame) == list(arm.columns) and talus.Recording(frame) == arm
    table = talus.identify(talus.Model.read(PENDULUM), [arm]).to_pandas()
    assert list(table) == ["value", "sigma", "identifiable"] and table.loc["coulomb_Nm", "value"] > 0
    compared = talus.compare(talus.Model.read(PENDULUM), arm).to_pandas()
    numpy.testing.assert_array_equal(compared["joint_measured_Nm"] - compared["joint_predicted_Nm"], compared["joint_residual_Nm"])
    rows = diagnosis.to_pandas()
    assert set(rows["recording"]) == {"recording-1.csv", "recording-2.csv"} and len(rows) == sum(len(p.t) for p in diagnosis.panels)
    left = (rows["measured"] - rows["extended"])[rows["scored"]]
    assert rms(left) == pytest.approx(diagnosis.gap["joint"]["extended_rms"], rel=1e-12)
    assert list(pandas.DataFrame(diagnosis.effects)["effect"]) == [e["effect"] for e in diagnosis.effects]


def drawn(plot):
    """{label: y} of a plot's lines."""
    return {line.get_label(): line.get_ydata() for line in plot.lines}


def test_results_draw_their_own_numbers(diagnosis, folder, tmp_path):
    model, arm = talus.Model.read(PENDULUM), talus.Recording.read(folder / "arm.csv")
    fit, compared, panel = talus.identify(model, [arm]), talus.compare(model, arm), diagnosis.panels[0]
    figures = [result.plot() for result in (arm, fit, compared, panel, diagnosis)]
    assert numpy.array_equal(drawn(figures[0].axes[0])["joint_rad"], arm.columns["joint_rad"])
    widths = [bar.get_width() for bar in figures[1].axes[0].patches]
    known = [name for name in fit.parameters if fit.identifiable[name]]
    assert widths == [300 * fit.sigma[name] / abs(fit.parameters[name]) for name in known]
    assert numpy.array_equal(drawn(figures[2].axes[0])["predicted"], compared.predicted[0])
    assert numpy.array_equal(drawn(figures[3].axes[1])["extended"], panel.residual("extended"), equal_nan=True)
    assert [bar.get_width() for bar in figures[4].axes[0].patches] == [
        diagnosis.gap["joint"][f"{name}_rms"] for name in ("nominal", "identified", "extended", "noise_floor")]  # fmt: skip
    figures[4].savefig(tmp_path / "gap.png")
    assert (tmp_path / "gap.png").read_bytes().startswith(b"\x89PNG")
    close(figures)


def test_results_pickle_and_compare(diagnosis, folder):
    model, arm = talus.Model.read(PENDULUM), talus.Recording.read(folder / "arm.csv")
    for one in (talus.compare(model, arm), *diagnosis.panels, diagnosis):
        again = pickle.loads(pickle.dumps(one))  # noqa: S301  our own
        assert again == one and repr(again) == repr(one) and one != model
    other = pickle.loads(pickle.dumps(diagnosis))  # noqa: S301
    other.panels[0].measured[3] += 1e-9
    assert other != diagnosis


@pytest.mark.parametrize(("package", "use", "extra"), [("pandas", "to_pandas", "frame"), ("matplotlib", "plot", "plot")])
def test_what_is_missing_is_named_in_one_line(package, use, extra, monkeypatch):
    recording = talus.Recording({"time_s": [0.0, 0.1], "joint_rad": [0.0, 0.1]})
    for name in [package, *(name for name in sys.modules if name.startswith(f"{package}."))]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError) as raised:
        getattr(recording, use)()
    assert str(raised.value) == f"{package} is not there; pip install {package}, or 'talus[{extra}]'"


def test_talus_itself_needs_neither():
    """Of what is heavy nothing is loaded before it is asked for."""
    code = "import sys, talus; print([name for name in ('pandas', 'matplotlib', 'scipy') if name in sys.modules])"
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY / "tools"), "TALUS_BUILD": str(BUILD)}
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, env=environment)
    assert done.stdout == "[]\n"
