"""tools/talus/diagnosis/motion.py: the motion gap against the library's simulation of the truth, and its windows."""

import os
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from gap_in_process import recorded
from scipy.integrate import solve_ivp
from support import BUILD, REPOSITORY, run

import talus
from talus import check, ffi, lib

os.environ.setdefault("TALUS_BUILD", str(BUILD))

from talus.diagnosis import figures, motion  # noqa: E402
from talus.diagnosis.machine.physical import physical  # noqa: E402
from talus.diagnosis.search import search  # noqa: E402
from talus.diagnosis.verdict import judge  # noqa: E402

LEG = REPOSITORY / "models/leg.yaml"
PENDULUM = """
plant: pendulum
gravity_m_s2: 9.81
inertia_kg_m2: 0.05
gravity_moment_kg_m: 0.4
gravity_zero_rad: 0
joint: {transmission: {type: fixed, ratio: 1}, torque_constant_Nm_A: 1, friction: {coulomb_Nm: 0, viscous_Nms_rad: 0}}
"""
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
        dataset, self.identified = recorded(LEG, folder, recording)
        self.search, fit = search(dataset, list(self.identified.base.values()), replicated=False)
        self.fit = judge(self.search, fit).fit
        self.before = figures.Residuals(self.search, [])
        self.after = figures.Residuals(self.search, self.fit.chosen)

    def simulated(self, model, effects):
        """RMS of each joint over every third window: tl_simulate from the recorded state under the recorded torque."""
        dataset, terms = self.search.dataset, self.search.all_terms[0]
        processed, effect = terms.processed, effect_list(effects)
        q, v = ([terms.grid(name, j) for j in range(2)] for name in ("q", "v"))
        torque = [processed.resample(dataset.effort(0, j)) for j in range(2)]
        windows, found = motion.Windows(processed), []
        for start in windows.starts[::EVERY]:
            state = ffi.new("tl_simulation *")
            check(lib.tl_simulation_init(state, model.struct, [x[start] for x in q], [x[start] for x in v]))
            state.effect, state.effects = effect if effects else ffi.NULL, len(effects)
            for k in range(start, start + windows.steps):
                for part in range(PARTS):
                    share = (part + 0.5) / PARTS
                    held = ffi.new("double[2]", [(1 - share) * x[k] + share * x[k + 1] for x in torque])
                    until_s = (k - start + (part + 1) / PARTS) * processed.step_s
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
    base = twin.before.strengths[:len(twin.search.dataset.prior)]
    if twin.effects == [SPRING]:
        assert not motion.is_plausible(twin.search.all_terms[0].at(base))
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


# ---- windows -----------------------------------------------------------------------


def simulated_windows(model, q, v, torque, firsts, steps, step_s, effects=()):
    """Deviations (joints, steps, windows) from recorded rows."""
    joints, firsts = len(q), np.array(firsts, np.uint64)
    rows = {"q": q, "v": v, "torque": torque}
    rows = {name: [np.ascontiguousarray(x, float) for x in every] for name, every in rows.items()}
    out = np.empty((joints, steps, len(firsts)))
    spec = ffi.new("tl_windows *", {"model": model.struct, "effects": len(effects), "effect": effect_list(effects),
                   "step_s": step_s, "longest_step_s": 0.001, "first": ffi.from_buffer("size_t[]", firsts),
                   "count": len(firsts), "steps": steps, "deviation": ffi.from_buffer("double[]", out)})  # fmt: skip
    for name, every in rows.items():
        for j in range(joints):
            getattr(spec, name)[j] = ffi.from_buffer("double[]", every[j])
    check(lib.tl_simulate_windows(spec))
    return out


def test_each_window_is_the_motion_that_scipy_integrates_from_the_recorded_state():
    """A pendulum without friction, which nothing holds: q'' = (torque - m g sin q) / I."""
    tree = yaml.safe_load(PENDULUM)
    model, step_s, n = talus.Model.from_tree(tree), 0.004, 60
    t = step_s * np.arange(n)
    q, v, torque = 0.3 * np.sin(7 * t), 2.1 * np.cos(7 * t), 0.5 * np.cos(11 * t)
    found = simulated_windows(model, [q], [v], [torque], [0, 25], 30, step_s)[0]

    def fall(now, state):
        return [state[1], (np.interp(now, t, torque) - 0.4 * 9.81 * np.sin(state[0])) / 0.05]

    for window, first in enumerate((0, 25)):
        span = t[first:first + 31]
        truth = solve_ivp(fall, span[[0, -1]], [q[first], v[first]], t_eval=span, rtol=1e-10, atol=1e-12, max_step=1e-3)
        assert found[:, window] == pytest.approx(truth.y[0][1:] - q[first + 1:first + 31], abs=1e-8)


def test_a_joint_that_friction_holds_stays():
    model = talus.Model.from_tree(yaml.safe_load(PENDULUM.replace("coulomb_Nm: 0", "coulomb_Nm: 1")))
    rest = np.zeros(40)
    assert not simulated_windows(model, [rest], [rest], [rest + 0.99], [0], 30, 0.004).any()
    assert simulated_windows(model, [rest], [rest], [rest + 1.01], [0], 30, 0.004)[0, -1, 0] > 0


def test_a_recording_that_ends_has_no_window_beyond():
    processed = SimpleNamespace(step_s=0.01, kind=[np.ones(60, int)], parts=[{"n": 26}, {"n": 34}])
    assert list(motion.Windows(processed).starts) == [0, 26]
    processed.kind[0][30] = 0
    assert list(motion.Windows(processed).starts) == [0, 31]
