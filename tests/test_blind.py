"""The check on withheld effects (tools/talus/blind): its bench against the library's own mechanics and against the balance of
energy, its draws against the catalogue, the seal, and every figure of the table on cases made by hand.

The bench shares no code with the library, so that each proves the other."""

import copy
import hashlib
import itertools
import json
import shutil
import subprocess
import sys

import numpy as np
import pytest
from scoring_reference import score as reference
from support import program, run

import talus
from talus.blind import bench, cases, effects, following, narrow, plants, running, scores, sensors, unknowns
from talus.blind.command import main
from talus.blind.surviving import joint_angle, over_noise, surviving

JOINTS = ("knee", "ankle")
NONE, SINGLE = {"none": 1.0}, {"single": 1.0}


@pytest.fixture(scope="module")
def plain():
    """A case without effect, and its simulation."""
    case = cases.Case(5, 0, NONE)
    return case, case.simulate([])


# ---- the bench -------------------------------------------------------------------------


def test_nothing_survives_where_nothing_is_hidden(plain):
    case, simulated = plain
    ratios, _ = case.ratios(simulated, [])
    for name in narrow.RECORDINGS:
        assert max(ratios[name][joint] for joint in JOINTS) < 0.01  # of the noise
        assert max(ratios[name]["knee_camera"], ratios[name]["ankle_encoder"]) < 1e-6


def test_the_librarys_mechanics_explain_the_bench(plain, tmp_path):
    """talus-predict with the true parameters leaves the current's noise: two derivations, two programs."""
    case, (runs, currents, sensor) = plain
    name, rng = "train1", np.random.default_rng(1)
    noise = sensors.complete_noise(
        {**case.noise, **{k: 2 * np.pi / 2**18 for k in case.noise if k.endswith("lsb_rad")}}, case.plant
    )
    shown = sensors.recording(runs[name], currents[name], sensor, noise, case.options, {}, 0.0, rng, case.plant)
    sensors.write(tmp_path / "leg.csv.gz", shown)
    (tmp_path / "true.yaml").write_text(case.plant.model_text(case.plant.parameters()))
    run("talus-predict", "--model", tmp_path / "true.yaml", "--out", tmp_path / "p.csv", tmp_path / "leg.csv.gz")
    model, data = talus.Model.read(tmp_path / "true.yaml"), talus.Recording.read(tmp_path / "leg.csv.gz")
    torque = np.ascontiguousarray(np.loadtxt(tmp_path / "p.csv", delimiter=",", skiprows=1)[:, 1:].T)
    measured = talus.measured(model, data)
    truth = np.array([plants.FIXED["K"] * currents[name][joint] for joint in JOINTS])
    error, alone = talus.score(model, data, torque), talus.score(model, data, truth)
    for joint in JOINTS:
        assert error[joint]["measured_rms"] > 5 * alone[joint]["rms"]  # there is something to explain
        assert error[joint]["rms"] == pytest.approx(alone[joint]["rms"], rel=0.06)
        speed = runs[name][f"{joint}_motor_v"] / {"knee": 51, "ankle": 125}[joint]
        row = JOINTS.index(joint)
        assert error[joint]["rms"] == pytest.approx(reference(data.t, measured[row], torque[row], speed)[0], rel=0.02)


FREE = {f"{joint}.{name}": 0.0 for joint in JOINTS for name in ("coulomb", "viscous")}
CHANGES = {
    "plain": {},
    "no friction": FREE,
    "spring": {"knee.spring_form": 1, "knee.spring_k": 4.0},
    "tilt": {"tilt": 0.06},
    "mount": {"x_mass": 4.0, "x_k": 9000.0},
}


@pytest.mark.parametrize("change", CHANGES)
def test_energy_balances(plain, change):
    """What the motors put in and friction takes away is what the leg gains."""
    case, _ = plain
    rows = bench.simulate(
        {**case.job([]), **case.runs["train2"]["job"], **CHANGES[change]}, case.runs["train2"]["times"]
    )
    energy, work = rows["energy"] - rows["energy"][0], rows["work"] - rows["work"][0]
    assert np.ptp(energy) > 0.5  # J
    assert np.abs(energy - work).max() < 0.002 * np.ptp(energy)


def test_joints_stick(plain):
    """Held joints stand still exactly, and with different currents: any friction between the two levels."""
    _, (runs, currents, _) = plain
    for joint in JOINTS:
        still = np.abs(runs["train3"][f"{joint}_motor_v"]) < 1e-6  # rad/s of the motor
        assert 0.1 < still.mean() < 0.7
        assert np.ptp(currents["train3"][joint][still]) > 0.02
        assert np.abs(runs["train1"][f"{joint}_motor_v"]).max() > 100


def test_a_spring_between_motor_and_joint_twists_by_the_load(plain):
    """Stiffness from the two encoders, where the ankle is moved slowly: twist = torque of the foot / stiffness."""
    case, _ = plain
    stiffness = 600.0
    change = effects.of("ankle", elastic_form=1, stiffness=stiffness, damping=0.001)
    rows = bench.simulate({**case.job([]), **case.runs["train3"]["job"], **change}, case.runs["train3"]["times"])
    twist = joint_angle(rows["ankle_motor"]) - rows["ankle_joint"]
    gravity = 9.81 * case.plant.base()["foot_moment"] * np.sin(rows["foot"])
    quiet = np.abs(rows["ankle_motor_v"]) < 1e-3
    assert np.polyfit(gravity[quiet], twist[quiet], 1)[0] == pytest.approx(1 / stiffness, rel=0.05)


def test_a_longer_settling_changes_nothing(plain):
    """The multisine has settled before the recording begins: its periods are alike."""
    _, (runs, _, _) = plain
    rows = runs["train1"]
    first, last = rows["t"] < 4.0, rows["t"] >= 20.0
    early = np.interp(rows["t"][last] - 20.0, rows["t"][first], rows["knee_motor"][first])
    inside = (rows["t"][last] > 20.1) & (rows["t"][last] < 23.9)
    assert np.abs(early - rows["knee_motor"][last])[inside].max() < 0.02  # rad of the motor, of about 30


# ---- the draws -------------------------------------------------------------------------


def draws(count=160):
    plant = plants.Leg.draw(np.random.default_rng(0))
    for number in range(count * len(effects.CATALOGUE)):
        yield effects.draw(np.random.default_rng(number), plant, number / len(effects.CATALOGUE) + 1e-9)


def test_draws_cover_the_catalogue_in_several_forms():
    forms, joints = {}, {}
    for one in draws():
        forms.setdefault(one.effect, set()).add(one.form)
        joints.setdefault(one.effect, set()).add(one.joint)
    both, ankle, knee, base = {"knee", "ankle"}, {"ankle"}, {"knee"}, {"base"}
    only = {"kinematic_error": knee, "linkage_error": ankle, "encoder_eccentricity": ankle, "gravity_tilt": base,
            "base_compliance": base}  # fmt: skip
    assert set(forms) == set(effects.SHOWS) and len(forms) == 20
    assert joints == {name: only.get(name, both) for name in forms}
    assert {name for name, kinds in forms.items() if len(kinds) < 2} == {"current_offset"}
    assert len(unknowns.KINDS) >= 6


def test_every_name_of_a_draw_is_one_of_the_twin(tmp_path, plain):
    """The twin refuses names that it does not know, so that no effect gets lost by a slip of the pen."""
    case, _ = plain
    short = {**case.runs["train1"]["job"], "settle_s": 0.01}
    seen, rng = set(), np.random.default_rng(3)
    drawn = list(draws(24)) + [unknowns.draw(rng, case.plant, k / 13 + 1e-9) for k in range(39)]
    for one in drawn:
        if one.job.keys() <= seen:
            continue
        seen |= one.job.keys()
        assert bench.simulate({**case.job([one]), **short}, np.array([0.001, 0.002])) is not None
    with pytest.raises(RuntimeError, match="unknown name 'knee.stribek'"):
        bench.simulate({**case.job([]), **short, "knee.stribek": 1.0}, np.array([0.001]))


def test_a_case_does_not_depend_on_the_count():
    kinds = [cases.kind_of(7, k, cases.MIX) for k in range(400)]
    for kind, part in cases.MIX.items():
        assert kinds.count(kind) == pytest.approx(400 * part, abs=4)
    one, again = cases.Case(7, 3, cases.MIX), cases.Case(7, 3, cases.MIX)
    assert one.plant == again.plant and one.drawn == again.drawn and one.kind == kinds[3]
    assert cases.Case(8, 3, cases.MIX).plant != one.plant


def test_draw_writes_what_a_user_has(tmp_path, capsys):
    """The same seed, the same bytes; the answer stands in the sealed file only."""
    for folder in ("a", "b"):
        assert main(["draw", "--seed", "9", "--count", "1", "--mix", "single:1", "--out", str(tmp_path / folder)]) == 0
    names = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file())
    assert [str(n) for n in names if n.parts[0] == "case_000"] == [
        "case_000/model.yaml",
        *(f"case_000/{name}.csv.gz" for name in ("test", "train1", "train2", "train3")),
    ]
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    text = (tmp_path / "a/sealed/labels.json").read_bytes()
    assert hashlib.sha256(text).hexdigest() in capsys.readouterr().out
    label = json.loads(text)["cases"][0]
    recording = talus.Recording.read(tmp_path / "a/case_000/train1.csv.gz")
    assert len(recording.t) == 6000 and label["kind"] == "single" and label["effects"][0]["effect"] == label["effect"]
    model = talus.Model.read(tmp_path / "a/case_000/model.yaml").parameters
    for name, true in label["parameters"].items():
        off = abs(model[name] / true - 1)
        assert 0 < off < (0.101 if name.endswith("com_m") else 0.201 if "inertia" in name else 0.401), name
    assert main(["draw", "--seed", "9", "--count", "1", "--out", str(tmp_path / "a")]) == 2  # not over what is there


def test_a_bench_that_swings_between_its_currents_limits_is_no_case():
    shown = {name: {"knee": np.array([0.5, -2.0]), "ankle": np.array([0.1, 0.3])} for name in narrow.RECORDINGS}
    assert not cases.runs_away(({}, shown, {}))
    for joint, peak in (("knee", -7.9), ("ankle", 1.45)):
        once = {**shown, "train2": {**shown["train2"], joint: np.array([0.2, peak])}}
        assert cases.runs_away(({}, once, {}))
    assert cases.runs_away(None)


def test_a_drive_is_not_asked_for_currents_at_which_its_droop_would_take_all_torque():
    droop = effects.Drawn("torque_saturation", "knee", "quadratic", "", effects.of("knee", sat_form=1))
    for peak, gives_out in ((3.2, False), (3.4, True), (-4.5, True)):
        simulated = ({}, {name: {"knee": np.array([0.5, peak]), "ankle": np.array([0.1])} for name in narrow.RECORDINGS}, {})
        assert cases.drive_gives_out([droop], simulated) == gives_out
        assert not cases.drive_gives_out([], simulated)


@pytest.mark.long
@pytest.mark.parametrize("effect", list(effects.CATALOGUE))
def test_effects_survive_identification(effect):
    """Of six draws of each effect most can be seen, and none is nothing."""
    found, place, numbers = [], list(effects.CATALOGUE).index(effect), itertools.count()
    while len(found) < 6:
        case = cases.Case(77, next(numbers), SINGLE)
        case.drawn = [effects.draw(case.streams["effect"], case.plant, (place + 0.5) / len(effects.CATALOGUE))]
        if effect == "torque_saturation" and cases.drive_gives_out(case.drawn, case.simulate(case.drawn)):
            continue  # on this bench such a droop is no case
        simulated = cases.settle(case)
        assert case.drawn[0].effect == effect  # the leg stayed in its range
        ratios, _ = case.ratios(simulated, case.drawn)
        found.append((any(cases.observable(ratios)), max(max(r.values()) for r in ratios.values())))
    assert sum(seen for seen, _ in found) >= 3
    assert min(size for _, size in found) > 0.02


# ---- the seal and the run --------------------------------------------------------------


STUB = """#!{python}
import json, shutil, sys
arguments = dict(zip(sys.argv[2:8:2], sys.argv[3:9:2]))
verdict = {{"effect": "none", "joint": "none", "probability": 0.75}}
gap = {{j: {{"identified_rms": 0.0, "noise_floor_rms": 1.0, "closed_fraction": 0.0}} for j in ("knee", "ankle")}}
json.dump({{"verdict": verdict, "alternatives": [], "effects": [], "gap": gap, "motion": {{}}, "where": [],
           "confusable": []}}, open(arguments["--report"], "w"))
shutil.copy(arguments["--model"], arguments["--save-model"])
open({log!r}, "a").write("x")
held = b"x" * (250 * 2**20)
"""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Two cases without effect, drawn by the command."""
    folder = tmp_path_factory.mktemp("blind") / "cases"
    assert main(["draw", "--seed", "5", "--count", "2", "--mix", "none:1", "--out", str(folder)]) == 0
    return folder


@pytest.mark.release  # it measures memory
def test_run_resumes_and_open_tells(drawn, tmp_path, capsys, monkeypatch):
    """A stub that always says `none` at 0.75, on two cases where that is true."""
    program("talus-identify")
    log, stub = tmp_path / "log", tmp_path / "stub"
    stub.write_text(STUB.format(python=sys.executable, log=str(log)))
    stub.chmod(0o755)
    assert main(["open", str(drawn)]) == 1
    assert "2 cases have no verdict yet" in capsys.readouterr().err
    # a process of its own: what a program's parent holds when it starts counts as the program's
    subprocess.run([sys.executable, "-m", "talus.blind", "run", drawn, "--gap", stub], check=True, capture_output=True)
    assert main(["run", str(drawn), "--gap", str(stub)]) == 0
    assert log.read_text() == "xx"  # the second time there was nothing left to do
    monkeypatch.setattr(running, "fingerprint", lambda: "another version")
    assert main(["run", str(drawn), "--gap", str(stub), "--keep"]) == 0 and log.read_text() == "xx"
    assert main(["open", str(drawn), "--out", str(tmp_path)]) == 0
    said = json.loads((tmp_path / "blind.json").read_text())
    figures = {bar["name"]: bar["value"] for bar in said["bars"]}
    assert figures["none said where it is true"] == 1 and figures["unknown said where it is true"] is None
    assert figures["Brier score"] == pytest.approx(0.0625)
    assert said["confusion"] == {"none": {"none": 2}}
    assert said["reliability"] == [{"from": 0.7, "to": 0.85, "cases": 2, "said": 0.75, "right": 1}]
    assert 250 < figures["peak memory, worst [MB]"] < 290
    page = (tmp_path / "blind.html").read_text()
    assert "Chart" in page and "src=" not in page and "none said where it is true" in page
    for case in said["cases"]:  # the identified model leaves the noise and what smoothing costs, on what it never saw
        for part in case["shrinkage"]["joints"].values():
            assert 0.9 < part["identified"] / part["floor"] < 1.1


def test_an_unseen_recording_too_slow_to_be_scored_ends_no_run(drawn, tmp_path):
    """All of its motion counts as standstill."""
    program("talus-identify")
    folder, stub = shutil.copytree(drawn, tmp_path / "cases"), tmp_path / "stub"
    shutil.rmtree(folder / "results", ignore_errors=True)
    stub.write_text(STUB.format(python=sys.executable, log=str(tmp_path / "log")))
    stub.chmod(0o755)
    path = folder / "case_000" / "test.csv.gz"
    columns = dict(talus.Recording.read(path).columns)
    for name in columns:
        if name.endswith("_rad"):
            columns[name] = 1e-3 * columns[name]
    talus.Recording(columns).write(path)
    assert main(["run", str(folder), "--gap", str(stub)]) == 0
    assert main(["open", str(folder), "--out", str(tmp_path)]) == 0
    slow, other = json.loads((tmp_path / "blind.json").read_text())["cases"]
    assert slow["shrinkage"] is None and other["shrinkage"]["joints"]
    assert json.loads((folder / "results" / "case_000.json").read_text())["failed"] == "too few samples"


PROPOSING = """#!{python}
import json, sys
arguments = dict(zip(sys.argv[2:8:2], sys.argv[3:9:2]))
recordings = [a for a in sys.argv if a.endswith(".csv.gz")]
group = [] if len(recordings) == 4 else [{{"effects": [{effect!r}, "other"], "joint": {joint!r}}}]
json.dump({{"verdict": {{"effect": {effect!r}, "joint": {joint!r}, "probability": 0.5}}, "effects": [], "gap": {{}},
           "motion": {{}}, "where": [], "confusable": group,
           "next_experiment": {{"why": "with the camera", "trajectory": {trajectory!r}}}}},
          open(arguments["--report"], "w"))
if "--save-model" in arguments:
    open(arguments["--save-model"], "w").write(open(arguments["--model"]).read())
"""


@pytest.mark.release
def test_a_proposed_experiment_is_made(tmp_path, capsys):
    """The twin follows the trajectory that a report proposes; the diagnosis sees it as one recording more."""
    program("talus-identify")
    folder, path = tmp_path / "cases", tmp_path / "wave.csv"
    assert main(["draw", "--seed", "6", "--count", "1", "--mix", "single:1", "--out", str(folder)]) == 0
    hidden = json.loads((folder / "sealed/labels.json").read_text())["cases"][0]
    t = np.arange(0.0, 6.0, 0.01)
    wave = np.array([t, 0.3 * np.sin(3 * t) ** 3, 0.2 * np.sin(4 * t) ** 3])
    # as talus-gap writes it, with a line of words before
    np.savetxt(path, wave.T, delimiter=",", header="# a wave, and another\ntime_s,knee_rad,ankle_rad", comments="")
    stub = tmp_path / "stub"
    stub.write_text(
        PROPOSING.format(python=sys.executable, effect=hidden["effect"], joint=hidden["joint"], trajectory=str(path))
    )
    stub.chmod(0o755)
    for command in ("run", "next"):
        assert main([command, str(folder), "--gap", str(stub)]) == 0
    assert main(["open", str(folder)]) == 0
    found = {bar["name"]: bar for bar in json.loads((folder / "blind.json").read_text())["bars"]}
    assert found["proposed experiment separates what was open"]["value"] == 1
    assert found["proposed experiment separates what was open"]["cases"] == 1

    case, label = following.find_case(folder, "case_000")
    shown = following.follow(case, wave, camera=True)
    assert label["effect"] == hidden["effect"] and "shank_rad" in shown and len(shown["time_s"]) == 1497
    for name, ratio, row in (("knee_motor_rad", 51, 1), ("ankle_joint_rad", 1, 2)):
        wanted = np.interp(shown["time_s"], t, wave[row])
        assert np.std(shown[name] / ratio - wanted) < 0.2 * np.std(wanted)  # PD alone: it lags, but it follows


def test_a_broken_seal_is_not_opened(drawn, capsys):
    place = drawn / "sealed" / "labels.json"
    before = place.read_text()
    place.write_text(before.replace('"none"', '"unknown"', 1))
    try:
        assert main(["open", str(drawn)]) == 1
        assert "its checksum is" in capsys.readouterr().err
    finally:
        place.write_text(before)


# ---- the figures -----------------------------------------------------------------------


def label(kind, *hidden, observable=True, alias=()):
    parts = [{"effect": e, "joint": j, "alias_with": [list(a) for a in alias], "observable": True} for e, j in hidden]
    return {
        "case": "case_000",
        "kind": kind,
        "effects": parts,
        "hidden": None,
        "observable": observable,
        "detectability": 100.0,
        "noise": {f"{j}_torque_Nm": 1.0 for j in JOINTS},
        "reconstruction": dict.fromkeys(JOINTS, 0.0),
    }


def result(effect, joint="none", probability=0.9, listed=None, **more):
    listed = [(effect, joint)] if listed is None and effect not in scores.NO_CAUSE else listed or []
    report = {
        "verdict": {"effect": effect, "joint": joint, "probability": probability},
        "alternatives": [],
        "effects": [{"effect": e, "joint": j} for e, j in listed],
        "gap": {},
        "motion": {},
        "where": [],
        "confusable": [],
    }
    return {"report": {**report, **more}, "processor_s": 1.0, "wall_s": 1.0, "peak_MB": 10.0}


def value(found, name):
    (bar,) = [bar for bar in found if bar.name.startswith(name)]
    return bar.value


def test_a_wrong_cause_is_one_that_is_named_surely_and_is_no_alias():
    hidden = label("single", ("stribeck", "knee"), alias=[("presliding", "knee")])
    wrong = {
        ("stribeck", "knee", 0.9): False, ("presliding", "knee", 0.9): False, ("stribeck", "ankle", 0.9): True,
        ("backlash", "knee", 0.49): False, ("backlash", "knee", 0.51): True, ("unknown", "none", 0.9): False,
        ("none", "none", 0.9): False,
    }  # fmt: skip
    for (effect, joint, p), answer in wrong.items():
        assert scores.judge(hidden, result(effect, joint, p))["wrong"] == answer, (effect, joint, p)
    for kind in ("none", "unknown"):
        assert scores.judge(label(kind), result("stribeck", "knee"))["wrong"]
        assert not scores.judge(label(kind), result(kind))["wrong"]


def test_none_is_right_where_an_effect_is_too_weak():
    weak = label("single", ("delay", "knee"), observable=False)
    assert scores.judge(weak, result("none"))["exact"] and scores.judge(weak, result("delay", "knee"))["exact"]
    assert not scores.judge(label("single", ("delay", "knee")), result("none"))["exact"]


def test_singles_and_joints():
    hidden = label("single", ("stribeck", "knee"), alias=[("presliding", "knee")])
    found = scores.bars(
        [
            scores.judge(hidden, result(*said))
            for said in [("stribeck", "knee"), ("presliding", "knee"), ("stribeck", "ankle"), ("none", "none")]
        ]
    )
    assert value(found, "single, observable: effect and joint") == 0.25
    assert value(found, "single, observable: up to the alias") == 0.5
    assert value(found, "single, observable: joint") == 0.5


def test_pairs():
    hidden = label("pair", ("stribeck", "knee"), ("delay", "ankle"))
    said = [result("stribeck", "knee", listed=[("stribeck", "knee"), ("delay", "ankle")]),
            result("stribeck", "knee"),
            result("delay", "ankle", listed=[("delay", "ankle"), ("stribeck", "knee"), ("cogging", "knee")]),
            result("unknown")]  # fmt: skip
    found = scores.bars([scores.judge(hidden, one) for one in said])
    assert value(found, "pair: at least one right") == 0.75
    assert value(found, "pair, both observable: both right") == 0.5
    assert value(found, "pair: no third invented") == 0.75


def test_closing():
    hidden = label("single", ("stribeck", "knee"))
    gap = {"knee": {"identified_rms": 3.0, "noise_floor_rms": 1.0, "closed_fraction": 0.9}}
    one = result("stribeck", "knee", gap=gap)
    one["unseen"] = {"identified": {"knee": 3.0, "ankle": 1.0}, "extended": {"knee": 2.0, "ankle": 1.0},
                     "unit_noise": dict.fromkeys(JOINTS, 1.0)}  # fmt: skip
    case = scores.judge(hidden, one)
    assert case["shrinkage"]["pooled"] == pytest.approx(5 / 8)
    assert case["shrinkage"]["joints"]["knee"]["closed"] == pytest.approx(5 / 8)
    assert case["shrinkage"]["joints"]["ankle"]["closed"] is None  # nothing there to close
    found = scores.bars([case])
    assert value(found, "closed on the unseen recording, median") == pytest.approx(0.625)
    assert value(found, "claimed closed_fraction off by") == pytest.approx(0.9 - 0.625)
    assert value(found, "closing claimed where none is closed") == 0
    worse = copy.deepcopy(one)
    worse["unseen"]["extended"]["knee"] = 3.1
    assert value(scores.bars([scores.judge(hidden, worse)]), "closing claimed where none is closed") == 0.5


def test_where_and_confusable():
    hidden = label("single", ("cogging", "knee"))
    entry = lambda joint, coordinate: [{"joint": joint, "coordinate": coordinate}]  # noqa: E731
    assert scores.judge(hidden, result("cogging", "knee", where=entry("knee", "motor_angle")))["where_right"]
    assert not scores.judge(hidden, result("cogging", "knee", where=entry("ankle", "motor_angle")))["where_right"]
    assert not scores.judge(hidden, result("cogging", "knee", where=entry("knee", "velocity")))["where_right"]
    group = [{"effects": ["cogging", "kinematic_error", "delay"], "joint": "knee"}, {"effects": ["a", "b", "c", "d"]}]
    assert scores.judge(hidden, result("cogging", "knee", confusable=group))["confusable"] == 2


def test_a_failed_diagnosis_is_not_right():
    one = result("none")
    one["report"] = None
    case = scores.judge(label("none"), one)
    assert not case["group"] and not case["wrong"] and case["verdict"][0] == "failed"


@pytest.mark.parametrize("bands", [{}, {"bands_Nm": {"knee": [0.01, 0.01, 0.02, 0.02]}}])
def test_a_joint_that_rests_leaves_nothing(bands):
    assert over_noise(np.zeros(0), np.zeros(50, bool), bands, "knee", 250.0) == 0.0


def test_surviving_is_what_least_squares_leaves(plain):
    """An added torque of known size that no column resembles: its RMS over the noise."""
    case, (runs, currents, _) = plain
    added = {n: {j: i + 0.5 * case.noise[f"{j}_current_A"] * np.cos(400 * runs[n]["t"]) for j, i in both.items()}
             for n, both in currents.items()}  # fmt: skip
    ratios, _ = surviving(runs, added, {**case.noise, "camera_rad": None}, {}, case.plant)
    assert ratios["train1"]["knee"] == pytest.approx(0.5 / np.sqrt(2), rel=0.03)
    assert ratios["train3"]["ankle"] == pytest.approx(0.5 / np.sqrt(2), rel=0.03)
