"""tools/talus: models and recordings are read as the programs read them, and give the same figures; wrong shapes and values are
refused with what was expected."""

import json

import numpy as np
import pytest
import talus
import yaml
from support import REPOSITORY, data, needs_data, run

MODELS = REPOSITORY / "models"
PENDULUM = MODELS / "pendulum.yaml"
EXTRAS = {
    "score": {"lowpass_hz": 12, "guard_s": 0.05},
    "signal": {"order": 3, "window_s": 0.06},
    "effects": [{"effect": "stribeck", "joint": "joint", "parameters": {"extra_Nm": 0.3, "speed_rad_s": 0.2, "exponent": 1}}],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A recording with a gap, and a model file that says all that one can say."""
    folder = tmp_path_factory.mktemp("reading")
    run("talus-sim", "--model", PENDULUM, "--out", folder / "whole.csv", "--duration", 12)
    lines = (folder / "whole.csv").read_text().splitlines()
    (folder / "arm.csv").write_text("\n".join(lines[:1000] + lines[1400:]) + "\n")
    (folder / "model.yaml").write_text(yaml.safe_dump(yaml.safe_load(PENDULUM.read_text()) | EXTRAS))
    return folder


@pytest.mark.parametrize("name", ["leg", "pendulum", "slider"])
def test_a_model_is_what_the_file_says_and_is_written_back(name, tmp_path):
    said = yaml.safe_load((MODELS / f"{name}.yaml").read_text())
    model = talus.Model.read(MODELS / f"{name}.yaml")
    model.write(tmp_path / "again.yaml", "written")
    again = yaml.safe_load((tmp_path / "again.yaml").read_text())
    assert {k: again[k] for k in said} == said
    assert talus.Model.from_tree(said).parameters == model.parameters


def test_what_a_model_file_says_besides_the_plant(folder):
    model = talus.Model.read(folder / "model.yaml")
    assert (model.score.lowpass_hz, model.score.guard_s, model.score.order) == (12, 0.05, 4)
    assert (model.window.order, model.window.length_s) == (3, 0.06)
    (effect,) = model.copy().effects
    assert talus.ffi.string(effect.kind.name) == b"stribeck" and list(effect.value)[:3] == [0.3, 0.2, 1.0]


def test_figures_are_those_of_the_programs(folder):
    """Prediction with effects, window and gaps; the report's errors by the file's own score; the identified values."""
    model_file, recording_file = folder / "model.yaml", folder / "arm.csv"
    run("talus-predict", "--model", model_file, "--out", folder / "p.csv", recording_file)
    model, recording = talus.Model.read(model_file), talus.Recording.read(recording_file)
    mine, theirs = talus.predict(model, recording)[0], np.loadtxt(folder / "p.csv", delimiter=",", skiprows=1)[:, 1]
    assert mine == pytest.approx(theirs, rel=1e-11, abs=1e-12)  # the file has twelve digits
    run("talus-identify", "--model", model_file, "--out", folder / "f.yaml", "--report", folder / "r.json", recording_file)
    report, fit = json.loads((folder / "r.json").read_text()), talus.identify(model, [recording])
    for name, value in fit.parameters.items():
        assert value == pytest.approx(report["parameters"][name]["value"], rel=1e-9, abs=1e-12)
    fitted = talus.Model.read(folder / "f.yaml")
    error = talus.score(fitted, recording, talus.predict(fitted, recording))["joint"]
    assert error["relative_percent"] == pytest.approx(report["error"]["joint"]["relative_percent"], rel=1e-6)


@needs_data
def test_a_real_machines_error_is_the_programs(tmp_path):
    model_file, recording_file = data("emps/model.yaml"), data("emps/emps_identification.csv")
    run("talus-identify", "--model", model_file, "--out", tmp_path / "f.yaml", "--report", tmp_path / "r.json", recording_file)
    model, recording = talus.Model.read(tmp_path / "f.yaml"), talus.Recording.read(recording_file)
    error = talus.score(model, recording, talus.predict(model, recording))["slider"]["relative_percent"]
    assert error == pytest.approx(json.loads((tmp_path / "r.json").read_text())["error"]["slider"]["relative_percent"], rel=1e-6)


@pytest.mark.parametrize("name", ["again.csv", "again.csv.gz"])
def test_a_recording_is_written_and_read_back_bit_by_bit(folder, tmp_path, name):
    recording = talus.Recording.read(folder / "arm.csv")
    recording.columns["joint_rad"] /= 3  # more digits than the file had
    recording.write(tmp_path / name)
    again = talus.Recording.read(tmp_path / name)
    assert list(again.columns) == list(recording.columns)
    assert all((again.columns[n] == x).all() for n, x in recording.columns.items())


# ---- what is refused ---------------------------------------------------------------------


def test_files_are_refused_in_the_programs_words(folder, tmp_path):
    (tmp_path / "bad.csv").write_text((folder / "whole.csv").read_text().replace("\n", "\nx", 1))
    (tmp_path / "bad.yaml").write_text(PENDULUM.read_text() + "no_such_key: 1\n")
    for read, path in ((talus.Recording.read, tmp_path / "bad.csv"), (talus.Model.read, tmp_path / "bad.yaml")):
        said = run("talus-predict", "--model", path if path.suffix == ".yaml" else PENDULUM, folder / "arm.csv" if path.suffix == ".yaml" else path, status=2)
        with pytest.raises(talus.InputError) as error:
            read(path)
        assert said.stderr.strip().endswith(str(error.value)) and str(path) in str(error.value)
    with pytest.raises(talus.InputError, match="No such file"):
        talus.Recording.read(tmp_path / "absent.csv")
    with pytest.raises(talus.InputError, match="^model:.*no_such"):
        talus.Model.from_tree(yaml.safe_load(PENDULUM.read_text()) | {"no_such": 1})


def zeros(*shape):
    return np.zeros(shape)


@pytest.mark.parametrize(
    ("plant", "arrays", "named"),
    [
        ("leg", (zeros(5), zeros(3), zeros(1)), "q"),
        ("leg", (zeros(5, 2), zeros(5, 2), zeros(5, 2)), "q"),
        ("leg", (zeros(2, 5), zeros(2, 4), zeros(2, 5)), "v"),
        ("leg", (zeros(2, 5), zeros(2, 5), zeros(2, 5), zeros(2, 1)), "slip"),
        ("slider", (zeros(5), zeros(5), zeros(4)), "a"),
        ("slider", (zeros(5), zeros(5) + np.nan, zeros(5)), "v"),
    ],
)
def test_inverse_refuses_other_shapes(plant, arrays, named):
    model = talus.Model.read(MODELS / f"{plant}.yaml")
    with pytest.raises(ValueError, match=f"^{named}: expected"):
        model.inverse(*arrays)


def test_every_other_call_refuses_other_shapes(folder):
    leg, arm = talus.Model.read(MODELS / "leg.yaml"), talus.Model.read(PENDULUM)
    recording = talus.Recording.read(folder / "arm.csv")
    with pytest.raises(ValueError, match="^torque: expected shape"):
        leg.forward(zeros(2, 3), zeros(2, 3), zeros(2, 2))
    with pytest.raises(ValueError, match="^q: expected shape"):
        leg.energy(zeros(2), zeros(2))
    with pytest.raises(ValueError, match="^predicted: expected shape"):
        talus.score(arm, recording, zeros(1, len(recording.t) - 1))
    with pytest.raises(ValueError, match="^base: expected shape"):
        talus.Regression(arm, recording).predict([1.0, 2.0])
    with pytest.raises(ValueError, match="lacks knee_motor_rad"):
        talus.predict(leg, recording)
    with pytest.raises(ValueError, match="^parameters: expected finite"):
        arm.set_parameters(coulomb_Nm=np.nan)


T = np.arange(200) * 0.01


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ({"joint_rad": T}, "time_s: expected this column"),
        ({"time_s": T, "joint_rad": T[:-1]}, "joint_rad: expected shape"),
        ({"time_s": T[:, None], "joint_rad": T}, "time_s: expected shape"),
        ({"time_s": T, "joint_rad": np.where(T > 1, np.nan, T)}, "joint_rad: expected finite numbers, found nan at row 101"),
        ({"time_s": T[::-1], "joint_rad": T}, "time_s: expected times that rise, found none at row 1"),
        ({"time_s": T, "joint_rad": T, "valid": T}, "valid: expected 0 or 1"),
    ],
)
def test_recordings_refuse_columns_that_c_would_misread(columns, says):
    with pytest.raises(ValueError, match=says):
        talus.Recording(columns)


@pytest.mark.parametrize(("name", "expected"), [("joint_deg", "joint_rad"), ("joint_current_mA", "joint_current_A"),
                                               ("joint_velocity_deg_s", "joint_velocity_rad_s"), ("slider_mm", "slider_m")])  # fmt: skip
def test_a_known_column_in_another_unit_is_refused(name, expected):
    with pytest.raises(ValueError, match=f"^{name}: is not known, expected {expected}; known columns are time_s, valid, knee_motor_rad") as said:
        talus.Recording({"time_s": T, name: T})
    assert "\n" not in str(said.value)
    with pytest.warns(UserWarning, match=f"columns not known and not read: {name}; known are time_s"):
        both = talus.Recording({"time_s": T, expected: T, name: T})  # beside the right one it stands in nobody's place
    assert list(both.columns) == ["time_s", expected]


def test_a_time_in_another_unit_is_refused():
    with pytest.raises(ValueError, match="^time_ms: is not known, expected time_s"):
        talus.Recording({"time_ms": T, "joint_rad": T})


def test_columns_that_are_not_known_are_told():
    with pytest.warns(UserWarning, match="columns not known and not read: mood, joint_setpoint_rad; known are time_s") as told:
        recording = talus.Recording({"time_s": T, "mood": T, "joint_rad": T, "joint_setpoint_rad": T})
    assert list(recording.columns) == ["time_s", "joint_rad"] and len(told) == 1 and told[0].filename == __file__
