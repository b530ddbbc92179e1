"""tools/talus/diagnosis/gate: spoiled recordings are named before any cause is, sound ones are left alone."""

import json

import numpy as np
import pytest
import talus
from support import REPOSITORY, data, needs_data, run
from talus.diagnosis import gate, report
from talus.diagnosis.gate import machine
from talus.diagnosis.gate.finding import Finding
from talus.known import gate_scores, gates, spoilings

PLANTS = ("leg", "pendulum", "slider")
SEEDS = (1, 2)

# kinds of faults that a recording of talus-sim cannot have, which shows no speed and, of a joint, its current
OF_NONE = {"speed in degrees", "speed in turns", "speed the other way", "torque of the gear's other side"}
OF_LEG = {"second encoder in degrees", "second encoder the other way", "one angle for both encoders", "another ratio between encoders"}
OF_JOINT = {"angle in degrees", "angle in turns", "angle of the gear's other side", "few steps of the encoder"}
OF_SLIDER = {"position in millimetres"}  # and a pendulum's ratio of 9 is alike turns
NOT_OF = {"leg": OF_SLIDER, "pendulum": OF_SLIDER | OF_LEG | {"angle of the gear's other side"}, "slider": OF_LEG | OF_JOINT}


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """plant -> (model as a user would have it, recordings)."""
    folder, out = tmp_path_factory.mktemp("sound"), {}
    for plant in PLANTS:
        path = REPOSITORY / "models" / f"{plant}.yaml"
        for seed in SEEDS:
            run("talus-sim", "--model", path, "--out", folder / f"{plant}{seed}.csv", "--duration", 24, "--seed", seed)
        recordings = [talus.Recording.read(folder / f"{plant}{seed}.csv") for seed in SEEDS]
        model = talus.Model.read(path)
        model.set_parameters(**{name: 1.3 * value for name, value in model.parameters.items()})
        out[plant] = model, recordings
    return out


CASES = [(plant, kind) for plant in PLANTS for kind in spoilings.KINDS if kind not in OF_NONE | NOT_OF[plant]]


def test_there_are_25_kinds_and_more():
    assert len(spoilings.KINDS) > 30 and len({kind for _, kind in CASES}) > 25


@pytest.mark.parametrize(("plant", "kind"), CASES)
def test_what_is_spoiled_is_named(plant, kind, sound):
    model, recordings = sound[plant]
    bench = spoilings.Bench(plant, plant, model, [dict(recording.columns) for recording in recordings])
    spoiled = spoilings.spoil(bench, kind, 1)
    found = gates.findings_of(spoiled.bench)
    assert (spoiled.finding, spoiled.column) in [(f["id"], f["column"]) for f in found], found
    assert gate_scores.others({"finding": spoiled.finding, "column": spoiled.column, "findings": found}) == []
    assert all(f["evidence"] and f["remedy"] for f in found)


@pytest.mark.parametrize("plant", PLANTS)
def test_what_is_sound_is_left_alone(plant, sound):
    model, recordings = sound[plant]
    assert gate.findings(model, ["a.csv", "b.csv"], recordings) == []


@pytest.mark.parametrize("scale", [1.0, 0.6, 2.0])
def test_a_speed_that_is_a_multiple_of_the_angles_rate_is_said(scale, sound):
    """By no unit's factor: a time axis that runs at another rate does that. The angle is what counts."""
    model, (recording, _) = sound["pendulum"]
    speed = scale * np.gradient(recording.columns["joint_rad"], recording.t)
    with_speed = recording.with_columns({**recording.columns, "joint_velocity_rad_s": speed})
    found = gate.findings(model, ["a.csv"], [with_speed])
    assert [(f.id, f.grave, f.column) for f in found] == ([] if scale == 1.0 else [("units", False, "joint_velocity_rad_s")])
    assert all(f"{scale:.3g} times the rate" in f.evidence for f in found)


@pytest.mark.parametrize(("times_off", "columns", "accused"), [(3.0, ["joint_rad"], True), (3.0, ["joint_rad", "joint_velocity_rad_s"], False),
                                                               (5.0, ["joint_rad", "joint_velocity_rad_s"], True)])  # fmt: skip
def test_a_speed_speaks_against_an_angle_in_turns(times_off, columns, accused, monkeypatch):
    """Where the terms are off by no more than a guess is: both would have to be in turns."""
    turns = machine.Explanation("units", "its angle were in turns", "convert the angle to rad", machine.TURNS)
    explained = machine.Tried(turns, [], np.log(1.2), 0.1)
    for name, value in (("stacked", None), ("near_prior", None), ("fitted", (None, 0.1)), ("distance", np.log(times_off)),
                        ("_tried", [explained]), ("_can_be", True)):  # fmt: skip
        monkeypatch.setattr(machine, name, lambda *given, value=value: value)
    told = machine.Columns("joint_rad", "joint_current_A", tuple(columns))
    found = machine._mistaken(talus.Model("pendulum"), ["a.csv"], [], 0, told, [], several=False)
    assert (found is not None and (found.id, found.column) == ("units", "joint_rad")) == accused


def test_a_joint_that_is_turned_from_outside_may_have_no_current():
    t = np.arange(6000) * 0.005
    columns = {"time_s": t, "joint_rad": np.sin(2 * t) + 0.3 * np.sin(3.1 * t), "joint_current_A": np.zeros(6000)}
    model = talus.Model.read(REPOSITORY / "models/pendulum.yaml")
    load = {"joint_load_Nm": np.random.default_rng(1).normal(size=6000)}
    assert [f.id for f in gate.findings(model, ["a.csv"], [talus.Recording(columns)])] == ["stuck"]
    assert gate.findings(model, ["a.csv"], [talus.Recording(columns | load)]) == []


def test_long_recordings_are_told_by_their_first_minute(sound):
    model, (recording, _) = sound["pendulum"]
    short = recording.head(3000)
    assert len(short.t) == 3000 and np.array_equal(short.columns["joint_rad"], recording.columns["joint_rad"][:3000])
    assert recording.head(10**6) is recording


def test_two_recordings_that_share_rows(sound):
    model, (one, other) = sound["leg"]
    part = {name: np.concatenate([one.columns[name][2000:4000], x[1000:]]) for name, x in other.columns.items()}
    part["time_s"] = np.arange(len(part["time_s"])) * one.step_s
    found = gate.findings(model, ["a.csv", "b.csv"], [one, talus.Recording(part)])
    assert ("overlap", "") in [(f.id, f.column) for f in found]


def test_two_machines(tmp_path, sound):
    model, (one, _) = sound["pendulum"]
    other = talus.Model.read(REPOSITORY / "models/pendulum.yaml")
    other.set_parameters(inertia_kg_m2=0.02, gravity_moment_kg_m=0.05, coulomb_Nm=0.9)
    other.write(tmp_path / "other.yaml")
    run("talus-sim", "--model", tmp_path / "other.yaml", "--out", tmp_path / "other.csv", "--duration", 24)
    found = gate.findings(model, ["a.csv", "b.csv"], [one, talus.Recording.read(tmp_path / "other.csv")])
    assert [f.id for f in found] == ["other_machine"]


def test_a_machine_that_changes_within_a_file_is_no_other_one(sound):
    """Its stretches are recordings of their own: a payload that comes on between them is a cause, not another machine."""
    model, (one, _) = sound["pendulum"]
    loaded = talus.Recording(dict(one.columns) | {"joint_current_A": 3 * one.columns["joint_current_A"]})
    names = ["a.csv, 0 to 20 s", "a.csv, 60 to 80 s"]
    assert "other_machine" in [f.id for f in gate.findings(model, names, [one, loaded])]
    for stretch in (one_of := talus.Recording(dict(one.columns)), loaded):
        stretch.origin = talus.recording.Origin("a.csv", stretch.t[0], 80.0)
    assert "other_machine" not in [f.id for f in gate.findings(model, names, [one_of, loaded])]


def test_slow_ramps_do_not_speak_against_what_a_fast_motion_tells(tmp_path):
    """Ramps know nothing of an inertia: what they ask for is noise and the unmodelled drag, times whatever it takes."""
    model = talus.Model.read(REPOSITORY / "models/pendulum.yaml")
    drag = "effects: [{effect: stribeck, joint: joint, parameters: {extra_Nm: 0.6, speed_rad_s: 0.1, exponent: 2}}]"
    truth, names = talus.Model.from_text(model.text() + drag), ["ramps", "multisine"]
    truth.write(tmp_path / "truth.yaml")
    for name, more in zip(names, (("--speed", 0.2), ("--duration", 10))):
        run("talus-sim", "--model", tmp_path / "truth.yaml", "--out", tmp_path / name, "--excitation", name, "--rate", 1000, *more)
    ramps, multisine = (talus.Recording.read(tmp_path / name) for name in names)
    recordings = [ramps.head(8000), multisine]
    rows = machine.joint_rows(model, recordings, 0)
    beyond = rows[1].measured - rows[1].known - rows[1].x @ machine.fitted(rows[0])[0]
    assert np.mean(beyond**2) > 4 * np.mean(rows[1].measured ** 2)  # each by itself, they differ
    for order in (1, -1):
        assert gate.findings(model, names[::order], recordings[::order]) == []


def test_a_drive_may_brake_what_another_one_drives():
    """Its torque times its speed, against what the others put into the motion; nothing else does."""
    speed = np.sin(np.linspace(0.0, 30.0, 600))
    rows = machine.Rows(np.c_[np.sign(speed), speed], -2.0 * speed, np.zeros(600), np.array([0.1, 0.1]), ("knee_coulomb", "knee_viscous"))
    turned = machine.Explanation("sign", "", "", 1.0, -1.0)
    assert rows.power_W == pytest.approx(-1.0, abs=0.05)
    assert machine._impossible(rows, 0.1, turned, 0.0) and machine._impossible(rows, 0.1, turned, -3.0)
    assert machine._impossible(rows, 0.1, turned, 0.5) and not machine._impossible(rows, 0.1, turned, 1.2)


@pytest.mark.parametrize(("evidence", "begin"), [("rec/a.csv: 60 % of the rows", "rec/a.csv: 60 %"), ("all angles hang", "All angles hang")])
def test_a_finding_as_a_sentence_keeps_a_files_name(evidence, begin):
    said = report.remedy(Finding("stuck", True, "", evidence, "look at the sensor"))
    assert said.startswith(begin) and said.endswith("Next: look at the sensor.")


def test_a_cause_is_withheld_while_a_grave_finding_stands(tmp_path, sound):
    """Degrees in a column of radians: said first, with what to do; no effect is named."""
    _, (recording, _) = sound["pendulum"]
    columns = {**recording.columns, "joint_rad": np.degrees(recording.columns["joint_rad"])}
    table = np.column_stack(list(columns.values()))
    np.savetxt(tmp_path / "deg.csv", table, "%.12g", ",", header=",".join(columns), comments="")
    done = run("talus-gap", "--model", REPOSITORY / "models/pendulum.yaml", "--report", tmp_path / "gap.json", "--html",
               tmp_path / "gap.html", tmp_path / "deg.csv")  # fmt: skip
    report = json.loads((tmp_path / "gap.json").read_text())
    assert report["verdict"] == {"effect": "unknown", "joint": "none", "probability": 1.0, "withheld": True}
    assert report["effects"] == [] and report["findings"][0]["id"] == "units" and report["findings"][0]["grave"]
    assert "degrees" in done.stderr and "degrees" in (tmp_path / "gap.html").read_text()


@needs_data
@pytest.mark.long
def test_recordings_of_other_benches_and_real_machines_have_no_grave_finding():
    """Rates, resolutions, lost rows and jitter as labs have them are no fault."""
    groups = [(c / "model.yaml", sorted(c.glob("train*.csv.gz"))) for kind in ("wild_leg", "wild_pendulum", "leg_cases")
              for c in sorted(data(kind).glob("case_*"))]  # fmt: skip
    groups += [(data(kind) / "model.yaml", [path]) for kind in ("emps", "ur10e_joints", "ak80_9_dyno", "embir_dyno")
               for path in sorted(data(kind).glob("*.csv")) if path.name != "trials.csv"]  # fmt: skip
    assert len(groups) > 60
    grave = {}
    for path, files in groups:
        model = talus.Model.read(path)
        recordings = [talus.Recording.read(file, model=model) for file in files]
        found = [f for f in gate.findings(model, [file.name for file in files], recordings) if f.grave]
        grave |= {str(files[0]): found} if found else {}
    assert grave == {}


@pytest.mark.parametrize(("column", "factor"), [("ankle_motor_rad", 1 / 125), ("ankle_joint_rad", 125)])
def test_the_side_of_a_linkage_that_cannot_be_is_the_wrong_one(column, factor, sound):
    """Motor and encoder fit alike in both; but the linkage does not turn by hundreds of degrees."""
    model, recordings = sound["leg"]
    columns = {**recordings[0].columns, column: factor * recordings[0].columns[column]}
    assert ("ratio", column) in {(found.id, found.column) for found in gate.findings(model, ["run.csv"], [talus.Recording(columns)])}
