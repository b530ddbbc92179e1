"""The commands on recordings of real machines, and on the labelled bench cases without an effect.

Published or independent figures stand beside each test. No option is set for any file; the model is the one that
lies beside the data.
"""

import csv
import gzip
import json

import numpy as np
import pytest
import yaml
from scoring_reference import score
from scipy.signal import butter, filtfilt
from support import DATA, data, needs_data, run

pytestmark = needs_data


def identify(tmp_path, model, *recordings):
    fitted, report = tmp_path / "fitted.yaml", tmp_path / "report.json"
    run("talus-identify", "--model", model, "--out", fitted, "--report", report, *recordings)
    return yaml.safe_load(fitted.read_text()), json.loads(report.read_text()), fitted


def columns(path):
    opener = gzip.open if str(path).endswith(".gz") else open
    with opener(path, "rt", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def predicted(tmp_path, model, recording):
    run("talus-predict", "--model", model, "--out", tmp_path / "p.csv", recording)
    return columns(tmp_path / "p.csv")


def test_emps_against_the_published_parameters(tmp_path):
    """Janot, Gautier, Brunot 2019: 4.08 %, M 95.1089 kg, Fv 203.5034, Fc 20.3935, offset -3.1648 N."""
    model = data("emps/model.yaml")
    fitted, report, path = identify(tmp_path, model, data("emps/emps_identification.csv"))
    assert report["error"]["slider"]["relative_percent"] <= 4.05
    published = {"mass_kg": (95.1089, 0.005), "viscous_Ns_m": (203.5034, 0.01), "coulomb_N": (20.3935, 0.01),
                 "force_offset_N": (-3.1648, 0.03)}
    for name, (value, tolerance) in published.items():
        assert report["parameters"][name]["value"] == pytest.approx(value, rel=tolerance), name
    # the error that the report claims is what the scoring rule says of talus-predict
    recording, prediction = columns(data("emps/emps_identification.csv")), predicted(tmp_path, path, data(
        "emps/emps_identification.csv"))
    rule = yaml.safe_load(model.read_text())["score"]
    speed = np.gradient(recording["slider_m"], recording["time_s"])
    relative = score(recording["time_s"], recording["slider_force_N"], prediction["slider_force_N"], speed, **rule)[2]
    assert relative == pytest.approx(report["error"]["slider"]["relative_percent"], rel=1e-3)
    assert fitted["score"] == rule


@pytest.mark.parametrize("joint, bar", [(1, 3.8), (2, 3.7), (4, 3.2), (5, 4.7)])
def test_ur10e_joints(tmp_path, joint, bar):
    _, report, _ = identify(tmp_path, data("ur10e_joints/model.yaml"), data(f"ur10e_joints/ur10e_joint_{joint}.csv"))
    print(f"joint {joint}: {report['error']['joint']['relative_percent']:.2f} %")
    assert report["error"]["joint"]["relative_percent"] <= bar


@pytest.mark.parametrize("trial, figure", [("A_comp_full", 36.0), ("A_high_speed", 59.5), ("A_test_1", 59.6),
                                           ("A_test_3", 58.5)])
def test_ak80_a_wrong_torque_constant_is_not_absorbed(tmp_path, trial, figure):
    """With the maker's constant the load stays wrong by tens of per cent: an effect, left visible. The figures
    are those of an independent least squares, which knows no physical bounds."""
    _, report, _ = identify(tmp_path, data("ak80_9_dyno/model.yaml"), data(f"ak80_9_dyno/ak80_{trial}.csv"))
    relative = report["error"]["joint"]["relative_percent"]
    unbounded = relative * np.sqrt(report["least_squares_cost"] / report["cost"])
    print(f"{trial}: {relative:.1f} %, without bounds {unbounded:.1f} %")
    assert unbounded == pytest.approx(figure, abs=1.0)
    assert relative >= unbounded * (1 - 1e-9)


@pytest.mark.parametrize("path", sorted((DATA / "embir_dyno").glob("embir_*.csv")), ids=lambda p: p.stem[6:])
def test_embir_recordings_are_read_and_predicted(tmp_path, path):
    rows = len(columns(path)["time_s"])
    prediction = predicted(tmp_path, data("embir_dyno/model.yaml"), path)
    assert len(prediction["joint_load_Nm"]) == rows and np.all(np.isfinite(prediction["joint_load_Nm"]))


# ---- bench cases that hide nothing but wrong CAD values ------------------------------


def none_cases():
    for path in sorted((DATA / "leg_cases").glob("case_*")):
        truth = json.loads((path / "truth.json").read_text())
        if truth["kind"] == "none":
            yield pytest.param(path, truth, id=path.name)


@pytest.fixture(scope="module")
def fitted_case(tmp_path_factory):
    done = {}

    def fit(path):
        if path not in done:
            folder = tmp_path_factory.mktemp(path.name)
            trains = [path / f"train{k}.csv.gz" for k in (1, 2, 3)]
            done[path] = (*identify(folder, path / "model.yaml", *trains)[1:], folder)
        return done[path]

    return fit


BASE = {"shank_inertia": 0.01, "shank_moment": 0.01, "ankle_rotor_inertia": 0.01, "foot_moment": 0.03,
        "foot_inertia": 0.08}
FRICTION = ("knee_coulomb_Nm", "knee_viscous_Nms_rad", "ankle_coulomb_Nm", "ankle_viscous_Nms_rad")


@pytest.mark.parametrize("path, truth", none_cases())
def test_bench_case_parameters(fitted_case, path, truth):
    report, _, _ = fitted_case(path)
    for name, tolerance in BASE.items():
        assert report["base_parameters"][name]["value"] == pytest.approx(truth["base_parameters"][name], rel=tolerance)
    for name in FRICTION:
        assert report["parameters"][name]["value"] == pytest.approx(truth["parameters"][name], rel=0.03)
    assert len(report["null_space"]) == 1
    assert set(report["null_space"][0]) == {"ankle_motor_com_m", "shank_com_m", "shank_inertia_kg_m2"}
    assert not report["parameters"]["shank_com_m"]["identifiable"]
    assert report["parameters"]["foot_com_m"]["identifiable"]


def noise_floor(t, speed, noise, seed=0, draws=10):
    """RMS of white noise after the score's filter and mask."""
    rng = np.random.default_rng(seed)
    scores = [score(t, noise * rng.standard_normal(len(t)), np.zeros(len(t)), speed)[0] for _ in range(draws)]
    return float(np.sqrt(np.mean(np.square(scores))))


def excess(path, truth, fitted, folder):
    """Scored RMS on the unseen recording over the filtered true noise, each joint."""
    test = columns(path / "test.csv.gz")
    prediction = predicted(folder, fitted, path / "test.csv.gz")
    model = yaml.safe_load((path / "model.yaml").read_text())
    t, out = test["time_s"], []
    for joint in ("knee", "ankle"):
        measured = model[joint]["torque_constant_Nm_A"] * test[f"{joint}_current_A"]
        # the speed by the camera-free joint angles, independent of the program
        angle = test["knee_motor_rad"] / 51 if joint == "knee" else test["ankle_joint_rad"]
        b, a = butter(4, 0.3)
        speed = np.gradient(filtfilt(b, a, angle), t) if joint == "ankle" else np.gradient(angle, t)
        rms = score(t, measured, prediction[f"{joint}_motor_torque_Nm"], speed)[0]
        out.append(rms / noise_floor(t, speed, truth["noise"][f"{joint}_torque_Nm"]))
    return out


def test_bench_cases_reach_the_noise_on_an_unseen_recording(fitted_case):
    ratios = []
    for case in none_cases():
        path, truth = case.values
        _, fitted, folder = fitted_case(path)
        ratios += excess(path, truth, fitted, folder)
    print("scored RMS / filtered true noise:", np.round(ratios, 3))
    assert max(ratios) <= 1.08 and np.median(ratios) <= 1.04
