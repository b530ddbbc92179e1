"""tools/talus/diagnosis/motion.py: the motion gap against the library's own simulation, and what its parts do on their own."""

import json
import os

import numpy as np
import pytest
import yaml
from support import BUILD, REPOSITORY, data, needs_data, run

import talus
from talus import check, ffi, lib

os.environ.setdefault("TALUS_BUILD", str(BUILD))

from talus.diagnosis import command, figures, motion  # noqa: E402
from talus.diagnosis.acting import Memory  # noqa: E402
from talus.diagnosis.evidence import Evidence  # noqa: E402
from talus.diagnosis.physical import physical  # noqa: E402
from talus.diagnosis.search import search  # noqa: E402
from talus.diagnosis.verdict import judge  # noqa: E402

LEG = REPOSITORY / "models/leg.yaml"
EVERY = 3  # of the windows are simulated by the library
GAP_RAD = 3e-3  # and below it noise alone, on these benches
PARTS = 4  # of a sample's step, in each of which the torque is held
STRIBECK = {"effect": "stribeck", "joint": "knee", "parameters": {"extra_Nm": 0.5, "speed_rad_s": 0.12, "exponent": 2.0}}
LOAD = {"effect": "load_friction", "joint": "knee", "parameters": {"coefficient": 0.15}}
SPRING = {"effect": "parallel_spring", "joint": "ankle",
          "parameters": {"stiffness_Nm_rad": 4.0, "stiffening_Nm_rad3": 0.0, "preload_Nm": 0.3}}  # fmt: skip


def write_truth(folder, effects):
    tree = yaml.safe_load(LEG.read_text())
    if effects:
        tree["effects"] = effects
    (folder / "truth.yaml").write_text(yaml.safe_dump(tree))
    return folder / "truth.yaml"


class Twin:
    """A simulated bench, diagnosed in this process."""

    def __init__(self, folder, effects):
        self.effects, recording = effects, folder / "leg.csv"
        run("talus-sim", "--model", write_truth(folder, effects), "--out", recording, "--duration", 40)
        options = command.Options(["-m", str(LEG), "-r", str(folder / "gap.json"), str(recording)])
        options.check()
        _, tree = command.identify(options)
        self.identified, given = talus.Model.from_tree(tree), talus.Model.read(LEG)
        evidence = Evidence(given, command.read_tracks(options, tree, given), tree)
        self.search, fit = search(evidence, list(self.identified.base.values()))
        self.fit = judge(self.search, fit).fit
        self.before = figures.Residuals(self.search, [])
        self.after = figures.Residuals(self.search, self.fit.chosen)

    def simulated(self, model, effects):
        """RMS of each joint over every third window: tl_simulate from the recorded state under the recorded torque."""
        evidence, scene = self.search.evidence, self.search.scenes[0]
        track, effect = scene.track, effect_list(effects)
        q, v = ([scene.grid(name, j) for j in range(2)] for name in ("q", "v"))
        torque = [track.resample(evidence.effort(0, j)) for j in range(2)]
        windows, found = motion.Windows(track), []
        for start in windows.starts[::EVERY]:
            state = ffi.new("tl_simulation *")
            check(lib.tl_simulation_init(state, model.struct, [x[start] for x in q], [x[start] for x in v]))
            state.effect, state.effects = effect if effects else ffi.NULL, len(effects)
            for k in range(start, start + windows.steps):
                for part in range(PARTS):
                    share = (part + 0.5) / PARTS
                    held = ffi.new("double[2]", [(1 - share) * x[k] + share * x[k + 1] for x in torque])
                    until_s = (k - start + (part + 1) / PARTS) * track.step_s
                    check(lib.tl_simulate(model.struct, lib.tl_held_torque, held, 0.001, state, until_s))
                found.append([state.motion.q[j] - q[j][k + 1] for j in range(2)])
        return np.sqrt(np.mean(np.square(found), axis=0))


def effect_list(entries):
    """The entries of a model file as the library has them."""
    out = ffi.new("tl_effect[]", max(len(entries), 1))
    for effect, entry in zip(out, entries):
        kind = lib.tl_effect_find(entry["effect"].encode())
        joint = ("knee", "ankle").index(entry["joint"])
        effect.kind, effect.joint = kind, joint
        typical = lib.tl_effect_typical(kind, joint)
        for k in range(kind.strengths + kind.shapes):
            name = ffi.string(kind.parameter[k].name).decode()
            effect.value[k] = entry["parameters"].get(name, typical.value[k])
    return out


@pytest.fixture(scope="module", params=["none", "stribeck", "load", "spring"])
def twin(request, tmp_path_factory):
    effects = {"none": [], "stribeck": [STRIBECK], "load": [LOAD], "spring": [SPRING]}[request.param]
    return Twin(tmp_path_factory.mktemp(request.param), effects)


def test_with_the_effect_it_is_the_librarys_simulation_of_the_truth(twin):
    """What is left then is noise, and how a reversal is reconstructed: within a quarter."""
    assert [c.effect for c in twin.fit.chosen] == [e["effect"] for e in twin.effects]
    mine = motion.rms(twin.search, twin.fit.chosen, twin.after)
    assert np.all(np.abs(mine / twin.simulated(talus.Model.read(LEG), twin.effects) - 1) < 0.25)


def test_without_the_effect_it_is_the_librarys_simulation_of_the_plain_fit(twin):
    """Where it is a gap and not noise alone: within a tenth. Beside a spring the plain fit is no plant, and cannot be
    simulated."""
    base = twin.before.strengths[:len(twin.search.evidence.prior)]
    if twin.effects == [SPRING]:
        assert not motion.is_plausible(motion.Scene(twin.search.evidence, 0, base))
        return
    fitted = twin.identified.copy()
    fitted.set_parameters(**physical(fitted, base))
    mine, honest = motion.rms(twin.search, [], twin.before), twin.simulated(fitted, [])
    assert np.all(np.abs(mine / honest - 1) < np.where(mine > GAP_RAD, 0.1, 0.25))


def test_it_shrinks_where_there_is_a_gap(twin):
    found = motion.motion(twin.search, twin.fit, twin.before, twin.after)
    assert {name: set(entry) for name, entry in found.items()} == {
        name: {"unit", "identified_rms", "extended_rms"} for name in ("knee", "ankle")}  # fmt: skip
    for effect in twin.effects:
        entry = found[effect["joint"]]
        assert entry["extended_rms"] < 0.9 * entry["identified_rms"]
    if not twin.effects:
        assert all(entry["extended_rms"] == entry["identified_rms"] for entry in found.values())


# ---- one step ----------------------------------------------------------------------


def moves(f, v, seconds, inertia=0.5, coulomb_Nm=1.0, h=0.002):
    """(speed, way) of one joint under a constant torque."""
    f, v, way = np.array([[f]]), np.array([[v]], float), 0.0
    for _ in range(round(seconds / h)):
        v, moved = motion.step(f, v, np.array([[[inertia]]]), np.array([[coulomb_Nm]]), h)
        way += moved[0, 0]
    return v[0, 0], way


def test_a_joint_that_friction_holds_stays():
    assert moves(0.99, 0.0, 0.3) == (0.0, 0.0)
    # and one that comes to rest there stays to the last bit: 1/2 v^2 / a
    speed, way = moves(0.5, 0.3, 0.3)
    assert speed == 0.0 and np.isclose(way, 0.5 * 0.3**2 / ((0.5 + (1.0 - 2 * 0.5)) / 0.5), rtol=1e-12)


def test_a_reversal_within_a_step_is_exact():
    # -3 Nm against 0.4 rad/s: decelerates with (3 + 1) / 0.5, turns, accelerates back with (3 - 1) / 0.5
    stop_s = 0.4 / 8.0
    speed, way = moves(-3.0, 0.4, 0.2001 - 0.0001)
    rest_s = 0.2 - stop_s
    assert np.isclose(speed, -4.0 * rest_s, rtol=1e-12)
    assert np.isclose(way, 0.5 * 0.4 * stop_s - 0.5 * 4.0 * rest_s**2, rtol=1e-9)


def test_two_joints_pull_at_each_other_unless_one_sticks():
    inertia, dry = np.array([[[2.0], [0.5]], [[0.5], [1.0]]]), np.array([[0.0], [1.0]])
    free = motion.accelerations(np.array([[1.0], [3.0]]), np.array([[0.1], [0.1]]), inertia, dry)
    assert np.allclose(np.array([[2.0, 0.5], [0.5, 1.0]]) @ free[:, 0], [1.0, 2.0])
    stuck = motion.accelerations(np.array([[1.0], [0.9]]), np.array([[0.1], [0.0]]), inertia, dry)
    assert np.allclose(stuck[:, 0], [0.5, 0.0])


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_memory_follows_dahls_equation(power):
    memory = Memory(0, {"travel_rad": 0.01, "power": power}, np.zeros(3), np.ones(3))
    state, fine = 0.3, 0.3
    for _ in range(20000):
        fine += 1e-6 / 0.01 * (1 - fine) ** power
    assert np.isclose(memory.moved(np.array(state), np.array(0.02)), fine, rtol=1e-3)
    back = memory.moved(np.array(fine), np.array(-0.02))
    assert -1 < back < fine


# ---- the report --------------------------------------------------------------------


@needs_data
def test_a_motion_that_is_not_the_drives_has_no_figure(tmp_path):
    run("talus-gap", "--model", data("ak80_9_dyno/model.yaml"), "--report", tmp_path / "g.json",
        data("ak80_9_dyno/ak80_A_test_1.csv"))  # fmt: skip
    assert json.loads((tmp_path / "g.json").read_text())["motion"] == {}


@needs_data
def test_real_joints_have_figures_that_shrink(tmp_path):
    for name, unit in (("ur10e_joints/ur10e_joint_1", "rad"), ("emps/emps_identification", "m")):
        recording = data(f"{name}.csv")
        run("talus-gap", "--model", recording.parent / "model.yaml", "--report", tmp_path / "g.json", recording)
        report = json.loads((tmp_path / "g.json").read_text())
        (entry,) = report["motion"].values()
        assert entry["unit"] == unit
        if report["effects"]:
            assert entry["extended_rms"] < entry["identified_rms"]
