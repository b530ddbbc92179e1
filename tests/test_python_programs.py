"""talus.read, simulate and diagnose: what the commands say, as objects that compare, pickle and print themselves."""

import json
import pickle

import pytest
import talus
from support import REPOSITORY, run

PENDULUM = REPOSITORY / "models/pendulum.yaml"


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A recording with Stribeck friction that the model does not have, and what talus-gap says of it."""
    folder = tmp_path_factory.mktemp("programs")
    stribeck = "\neffects: [{effect: stribeck, joint: joint, parameters: {extra_Nm: 0.3, speed_rad_s: 0.2, exponent: 1}}]\n"
    (folder / "truth.yaml").write_text(PENDULUM.read_text() + stribeck)
    run("talus-sim", "--model", folder / "truth.yaml", "--out", folder / "rec.csv", "--duration", 40, "--seed", 3)
    done = run("talus-gap", "--model", PENDULUM, "--report", folder / "gap.json", "--save-model", folder / "found.yaml",
               "--trajectory", folder / "next.csv", folder / "rec.csv")  # fmt: skip
    return folder, done.stderr


@pytest.fixture(scope="module")
def found(bench):
    return talus.diagnose(PENDULUM, bench[0] / "rec.csv")


def plain(report):
    """A report without the name of the trajectory's file."""
    return {**report, "next_experiment": {**report["next_experiment"], "trajectory": None}}


def test_a_diagnosis_is_what_talus_gap_says(bench, found):
    folder, said = bench
    report = json.loads((folder / "gap.json").read_text())
    assert plain(found.report) == plain(report) and found.verdict == report["verdict"] and found.gap == report["gap"]
    assert found.model_text == (folder / "found.yaml").read_text() and found.trajectory == (folder / "next.csv").read_text()
    summary, steps = said.split("\n  1. ")  # the program has the commands of its next steps, which name its files
    assert steps.rstrip().endswith("new.csv") and str(found) == summary and found.verdict["effect"] in repr(found)
    assert len(found.model.effects) == len(found.effects) > 0


@pytest.mark.long
def test_objects_and_files_are_diagnosed_alike_and_results_compare_and_pickle(bench, found, tmp_path):
    folder, _ = bench
    model, recording = talus.read(PENDULUM), talus.read(folder / "rec.csv")
    of_objects = talus.diagnose(model, [recording])
    assert of_objects.verdict == found.verdict and of_objects.gap == found.gap and of_objects.effects == found.effects
    assert pickle.loads(pickle.dumps(of_objects)) == of_objects  # noqa: S301  our own
    of_objects.write(tmp_path / "gap.json")
    assert json.loads((tmp_path / "gap.json").read_text()) == of_objects.report
    assert of_objects != talus.diagnose(model, talus.simulate(model, duration_s=12, seed=4))


def test_a_simulation_is_what_talus_sim_writes(tmp_path):
    run("talus-sim", "--model", PENDULUM, "--out", tmp_path / "r.csv", "--duration", 10, "--rate", 500, "--seed", 9, "--encoder-bits", 12)
    simulated = talus.simulate(talus.read(PENDULUM), duration_s=10, rate_hz=500, seed=9, encoder_bits=12)
    assert simulated == talus.Recording.read(tmp_path / "r.csv") and simulated != talus.simulate(talus.read(PENDULUM), duration_s=10)


def test_models_recordings_and_fits_pickle_compare_and_print():
    model = talus.read(PENDULUM)
    recording = talus.simulate(model, duration_s=10)
    recording.score = talus.score_settings({"lowpass_hz": 20})
    fit = talus.identify(model, [recording])
    for one in (model, recording, fit):
        again = pickle.loads(pickle.dumps(one))  # noqa: S301  our own
        assert again == one and repr(again) == repr(one)
    other = model.copy()
    other.set_parameters(coulomb_Nm=0.3)
    assert other != model and model != recording and "2500 samples" in repr(recording)
    assert [line.split()[0] for line in str(fit).splitlines()] == list(fit.parameters)


def test_what_the_commands_refuse_is_refused_in_their_words(tmp_path):
    model = talus.read(PENDULUM)
    with pytest.raises(talus.InputError, match="amplitude"):
        talus.simulate(model, duration_s=10, amplitude="much")
    (tmp_path / "bad.csv").write_text("a,b\n1,2\n")
    for bad in (lambda: talus.read(tmp_path / "bad.csv"), lambda: talus.diagnose(model, tmp_path / "bad.csv")):
        with pytest.raises(talus.InputError, match=r"bad\.csv:1: missing column"):
            bad()
    with pytest.raises(talus.InputError, match="no recording"):
        talus.diagnose(model, [])
