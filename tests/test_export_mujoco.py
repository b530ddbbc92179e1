"""talus-export --to mjcf and talus.mujoco: MuJoCo's motion under open-loop torque against the library's forward dynamics."""

import numpy as np
import pytest
import talus
import talus.mujoco as runtime
from support import REPOSITORY
from talus import check, constants, ffi, lib

mujoco = pytest.importorskip("mujoco")

LEG, ARM = (REPOSITORY / "models" / f"{name}.yaml" for name in ("leg", "pendulum"))
STEP_s, SECONDS, ROWS = 5e-4, 10.0, 200
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


def by_library(model, seconds=SECONDS):
    """(rows, joints) positions of tl_simulate under the push."""
    state, keep = ffi.new("tl_simulation *"), ffi.new("tl_effect[]", model.effects or 1)

    @ffi.callback("tl_torque_law")
    def law(_context, t, _motion, torque):
        for j, value in enumerate(push(model.plant, t)):
            torque[j] = value

    check(lib.tl_simulation_init(state, model.struct, [0.0, 0.0], [0.0, 0.0]))
    state.effect, state.effects = keep, len(model.effects)
    out, joints = [], ffi.new("tl_motion *")
    for k in range(1, ROWS + 1):
        check(lib.tl_simulate(model.struct, law, ffi.NULL, STEP_s, state, k * seconds / ROWS))
        lib.tl_simulation_joints(model.struct, state, joints)
        out.append([state.motion.q[j] for j in range(len(model.joints))])
    return np.array(out)


def by_mujoco(model, carried, shown=lambda model, torque: torque, simulated=None, seconds=SECONDS, step_s=STEP_s):
    """The same in MuJoCo; what was pushed is held within stages as MuJoCo's integrator has it, so steps are short."""
    simulated = simulated if simulated is not None else runtime.load(model)
    simulated.opt.timestep, simulated.opt.integrator = step_s, mujoco.mjtIntegrator.mjINT_RK4
    data, out = mujoco.MjData(simulated), []
    mine = runtime.Runtime(model, simulated, data) if carried else None

    def control(_model, data):  # before each evaluation of the actuators, at the stage's own time
        data.ctrl[:] = shown(model, push(model.plant, data.time))

    def both(m, d):
        control(m, d)
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
            out.append([data.joint(name).qpos[0] for name in model.joints])
    finally:
        mujoco.set_mjcb_passive(None)
    return np.array(out)


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
    assert apart(by_library(model), theirs) < 1e-6


CARRIED = [[], *([(name, joint, values)] for name, joint, values in (
    ("stribeck", "knee", {}),
    ("load_friction", "knee", {}),
    ("load_friction", "ankle", {"rotor_share": 0.0}),
    ("asymmetric_friction", "knee", {}),
    ("nonlinear_viscous", "knee", {}),
    ("position_friction", "knee", {}),
    ("friction_drift", "knee", {}),
    ("directional_efficiency", "knee", {}),
    ("kinematic_error", "knee", {}),
    ("cogging", "knee", {}),
    ("parallel_spring", "ankle", {"bumper_Nm_rad": 20.0, "bumper_rad": 0.05}),
    ("gravity_tilt", "base", {}),
    ("presliding", "knee", {}),
    ("elasticity", "knee", {"soft_rad": 0.003, "soft_share": 0.4}),
    ("backlash", "knee", {}),
    ("torque_saturation", "knee", {}),
    ("current_offset", "knee", {}),
    ("linkage_error", "ankle", {"BO_m": 0.001}),
))]  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("effects", CARRIED, ids=name_of)
def test_callbacks_carry_the_rest(effects):
    """With the leg's dry friction and its linkage: what remains is how MuJoCo softens sticking, which falls with the step."""
    model = model_of("leg", effects)
    theirs = by_mujoco(model, carried=True, shown=shown, step_s=2.5e-4)
    assert apart(by_library(with_true_linkage(model)), theirs) < 1e-3


def test_a_callback_carries_friction_and_its_linkage():
    model = model_of("leg", [("stribeck", "knee", {}), ("load_friction", "ankle", {})])
    assert apart(by_library(model, 2.0), by_mujoco(model, True, seconds=2.0, step_s=2.5e-4)) < 1e-3
    assert apart(by_library(model, 2.0), by_mujoco(model, False, seconds=2.0)) > 0.01  # and without it there is a gap
