"""talus/plant.h against a symbolic Lagrangian, MuJoCo, the printed equations, energy and its own inverses."""

import json
import math
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from leg_example import EXAMPLE, EXAMPLE_DRIVES, fixed, fourier, leg, linkage, table
from scipy.integrate import solve_ivp
from talus import check, constants, ffi, lib, pointer

VECTORS = Path(__file__).parent / "vectors"
RANGE = constants.TL_JOINT_RANGE_RAD
ROW = constants.TL_MAX_ROW
EPS = 2.0**-52
SERIES = (1.1, [0.4, -1.5, 0.6, -0.2, 0.05], [118.0, 14.0, 4.0, 2.0])
ANKLES = {
    "linkage": lambda: (linkage(), None),
    "fixed": lambda: (fixed(115.0), None),
    "fourier": lambda: (fourier(*SERIES), None),
    "table": lambda: table(linkage(), 65),
}


def pendulum(moment=0.8, zero=0.3, offset=0.05):
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_PENDULUM))
    m.inertia_kg_m2, m.gravity_moment_kg_m = 0.21, moment
    m.gravity_zero_rad, m.torque_offset_Nm = zero, offset
    m.drive[0].torque_constant_Nm_A, m.drive[0].coulomb_Nm, m.drive[0].viscous_Nms_rad = 0.1, 0.4, 0.11
    m.drive[0].transmission = fixed(100.0)[0]
    check(lib.tl_model_check(m))
    return m


def slider():
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_SLIDER))
    m.mass_kg, m.force_offset_N = 95.0, -3.0
    m.drive[0].coulomb_Nm, m.drive[0].viscous_Nms_rad = 20.0, 210.0
    check(lib.tl_model_check(m))
    return m


def leg_with(made, friction=True):
    """A leg and what must live as long."""
    return leg(made[0], friction), made


PLANTS = {
    **{f"leg, {name}": lambda make=make: leg_with(make()) for name, make in ANKLES.items()},
    "leg, paper": lambda: (paper(leg()), None),
    "pendulum": lambda: (pendulum(), None),
    "slider": lambda: (slider(), None),
}


@pytest.fixture(params=PLANTS)
def plant(request):
    """A model; a table's knots live as long as the test."""
    model, _knots = PLANTS[request.param]()
    yield model


def paper(model):
    model.form = lib.TL_FORM_PAPER
    return model


def states(n, seed=1, joints=2):
    """Random q, v, a, slip: (joints, n) each."""
    rng = np.random.default_rng(seed)
    sizes = ([[1.5], [RANGE]], [[6.0], [6.0]], [[60.0], [60.0]], [[1.0], [1.0]])
    return [(rng.uniform(-1.0, 1.0, (2, n)) * size)[:joints].copy() for size in sizes]


def motion_at(q, v, a, slip, i):
    """Instant i as a tl_motion."""
    joints = len(q)
    out = ffi.new("tl_motion *")
    for field, values in zip((out.q, out.v, out.a, out.slip), (q, v, a, slip)):
        for j in range(joints):
            field[j] = values[j, i]
    return out


def inverse(model, motion):
    out = ffi.new("double[2]")
    lib.tl_inverse(model, motion, out)
    return np.array([*out])[: lib.tl_joint_count(model)]


def batch(model, q, v, a, slip):
    torque = np.empty_like(q)
    lib.tl_inverse_batch(model, q.shape[1], *(pointer(x) for x in (q, v, a, slip)), pointer(torque))
    return torque


def inertia_matrix(model, q):
    joints = lib.tl_joint_count(model)
    out = ffi.new("double[4]")
    lib.tl_inertia_matrix(model, list(q) + [0.0] * (2 - len(q)), out)
    return np.array([*out])[: joints * joints].reshape(joints, joints)


def energy(model, motion):
    out = ffi.new("double[2]")
    lib.tl_energy(model, motion, out, out + 1)
    return out[0], out[1]


def ratios(model, q):
    out = ffi.new("double[2]")
    lib.tl_joint_torque(model, list(q), [1.0, 1.0], out)
    return np.array([*out])


# ---- against the Lagrangian -------------------------------------------------------


def model_of(parameters):
    """A leg from the vectors' parameters."""
    p = {name: float.fromhex(value) for name, value in parameters.items()}
    m = leg(linkage([p[name] for name in ("lead_m", "AB_m", "BO_m", "AC_m", "BOF_deg")]))
    for name in EXAMPLE:
        setattr(m, name, p[name])
    m.drive[0].transmission = fixed(p["knee_ratio"])[0]
    m.drive[1].rotor_inertia_kg_m2 = p["ankle_rotor_inertia_kg_m2"]
    for joint, name in enumerate(("knee", "ankle")):
        m.drive[joint].coulomb_Nm = p[f"{name}_coulomb_Nm"]
        m.drive[joint].viscous_Nms_rad = p[f"{name}_viscous_Nms_rad"]
    return m


def lagrangian_states():
    """(model, motion, torque, kinetic, potential) of every state in the vectors."""
    for content in json.loads((VECTORS / "leg_lagrange.json").read_text())["legs"]:
        model = model_of(content["parameters"])
        for state in content["states"]:
            s = {key: [float.fromhex(x) for x in values] for key, values in state.items()}
            motion = ffi.new("tl_motion *", {key: s[key] for key in ("q", "v", "a", "slip")})
            yield model, motion, s["torque"], s["kinetic_J"][0], s["potential_J"][0]


def test_inverse_is_the_lagrangian():
    count, worst = 0, 0.0
    for model, motion, torque, _, _ in lagrangian_states():
        worst = max(worst, np.max(np.abs(inverse(model, motion) / torque - 1.0)))
        count += 1
    print(f"\nworst relative error of {count} states: {worst:.1e}")
    assert count == 200
    assert worst <= 1e-10


def test_energy_is_the_lagrangian():
    for model, motion, _, kinetic, potential in lagrangian_states():
        assert energy(model, motion) == pytest.approx((kinetic, potential), rel=1e-13)


def test_vectors_are_what_their_script_makes(monkeypatch):
    monkeypatch.syspath_prepend(str(VECTORS))
    import leg_lagrange

    try:
        assert leg_lagrange.text(leg_lagrange.make()) == (VECTORS / "leg_lagrange.json").read_text()
    finally:
        sys.modules.pop("leg_lagrange", None)


# ---- against MuJoCo ------------------------------------------------------------------


def mujoco_leg(ankle_ratio):
    """The example leg with constant ratios: the ankle's rotor is the joint's armature."""
    p = EXAMPLE
    rotor = EXAMPLE_DRIVES[1]["rotor_inertia_kg_m2"] * ankle_ratio**2
    damping = [EXAMPLE_DRIVES[j]["viscous_Nms_rad"] for j in range(2)]
    # the ankle's motor is a point; MuJoCo wants an inertia, which is taken from the shank's
    speck = 1e-6

    def body(mass, com, inertia):
        return f'<inertial pos="0 0 {-com}" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>'

    return mujoco.MjModel.from_xml_string(f"""
      <mujoco><option gravity="0 0 -{p["gravity_m_s2"]}"><flag contact="disable"/></option>
      <worldbody><body>
        <joint name="knee" type="hinge" axis="0 1 0" damping="{damping[0]}"/>
        {body(p["shank_mass_kg"], p["shank_com_m"], p["shank_inertia_kg_m2"] - speck)}
        <body>{body(p["ankle_motor_mass_kg"], p["ankle_motor_com_m"], speck)}</body>
        <body pos="0 0 {-p["shank_length_m"]}">
          <joint name="ankle" type="hinge" axis="0 1 0" damping="{damping[1]}" armature="{rotor}"/>
          {body(p["foot_mass_kg"], p["foot_com_m"], p["foot_inertia_kg_m2"])}
        </body>
      </body></worldbody></mujoco>""")


def test_inverse_is_mujoco():
    """Joint torques with gravity and viscous friction, 1000 random states."""
    reference = mujoco_leg(115.0)
    data = mujoco.MjData(reference)
    model = leg(fixed(115.0))
    model.drive[0].coulomb_Nm = model.drive[1].coulomb_Nm = 0.0
    q, v, a, slip = states(1000)
    ours = batch(model, q, v, a, slip) * np.array([[51.0], [115.0]])
    worst = 0.0
    for i in range(1000):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[:, i], v[:, i], a[:, i]
        mujoco.mj_inverse(reference, data)
        worst = max(worst, np.max(np.abs(ours[:, i] - data.qfrc_inverse)))
    print(f"\nlargest difference from MuJoCo: {worst:.1e} Nm of {np.abs(ours).max():.0f} Nm")
    assert worst <= 1e-9


# ---- against the equations as they are printed ---------------------------------------


def printed_rows(model, m, form):
    """Motor torques from rows s and f of docs/equations.md (12), in absolute angles."""
    knee, ankle = model.drive[0], model.drive[1]
    ts, tf = m.q[0], m.q[0] + m.q[1]
    vs, vf, acc_s, acc_f = m.v[0], m.v[0] + m.v[1], m.a[0], m.a[0] + m.a[1]
    c, s = math.cos(ts - tf), math.sin(ts - tf)
    g, ls, ms, mf = model.gravity_m_s2, model.shank_length_m, model.shank_mass_kg, model.foot_mass_kg
    ds, df, mm, dma = model.shank_com_m, model.foot_com_m, model.ankle_motor_mass_kg, model.ankle_motor_com_m
    rotor = ankle.rotor_inertia_kg_m2
    out = ffi.new("double[2]")
    lib.tl_transmission_ratio(ffi.addressof(ankle, "transmission"), m.q[1], out, out + 1)
    ka, slope = out
    J = model.shank_inertia_kg_m2 + ms * ds**2 + mm * dma**2 + mf * ls**2
    sign = -1.0 if form == "lagrange" else 3.0
    row_s = (
        (J + rotor * ka**2) * acc_s + (mf * ls * df * c - rotor * ka**2) * acc_f + mf * ls * df * s * vf**2
        + sign * rotor * ka * slope * (vf - vs) ** 2 + (ms * ds + mm * dma + mf * ls) * g * math.sin(ts)
    )  # fmt: skip
    row_f = (
        (mf * ls * df * c - rotor * ka**2) * acc_s
        + (model.foot_inertia_kg_m2 + mf * df**2 + rotor * ka**2) * acc_f
        - mf * ls * df * s * vs**2 - sign * rotor * ka * slope * (vf - vs) ** 2 + mf * df * g * math.sin(tf)
    )  # fmt: skip
    friction_s = knee.coulomb_Nm * m.slip[0] + knee.viscous_Nms_rad * vs
    friction_f = ankle.coulomb_Nm * m.slip[1] + ankle.viscous_Nms_rad * (vf if form == "paper" else vf - vs)
    torque_f = row_f + friction_f  # of the motor, at the joint
    # row s = knee - ankle (net of friction); in print: Tms - friction_s - Tmf - friction_f
    net = torque_f + friction_f if form == "paper" else torque_f - friction_f
    return [(row_s + net + friction_s) / knee.transmission.ratio, torque_f / ka]


@pytest.mark.parametrize("form", ["lagrange", "paper"])
def test_inverse_is_the_printed_rows(form):
    model = paper(leg()) if form == "paper" else leg()
    q, v, a, slip = states(1000)
    torque = batch(model, q, v, a, slip)
    for i in range(1000):
        expected = printed_rows(model, motion_at(q, v, a, slip, i), form)
        assert np.allclose(torque[:, i], expected, rtol=1e-13, atol=1e-14)


def test_forms_differ():
    """The print's three slips move the torques by more than the noise of any current."""
    q, v, a, slip = states(1000)
    difference = batch(leg(), q, v, a, slip) - batch(paper(leg()), q, v, a, slip)
    assert np.sqrt(np.mean(difference**2, axis=1)).min() > 1e-3


# ---- inverse and forward ---------------------------------------------------------------


def test_forward_undoes_inverse(plant):
    """10,000 states: accelerations from torques, torques again; and the same accelerations come back."""
    joints = lib.tl_joint_count(plant)
    q, v, a, slip = states(10000, joints=joints)
    torque = batch(plant, q, v, a, slip)
    reached = np.empty_like(a)
    for i in range(10000):
        motion = motion_at(q, v, np.full_like(a, math.nan), slip, i)
        assert lib.tl_forward(plant, [*torque[:, i]], motion) == lib.TL_OK
        reached[:, i] = [*motion.a][:joints]
    again = batch(plant, q, v, reached, slip)
    size = np.linalg.norm(torque, axis=0)
    assert (np.linalg.norm(again - torque, axis=0) / size).max() <= 1e-12
    assert (np.abs(reached - a)).max() <= 1e-12 * 60.0


def test_forward_refuses_what_has_no_inertia(plant):
    model = ffi.new("tl_model *", plant[0])
    joints = lib.tl_joint_count(model)
    model.shank_mass_kg = model.foot_mass_kg = model.ankle_motor_mass_kg = model.shank_inertia_kg_m2 = 0.0
    model.foot_inertia_kg_m2 = model.drive[1].rotor_inertia_kg_m2 = model.inertia_kg_m2 = model.mass_kg = 0.0
    motion = ffi.new("tl_motion *", {"a": [7.0, 8.0]})
    assert lib.tl_forward(model, [1.0, 1.0], motion) == lib.TL_ERR_SINGULAR
    assert [*motion.a][:joints] == [7.0, 8.0][:joints]


def test_inertia_matrix_is_positive_and_what_inverse_uses(plant):
    joints = lib.tl_joint_count(plant)
    q, v, _, slip = states(200, joints=joints)
    for i in range(200):
        matrix = inertia_matrix(plant, q[:, i])
        assert np.array_equal(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix).min() > 0.0
        scale = ratios(plant, [*q[:, i], 0.0][:2])[:joints]
        motion = motion_at(q, v, np.zeros_like(q), slip, i)
        rest = inverse(plant, motion) * scale
        for j in range(joints):
            motion.a[0], motion.a[1] = float(j == 0), float(j == 1)
            column = inverse(plant, motion) * scale - rest
            assert np.abs(column - matrix[:, j]).max() <= 1e-12 * (np.abs(rest).max() + matrix.max())


# ---- energy ------------------------------------------------------------------------------


def swing(model, start, seconds, torque=lambda t: (0.0, 0.0)):
    """Integrates the plant from (q, v): the states at 101 times, and the work done on it until then by
    `torque` and by viscous friction."""
    joints = lib.tl_joint_count(model)
    motion = ffi.new("tl_motion *")
    viscous = np.array([model.drive[j].viscous_Nms_rad for j in range(joints)])

    def rate(t, x):
        for j in range(joints):
            motion.q[j], motion.v[j] = x[j], x[joints + j]
        applied = torque(t)
        check(lib.tl_forward(model, applied, motion))
        v = x[joints : 2 * joints]
        power = v @ (ratios(model, [*motion.q])[:joints] * applied[:joints]) - viscous @ v**2
        return [*v, *[*motion.a][:joints], power]

    times = np.linspace(0.0, seconds, 101)
    done = solve_ivp(rate, (0.0, seconds), [*start, 0.0], "DOP853", times, rtol=1e-13, atol=1e-13)
    assert done.success
    return done.y[: 2 * joints], done.y[-1]


def energies(model, path):
    joints = lib.tl_joint_count(model)
    motions = [ffi.new("tl_motion *", {"q": [*x[:joints]], "v": [*x[joints:]]}) for x in path.T]
    return np.array([sum(energy(model, motion)) for motion in motions])


FREE_SWINGS = {
    **{name: lambda make=make: leg_with(make(), friction=False) for name, make in ANKLES.items()},
    "pendulum": lambda: (frictionless(pendulum(offset=0.0)), None),
}
START = {1: [1.2, -2.0], 2: [0.5, 0.2, 1.0, -1.5]}
GENTLE = [0.25, 0.1, 0.5, -0.6]  # keeps the ankle in the range of the approximations


def frictionless(model):
    for j in range(2):
        model.drive[j].coulomb_Nm = model.drive[j].viscous_Nms_rad = 0.0
    return model


@pytest.mark.parametrize("name", FREE_SWINGS)
def test_energy_is_kept_without_friction(name):
    model, _knots = FREE_SWINGS[name]()
    gentle = name in ("fourier", "table")
    path, _ = swing(model, GENTLE if gentle else START[lib.tl_joint_count(model)], 10.0)
    total = energies(model, path)
    drift = np.abs(total / total[0] - 1.0).max()
    print(f"\n{name}: energy drift {drift:.1e} in 10 s, second coordinate within {np.abs(path[1]).max():.2f}")
    assert drift <= 1e-8
    assert not gentle or np.abs(path[1]).max() < RANGE


def test_printed_form_does_not_keep_energy():
    model = paper(leg(friction=False))
    path, _ = swing(model, START[2], 10.0)
    total = energies(model, path)
    drift = np.abs(total / total[0] - 1.0).max()
    print(f"\nform paper: energy drift {drift:.1e} in 10 s")
    assert drift > 1e-3


def test_energy_changes_by_the_work_done():
    """Motor torques put in, viscous friction takes out."""
    model = leg()
    model.drive[0].coulomb_Nm = model.drive[1].coulomb_Nm = 0.0
    path, work = swing(model, START[2], 4.0, lambda t: (0.05 * math.sin(7.0 * t), 0.01 * math.cos(5.0 * t)))
    total = energies(model, path)
    assert np.abs(work).max() > 0.1
    assert np.abs(total - total[0] - work).max() <= 1e-8 * total.max()


# ---- regressor and base parameters -------------------------------------------------------


def base_values(model):
    out = np.empty(lib.tl_base_count(model))
    lib.tl_base_values(model, pointer(out))
    return out


def parameters(model):
    n = ffi.new("int *")
    table_of = lib.tl_parameters(model, n)
    return [table_of[i] for i in range(n[0])]


def values(model):
    out = np.empty(len(parameters(model)))
    lib.tl_parameters_get(model, pointer(out))
    return out


def jacobian(model):
    out = np.full((lib.tl_base_count(model), len(parameters(model))), math.nan)
    lib.tl_base_jacobian(model, pointer(out))
    return out


def rows(model, motion):
    """Dense regressor (joints x bases) and what is known."""
    joints = lib.tl_joint_count(model)
    row, known, index = ffi.new("double[]", [math.nan] * 2 * ROW), ffi.new("double[2]"), ffi.new("int[]", ROW)
    lib.tl_regressor(model, motion, row, known)
    dense = np.zeros((joints, lib.tl_base_count(model)))
    for j in range(joints):
        n = lib.tl_row_index(model, j, index)
        assert len({*index[0:n]}) == n and [*row[j * ROW + n : (j + 1) * ROW]] == [0.0] * (ROW - n)
        dense[j, [*index[0:n]]] = [*row[j * ROW : j * ROW + n]]
    return dense, np.array([*known])[:joints]


def test_regressor_times_base_is_inverse(plant):
    q, v, a, slip = states(2000, joints=lib.tl_joint_count(plant))
    base = base_values(plant)
    for i in range(2000):
        motion = motion_at(q, v, a, slip, i)
        row, known = rows(plant, motion)
        size = np.abs(row) @ np.abs(base) + np.abs(known)
        # at most a dozen roundings of the terms, in either sum
        assert np.all(np.abs(row @ base + known - inverse(plant, motion)) <= 16 * EPS * size)


def test_regressor_does_not_look_at_what_is_identified(plant):
    q, v, a, slip = states(5, joints=lib.tl_joint_count(plant))
    other = ffi.new("tl_model *", plant[0])
    lib.tl_parameters_set(other, pointer(values(plant) * 1.7 + 0.1))
    for i in range(5):
        motion = motion_at(q, v, a, slip, i)
        assert all(np.array_equal(x, y) for x, y in zip(rows(plant, motion), rows(other, motion)))


def test_base_jacobian_is_the_derivative(plant):
    p = values(plant)
    claimed = jacobian(plant)
    moved = ffi.new("tl_model *", plant[0])
    for k, value in enumerate(p):
        step = 1e-4 * abs(value)
        sides = []
        for sign in (1.0, -1.0):
            q = p.copy()
            q[k] += sign * step
            lib.tl_parameters_set(moved, pointer(q))
            sides.append(base_values(moved))
        slope = (sides[0] - sides[1]) / (2 * step)
        # quadratic in all but the pendulum's zero, whose third derivative brings step^2 / 6; else rounding
        rounding = 1e-10 * np.abs(base_values(plant)).max() / abs(value)
        assert np.allclose(slope, claimed[:, k], rtol=1e-8, atol=rounding)


@pytest.mark.parametrize("ankle", ["linkage", "fixed"])
def test_one_direction_of_the_ten_cannot_be_identified(ankle):
    """Centres and inertia of the shank: two base numbers for three parameters."""
    transmission, _ = ANKLES[ankle]()
    model = leg(transmission)
    q, v, a, slip = states(2000)
    slip = np.sign(slip)
    stacked = np.vstack([rows(model, motion_at(q, v, a, slip, i))[0] for i in range(2000)])
    scaled = stacked @ jacobian(model) * values(model)  # relative changes of the parameters
    _, singular, directions = np.linalg.svd(scaled, full_matrices=False)
    print(f"\n{ankle}: singular values {singular[0]:.1e} .. {singular[8]:.1e}, {singular[9]:.1e}")
    assert singular[9] <= 1e-13 * singular[0]
    assert singular[8] >= 1e-6 * singular[0]
    # the direction itself: moment and inertia of the shank stay what they are
    names = [ffi.string(p.name).decode() for p in parameters(model)]
    null = dict(zip(names, directions[9] * values(model)))
    shank = model.shank_mass_kg * null["shank_com_m"]
    motor = model.ankle_motor_mass_kg * null["ankle_motor_com_m"]
    turning = 2 * (model.shank_com_m * shank + model.ankle_motor_com_m * motor)
    assert abs(shank + motor) <= 1e-12
    assert abs(null["shank_inertia_kg_m2"] + turning) <= 1e-12
    assert max(abs(null[n]) for n in names if not n.startswith(("shank", "ankle_motor"))) <= 1e-12


LEG_BASES = [
    "shank_inertia", "shank_moment", "foot_moment", "foot_inertia", "ankle_rotor_inertia",
    "knee_coulomb", "knee_viscous", "ankle_coulomb", "ankle_viscous",
]  # fmt: skip
LEG_PARAMETERS = [
    "ankle_motor_com_m", "foot_com_m", "shank_com_m", "shank_inertia_kg_m2", "ankle_rotor_inertia_kg_m2",
    "foot_inertia_kg_m2", "knee_coulomb_Nm", "knee_viscous_Nms_rad", "ankle_coulomb_Nm",
    "ankle_viscous_Nms_rad",
]  # fmt: skip
PENDULUM_BASES = ["inertia", "gravity_sin", "gravity_cos", "torque_offset", "coulomb", "viscous"]
PENDULUM_PARAMETERS = [
    "inertia_kg_m2", "gravity_moment_kg_m", "gravity_zero_rad", "torque_offset_Nm", "coulomb_Nm",
    "viscous_Nms_rad",
]  # fmt: skip
SLIDER_BASES = ["mass", "coulomb", "viscous", "force_offset"]
SLIDER_PARAMETERS = ["mass_kg", "coulomb_N", "viscous_Ns_m", "force_offset_N"]


@pytest.mark.parametrize(
    ("make", "joints", "bases", "names", "unbounded"),
    [
        (leg, ["knee", "ankle"], LEG_BASES, LEG_PARAMETERS, []),
        (pendulum, ["joint"], PENDULUM_BASES, PENDULUM_PARAMETERS, ["gravity_zero_rad", "torque_offset_Nm"]),
        (slider, ["slider"], SLIDER_BASES, SLIDER_PARAMETERS, ["force_offset_N"]),
    ],
)
def test_names_and_bounds(make, joints, bases, names, unbounded):
    model = make()
    assert lib.tl_joint_count(model) == len(joints)
    assert [ffi.string(lib.tl_joint_name(model, j)).decode() for j in range(len(joints))] == joints
    assert lib.tl_joint_name(model, len(joints)) == lib.tl_joint_name(model, -1) == ffi.NULL
    assert lib.tl_base_count(model) == len(bases) <= constants.TL_MAX_BASE
    assert [ffi.string(lib.tl_base_name(model, b)).decode() for b in range(len(bases))] == bases
    assert lib.tl_base_name(model, len(bases)) == lib.tl_base_name(model, -1) == ffi.NULL
    assert [ffi.string(p.name).decode() for p in parameters(model)] == names
    assert len(names) <= constants.TL_MAX_PARAMETERS
    for name, p in zip(names, parameters(model)):
        assert p.lower == (-math.inf if name in unbounded else 0.0)


def test_leg_parameters_stand_where_their_names_say():
    model = leg()
    assert [*values(model)] == [0.120, 0.055, 0.160, 0.0420, 2.4e-6, 0.0021, 1.2, 0.45, 0.8, 0.30]
    lib.tl_parameters_set(model, pointer(np.arange(1.0, 11.0)))
    assert (model.ankle_motor_com_m, model.foot_com_m, model.shank_com_m) == (1.0, 2.0, 3.0)
    assert (model.shank_inertia_kg_m2, model.foot_inertia_kg_m2) == (4.0, 6.0)
    assert model.drive[1].rotor_inertia_kg_m2 == 5.0
    assert (model.drive[0].coulomb_Nm, model.drive[0].viscous_Nms_rad) == (7.0, 8.0)
    assert (model.drive[1].coulomb_Nm, model.drive[1].viscous_Nms_rad) == (9.0, 10.0)


def test_leg_base_values():
    expected = [
        0.0420 + 1.624 * 0.160**2 + 0.4112 * 0.120**2, 1.624 * 0.160 + 0.4112 * 0.120,
        0.442 * 0.055, 0.0021 + 0.442 * 0.055**2, 2.4e-6, 1.2, 0.45, 0.8, 0.30,
    ]  # fmt: skip
    assert np.allclose(base_values(leg()), expected, rtol=1e-15, atol=0.0)


@pytest.mark.parametrize(
    ("form", "knee", "ankle"),
    [("lagrange", [0, 1, 2, 3, 5, 6], [2, 3, 4, 7, 8]), ("paper", [0, 1, 2, 3, 5, 6, 7, 8], [2, 3, 4, 7, 8])],
)
def test_leg_row_index(form, knee, ankle):
    model = paper(leg()) if form == "paper" else leg()
    index = ffi.new("int[]", ROW)
    for joint, expected in enumerate((knee, ankle)):
        assert [*index[0 : lib.tl_row_index(model, joint, index)]] == expected
    assert lib.tl_row_index(model, 2, index) == lib.tl_row_index(model, -1, index) == 0


# ---- pendulum, slider, the rest ------------------------------------------------------------


def test_pendulum_and_slider_by_hand():
    motion = ffi.new("tl_motion *", {"q": [0.7], "v": [-1.5], "a": [4.0], "slip": [-1.0]})
    by_hand = 0.21 * 4.0 + 0.8 * 9.81 * math.sin(0.7 - 0.3) + 0.05 - 0.4 - 0.11 * 1.5
    assert inverse(pendulum(), motion)[0] == pytest.approx(by_hand, rel=1e-14)
    assert inverse(slider(), motion)[0] == pytest.approx(95.0 * 4.0 - 20.0 - 210.0 * 1.5 - 3.0, rel=1e-14)
    kinetic = 0.5 * 0.21 * 1.5**2
    assert energy(pendulum(), motion) == pytest.approx((kinetic, 0.8 * 9.81 * (1 - math.cos(0.4))), rel=1e-14)
    assert energy(slider(), motion) == pytest.approx((0.5 * 95.0 * 1.5**2, 0.0), rel=1e-14)


def test_joint_torque():
    out = ffi.new("double[2]")
    model = leg()
    lib.tl_joint_torque(model, [0.3, 0.1], [0.2, 0.04], out)
    slope = ffi.new("double[2]")
    lib.tl_transmission_ratio(linkage(), 0.1, slope, slope + 1)
    assert [*out] == [51.0 * 0.2, slope[0] * 0.04]
    lib.tl_joint_torque(pendulum(), [0.3, 0.0], [2.5, 0.0], out)
    assert out[0] == 2.5


def test_batch_is_the_loop(plant):
    joints = lib.tl_joint_count(plant)
    q, v, a, slip = states(300, joints=joints)
    v[:, 7] = 0.0  # at rest: no direction
    given, free = batch(plant, q, v, a, slip), batch(plant, q, v, a, None)
    for i in range(300):
        motion = motion_at(q, v, a, slip, i)
        assert np.array_equal(given[:, i], inverse(plant, motion))
        lib.tl_slip_from_velocity(plant, motion)
        assert np.array_equal(free[:, i], inverse(plant, motion))


def test_slip_from_velocity():
    motion = ffi.new("tl_motion *", {"v": [2.0, -1.0], "slip": [9.0, 9.0]})
    lib.tl_slip_from_velocity(leg(), motion)
    assert [*motion.slip] == [1.0, -1.0]
    lib.tl_slip_from_velocity(paper(leg()), motion)  # the foot's own speed is +1
    assert [*motion.slip] == [1.0, 1.0]
    motion.v = [0.0, -0.0]
    lib.tl_slip_from_velocity(leg(), motion)
    assert [*motion.slip] == [0.0, 0.0]


def test_nan_comes_out_as_nan(plant):
    q, v, a, slip = states(1, joints=lib.tl_joint_count(plant))
    for field in ("q", "v", "a", "slip"):
        motion = motion_at(q, v, a, slip, 0)
        getattr(motion, field)[0] = math.nan
        if field != "q" or plant.plant != lib.TL_PLANT_SLIDER:
            assert math.isnan(inverse(plant, motion)[0])


REFUSED = {
    leg: [
        "shank_length_m", "shank_mass_kg", "shank_inertia_kg_m2", "foot_mass_kg", "foot_inertia_kg_m2",
        "ankle_motor_mass_kg", "drive[0].torque_constant_Nm_A", "drive[1].torque_constant_Nm_A",
        "drive[1].rotor_inertia_kg_m2", "drive[0].transmission.ratio",
    ],
    pendulum: ["inertia_kg_m2", "drive[0].torque_constant_Nm_A"],
    slider: ["mass_kg"],
}  # fmt: skip
NOT_NEGATIVE = {
    leg: [
        "gravity_m_s2", "shank_com_m", "foot_com_m", "ankle_motor_com_m", "drive[0].coulomb_Nm",
        "drive[0].viscous_Nms_rad", "drive[1].coulomb_Nm", "drive[1].viscous_Nms_rad",
    ],
    pendulum: ["gravity_moment_kg_m", "drive[0].coulomb_Nm", "drive[0].viscous_Nms_rad"],
    slider: ["drive[0].coulomb_Nm", "drive[0].viscous_Nms_rad"],
}  # fmt: skip
FINITE = {leg: [], pendulum: ["gravity_zero_rad", "torque_offset_Nm"], slider: ["force_offset_N"]}


def checked(make, place, value):
    model = make()
    where, _, field = place.rpartition(".")
    owner = model
    for part in filter(None, where.split(".")):
        owner = owner.drive[int(part[6])] if part.startswith("drive") else getattr(owner, part)
    setattr(owner, field, value)
    return lib.tl_model_check(model)


@pytest.mark.parametrize("make", [leg, pendulum, slider])
def test_model_check(make):
    for place in REFUSED[make] + NOT_NEGATIVE[make] + FINITE[make]:
        for value in (math.nan, math.inf, -math.inf):
            assert checked(make, place, value) == lib.TL_ERR_RANGE, place
    for place in REFUSED[make]:
        assert checked(make, place, 0.0) == lib.TL_ERR_RANGE, place
    for place in NOT_NEGATIVE[make]:
        assert checked(make, place, -1e-9) == lib.TL_ERR_RANGE, place
        assert checked(make, place, 0.0) == lib.TL_OK, place
    for place in FINITE[make]:
        assert checked(make, place, -1.0) == lib.TL_OK, place


def test_unknown_kinds():
    model = leg()
    model.plant = 7
    assert lib.tl_model_check(model) == lib.TL_ERR_ARGUMENT
    assert lib.tl_joint_count(model) == lib.tl_base_count(model) == 0
    assert parameters(model) == []
    assert lib.tl_forward(model, [0.0, 0.0], ffi.new("tl_motion *")) == lib.TL_ERR_ARGUMENT
    model = leg()
    model.form = 5
    assert lib.tl_model_check(model) == lib.TL_ERR_ARGUMENT
    model = leg()
    model.drive[1].transmission.kind = 9
    assert lib.tl_model_check(model) == lib.TL_ERR_ARGUMENT
    assert lib.tl_model_check(paper(pendulum())) == lib.TL_ERR_UNSUPPORTED
    assert lib.tl_model_check(ffi.NULL) == lib.TL_ERR_ARGUMENT
    assert lib.tl_model_init(model, 7) == lib.TL_ERR_ARGUMENT
    assert lib.tl_model_init(ffi.NULL, lib.TL_PLANT_LEG) == lib.TL_ERR_ARGUMENT


@pytest.mark.parametrize("plant_kind", range(3))
def test_neutral_model(plant_kind):
    model = ffi.new("tl_model *")
    check(lib.tl_model_init(model, plant_kind))
    assert model.plant == plant_kind and model.form == lib.TL_FORM_LAGRANGE
    assert model.gravity_m_s2 == 9.81 and not values(model).any()
    for j in range(2):
        assert model.drive[j].transmission.kind == lib.TL_TRANSMISSION_FIXED
        assert model.drive[j].transmission.ratio == 1.0
