"""talus-export --to mjcf and talus.mujoco: MuJoCo's motion under open-loop torque against the library's forward dynamics.

MuJoCo goes its own way for 10 s. At each of its states the torque that moves the joints is held against the library's: mass times the
difference of the accelerations. Its positions against a motion of the library's own are a second look."""

from dataclasses import dataclass, field

import numpy as np
import pytest
import talus
import talus.mujoco as runtime
from support import REPOSITORY, run
from talus import check, constants, ffi, lib
from test_export_simulators import HELD, kinds

pytestmark = pytest.mark.spread

mujoco = pytest.importorskip("mujoco")

LEG, ARM = (REPOSITORY / "models" / f"{name}.yaml" for name in ("leg", "pendulum"))
STEP_s, SECONDS, ROWS = 5e-4, 10.0, 200
CREEP_rad_s = 1e-6  # of a joint that sticks in MuJoCo
INSTANT_s = 1e-10  # in which the library finds a state's accelerations
JOINT = {"knee": 0, "ankle": 1, "joint": 0}
PUSH = {"leg": ((0.08, 0.9, 0.0), (0.012, 1.7, 0.4)), "pendulum": ((1.6, 0.9, 0.0),)}  # Nm, Hz, rad


def model_of(plant, effects=(), dry=True, ratio=None):
    tree = talus.Model.read(LEG if plant == "leg" else ARM)
    model = talus.Model.from_text(tree.text())
    for j in range(len(model.joints)):
        if not dry:
            model.struct.drive[j].coulomb_Nm = 0.0
    if plant == "leg" and ratio:
        check(lib.tl_transmission_fixed(ffi.addressof(model.struct.drive[1], "transmission"), ratio))
    model.effects = [typical(name, joint, **values) for name, joint, values in effects]
    check(lib.tl_effects_check(ffi.new("tl_effect[]", model.effects or 1), len(model.effects), model.struct))
    return model


def typical(name, joint, **values):
    """The effect with its typical parameters, but for those given."""
    kind = lib.tl_effect_find(name.encode())
    effect = lib.tl_effect_typical(kind, constants.TL_MAX_JOINTS if joint == "base" else JOINT[joint])
    names = [ffi.string(kind.parameter[i].name).decode() for i in range(kind.strengths + kind.shapes)]
    for key, value in values.items():
        effect.value[names.index(key)] = value
    return effect


def push(plant, t):
    return [size * np.sin(2 * np.pi * hz * t + phase) for size, hz, phase in PUSH[plant]]


def simulation(model, q, v):
    """The library's, under the push: its state, and what goes on with it until an instant."""
    state, keep = ffi.new("tl_simulation *"), ffi.new("tl_effect[]", model.effects or 1)

    @ffi.callback("tl_torque_law")
    def law(_context, t, _motion, torque):
        for j, value in enumerate(push(model.plant, t)):
            torque[j] = value

    check(lib.tl_simulation_init(state, model.struct, q, v))
    state.effect, state.effects = keep, len(model.effects)
    return state, lambda until: check(lib.tl_simulate(model.struct, law, ffi.NULL, STEP_s, state, until)), (keep, law)


def by_library(model, seconds=SECONDS):
    """(rows, joints) positions of tl_simulate under the push."""
    state, go_on, _keep = simulation(model, [0.0, 0.0], [0.0, 0.0])
    out = []
    for k in range(1, ROWS + 1):
        go_on(k * seconds / ROWS)
        out.append([state.motion.q[j] for j in range(len(model.joints))])
    return np.array(out)


@dataclass
class Run:
    """A motion in MuJoCo. By row and joint: positions, and has its friction less than its level, as MuJoCo has it within a step of
    rest? By row and degree of freedom: the torque that moves it as the library has it at this state, and what MuJoCo's is off it."""

    step_s: float
    q: list = field(default_factory=list)
    soft: list = field(default_factory=list)
    torque: list = field(default_factory=list)
    off: list = field(default_factory=list)

    def add(self, model, simulated, data, memory):
        mujoco.mj_forward(simulated, data)
        mass, ours = np.zeros((simulated.nv, simulated.nv)), acceleration(model, simulated, data, memory)
        mujoco.mj_fullM(simulated, mass, data.qM)
        self.q.append([data.joint(name).qpos[0] for name in model.joints])
        self.torque.append(mass @ ours + data.qfrc_bias)
        self.off.append(mass @ (data.qacc - ours))
        self.soft.append(np.zeros(simulated.nv, bool))
        for row in np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF):
            dof = data.efc_id[row]
            rests = abs(data.qvel[dof]) < max(self.step_s * abs(ours[dof]), CREEP_rad_s)
            self.soft[-1][dof] = rests and abs(data.efc_force[row]) < 0.999 * data.efc_frictionloss[row]

    def apart(self):
        """RMS of what the torque is off, but where friction is soft, over the torque's RMS; the worst degree of freedom."""
        counts = ~np.array(self.soft)
        return np.max(np.sqrt(np.sum(np.array(self.off) ** 2 * counts, axis=0) / np.sum(counts, axis=0) / np.mean(np.array(self.torque) ** 2, axis=0)))


def acceleration(model, simulated, data, memory):
    """The library's at MuJoCo's state, for MuJoCo's degrees of freedom; `memory` is presliding's."""
    n, out = len(model.joints), np.zeros(simulated.nv)
    at = [simulated.joint(name) for name in model.joints]
    q, v = ([float(values[place[0]]) for place in places] for values, places in ((data.qpos, [x.qposadr for x in at]), (data.qvel, [x.dofadr for x in at])))
    state, go_on, _keep = simulation(model, q + [0.0] * (2 - n), v + [0.0] * (2 - n))
    state.t_s, state.link.begun = data.time, len(model.effects) > 0
    twists = [mujoco.mj_name2id(simulated, mujoco.mjtObj.mjOBJ_JOINT, f"{name}_twist") for name in model.joints]
    dofs = [simulated.jnt_dofadr[twist] for twist in twists]
    for j, twist in enumerate(twists):
        state.link.q[j], state.link.v[j], state.link.z[j] = q[j], v[j], memory[j]
        if twist >= 0:
            state.link.q[j] += data.qpos[simulated.jnt_qposadr[twist]]
            state.link.v[j] += data.qvel[dofs[j]]
    go_on(data.time + INSTANT_s)
    for j, twist in enumerate(twists):
        out[at[j].dofadr[0]] = state.motion.a[j]
        if twist >= 0:
            out[dofs[j]] = state.link.a[j] - state.motion.a[j]
    return out


def by_mujoco(model, carried, shown=lambda model, torque: torque, seconds=SECONDS, step_s=STEP_s):
    """The same in MuJoCo; what was pushed is held within stages as MuJoCo's integrator has it, so steps are short."""
    simulated, true = runtime.load(model), with_true_linkage(model)
    simulated.opt.timestep, simulated.opt.integrator = step_s, mujoco.mjtIntegrator.mjINT_RK4
    data, out = mujoco.MjData(simulated), Run(step_s)
    mine = runtime.Runtime(model, simulated, data) if carried else None

    def both(_model, d):  # before each evaluation of the actuators, at the stage's own time
        d.ctrl[:] = shown(model, push(model.plant, d.time))
        if mine:
            mine.forces()

    mujoco.set_mjcb_passive(both)
    try:
        every = round(seconds / ROWS / step_s)
        for _ in range(ROWS):
            if mine:
                mine.step(every)
            else:
                mujoco.mj_step(simulated, data, every)
            out.add(true, simulated, data, [drive.z for drive in mine._joints] if mine else [0.0, 0.0])
    finally:
        mujoco.set_mjcb_passive(None)
    return out


def apart(ours, theirs):
    """RMS difference of positions over the RMS of the motion, the worst joint."""
    return np.max(np.sqrt(np.mean((ours - theirs) ** 2, axis=0)) / np.sqrt(np.mean(ours**2, axis=0)))


def shown(model, torque):
    """What the current shows of a motor torque: with the effects of measurement, which no motion feels."""
    out = list(torque)
    for effect in model.effects:
        name, v = ffi.string(effect.kind.name), list(effect.value)
        if name == b"current_offset":
            out[effect.joint] += v[0] * (1.0 if model.plant == "leg" else 9.0)  # an arm counts torque behind its gear
        if name == b"torque_saturation":  # droop, exponent, begin
            x = torque[effect.joint]
            out[effect.joint] += v[0] * np.sign(x) * max(abs(x) - v[2], 0.0) ** (1.0 + v[1])
    return out


def with_true_linkage(model):
    """The library's simulation takes a model's linkage as it is: here with the dimensions that linkage_error gives."""
    out = model.copy()
    change = ffi.new("tl_effect_change *", lib.tl_effects_change(ffi.new("tl_effect[]", model.effects or 1), len(model.effects), 1))
    if change.AB_m or change.BO_m or change.AC_m or change.BOF_rad:
        drive, true = ffi.addressof(out.struct.drive[1], "transmission"), ffi.new("tl_transmission *")
        check(lib.tl_effect_change_linkage(change, drive, true))
        drive[0] = true[0]
        out.effects = []
    return out


name_of = lambda x: "+".join(e[0] for e in x) or "plain" if isinstance(x, list) else x  # noqa: E731
EXACT = [
    ("leg", []),
    ("leg", [("parallel_spring", "knee", {"bend_Nm_rad2": 2.0, "preload_Nm": 0.5}), ("parallel_spring", "ankle", {"stiffening_Nm_rad3": 3.0})]),
    ("leg", [("nonlinear_viscous", "knee", {"exponent": 2.0})]),
    ("leg", [("gravity_tilt", "base", {})]),
    ("leg", [("current_offset", "knee", {}), ("current_offset", "ankle", {})]),
    ("leg", [("elasticity", "knee", {"stiffness_Nm_rad": 500.0})]),
    ("pendulum", [("elasticity", "joint", {"stiffness_Nm_rad": 300.0, "hardening_Nm_rad3": 2000.0})]),
    ("pendulum", [("torque_constant", "joint", {"excess": 0.1})]),
    ("pendulum", [("current_offset", "joint", {})]),
]


@pytest.mark.parametrize(("plant", "effects"), EXACT, ids=name_of)
def test_the_file_alone_is_the_librarys_dynamics(plant, effects):
    """Without dry friction, whose sticking MuJoCo softens; the ankle's ratio constant, as the file has it."""
    model = model_of(plant, effects, dry=False, ratio=125.0)
    factor = 1.0 + sum(e.value[0] for e in model.effects if ffi.string(e.kind.name) == b"torque_constant")
    theirs = by_mujoco(model, carried=False, shown=lambda m, x: [y / factor for y in shown(m, x)])
    assert theirs.apart() < 1e-6 and not np.any(theirs.soft)
    assert apart(by_library(model), np.array(theirs.q)) < 1e-6


CARRIED = [[(name, joint, values)] for name, joint, values in (
    ("stribeck", "knee", {}),
    ("load_friction", "knee", {}),
    ("load_friction", "ankle", {"rotor_share": 0.0}),
    ("load_friction", "knee", {"rotor_share": 0.6}),
    ("asymmetric_friction", "knee", {}),
    ("position_friction", "knee", {}),
    ("friction_drift", "knee", {}),
    ("directional_efficiency", "knee", {}),
    ("kinematic_error", "knee", {}),
    ("cogging", "knee", {}),
    ("presliding", "knee", {}),
    ("backlash", "knee", {}),
    ("torque_saturation", "knee", {}),
    ("linkage_error", "ankle", {"BO_m": 0.001}),
)]  # fmt: skip
BEYOND = [[], *([(name, joint, values)] for name, joint, values in (  # the plain leg, and what is exact as its file has it no more
    ("nonlinear_viscous", "knee", {}),
    ("parallel_spring", "ankle", {"bumper_Nm_rad": 20.0, "bumper_rad": 0.05}),
    ("elasticity", "knee", {"soft_rad": 0.003, "soft_share": 0.4}),
    ("gravity_tilt", "base", {}),
    ("current_offset", "knee", {}),
))]  # fmt: skip
SHOWN = ("delay", "encoder_eccentricity", "sensor_offset")  # no motion feels them: talus.mujoco.Runtime.shown has them
LOST = ("base_compliance",)  # and so says the loss report


def test_every_effect_stands_in_one_list_and_the_loss_report_agrees():
    named = lambda cases: {name for effects in cases for name, _, _ in effects}  # noqa: E731
    lists = {"E": named(effects for _, effects in EXACT), "C": named(CARRIED) | set(SHOWN), "L": set(LOST)}
    assert sorted(name for names in lists.values() for name in names) == sorted(kinds()) and len(kinds()) == 22
    assert not named(CARRIED) & set(SHOWN) and named(BEYOND) <= lists["E"]
    assert {name: how for how, names in lists.items() for name in names} == {name: held[0] for name, held in HELD.items()}


def near(model, theirs, seconds=SECONDS):
    """Within 1e-3 of the torque but where a joint sticks or is within a step of rest, which is a fifth of the time at most."""
    assert theirs.apart() < 1e-3 and np.max(np.mean(theirs.soft, axis=0)) < 0.2
    assert apart(by_library(with_true_linkage(model), seconds), np.array(theirs.q)) < 1e-3


@pytest.mark.long
@pytest.mark.parametrize("effects", CARRIED + BEYOND, ids=name_of)
def test_callbacks_carry_the_rest(effects):
    """With the leg's dry friction and its linkage: what remains is how MuJoCo softens sticking, which falls with the step."""
    model = model_of("leg", effects)
    near(model, by_mujoco(model, carried=True, shown=shown, seconds=5.0, step_s=2.5e-4), 5.0)


@pytest.mark.long
def test_a_callback_carries_friction_and_its_linkage():
    model = model_of("leg", [("stribeck", "knee", {}), ("load_friction", "ankle", {})])
    near(model, by_mujoco(model, True, seconds=2.0, step_s=2.5e-4), 2.0)
    without = by_mujoco(model, False, seconds=2.0)
    assert without.apart() > 0.01 and apart(by_library(model, 2.0), np.array(without.q)) > 0.01  # and without it there is a gap


def bench(folder, name, effects):
    """Columns of talus-sim with exact sensors at each tick of its control, and the true motion."""
    model_of("leg", effects).write(folder / f"{name}.yaml")
    run("talus-sim", "--model", folder / f"{name}.yaml", "--out", folder / f"{name}.csv", "--motion", folder / "motion.csv", "--ideal",
        "--rate", 1000, "--duration", 2)  # fmt: skip
    return talus.Recording.read(folder / f"{name}.csv").columns, np.genfromtxt(folder / "motion.csv", delimiter=",", names=True)


def test_late_currents_are_those_of_the_simulated_bench(tmp_path):
    late = [("delay", "knee", {"delay_s": 0.004}), ("delay", "ankle", {"delay_s": 0.007})]
    (asked, _), (recorded, _) = bench(tmp_path, "plain", []), bench(tmp_path, "late", late)
    model = model_of("leg", late)
    simulated = runtime.load(model)
    data, seen = mujoco.MjData(simulated), {f"{name}_current_A": [] for name in model.joints}
    constants = [model.struct.drive[j].torque_constant_Nm_A for j in range(2)]
    simulated.opt.timestep = 1e-3
    with runtime.Runtime(model, simulated, data) as mine:
        for row in range(500):
            data.ctrl[:] = [asked[column][row] * constant for column, constant in zip(seen, constants, strict=True)]
            mine.step()
            for column, values in seen.items():
                values.append(mine.shown()[column])
    for column, values in seen.items():
        theirs = recorded[column][10:500]  # before, the bench has currents from its settling
        np.testing.assert_allclose(values[10:], theirs, atol=1e-9)
        assert np.max(abs(asked[column][10:500] - theirs)) > 1e-3


def test_encoders_err_as_those_of_the_simulated_bench(tmp_path):
    effects = [("encoder_eccentricity", "ankle", {"motor_sine_rad": 0.05, "joint_cosine_rad": 0.002})]
    recorded, true = bench(tmp_path, "off", effects)
    model = model_of("leg", effects)
    simulated = runtime.load(model)
    data = mujoco.MjData(simulated)
    mine, plain = (runtime.Runtime(m, simulated, data) for m in (model, model_of("leg")))
    for row in range(0, 2000, 40):
        for name in model.joints:
            data.joint(name).qpos[0] = true[f"{name}_position_rad"][row]
        for column in ("knee_motor_rad", "ankle_motor_rad", "ankle_joint_rad"):
            assert mine.shown()[column] == pytest.approx(recorded[column][row], abs=1e-9)
        assert abs(mine.shown()["ankle_joint_rad"] - plain.shown()["ankle_joint_rad"]) > 1e-3


PAYLOAD = ((1.5, 0.7, 0.3), (0.6, 2.3, 1.0))  # Nm, Hz, rad: what else pushes at the joint


def loaded(model, seconds=8.0, step_s=5e-4, every=8):
    """(columns that the Runtime shows of an arm, pushed by its drive and by something else; what that something was)"""
    simulated = runtime.load(model)
    simulated.opt.timestep = step_s
    data, rows, pushed = mujoco.MjData(simulated), [], []
    with runtime.Runtime(model, simulated, data) as mine:
        for k in range(round(seconds / step_s)):
            data.ctrl[:] = push(model.plant, data.time)
            data.qfrc_applied[0] = sum(size * np.sin(2 * np.pi * hz * data.time + phase) for size, hz, phase in PAYLOAD)
            if k % every == 0:
                mujoco.mj_forward(simulated, data)
                rows.append({"time_s": data.time, **mine.shown()})
                pushed.append(data.qfrc_applied[0])
            mine.step()
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}, np.array(pushed)


@pytest.mark.parametrize("others", [
    pytest.param([], marks=pytest.mark.long), [("stribeck", "joint", {}), ("cogging", "joint", {}), ("torque_constant", "joint", {"excess": 0.1})]], ids=name_of)
def test_a_sensor_at_the_output_shows_what_else_pushes_and_its_zero(others):
    """To the last digits, also while the joint sticks; and as the library predicts it, which knows no payload."""
    model = model_of("pendulum", [*others, ("sensor_offset", "joint", {"offset_Nm": 0.3})])
    columns, pushed = loaded(model)
    np.testing.assert_allclose(columns["joint_load_Nm"], 0.3 - pushed, atol=1e-9)
    recording = talus.Recording({name: columns[name] for name in ("time_s", "joint_rad", "joint_current_A", "joint_load_Nm")})
    off = talus.score(model, recording, talus.predict(model, recording))["joint"]
    without = model_of("pendulum", others)
    assert off["rms"] < 0.02 and talus.score(without, recording, talus.predict(without, recording))["joint"]["rms"] == pytest.approx(0.3, rel=0.1)
