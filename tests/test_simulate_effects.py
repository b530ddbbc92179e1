"""Effects in forward time: closed forms, energy, inverse dynamics, and recordings that their model must explain."""

import json
import math

import numpy as np
import pytest
import yaml
from leg_example import leg
from scipy.integrate import solve_ivp
from scoring_reference import score
from support import REPOSITORY, run
from talus import check, constants, ffi, lib
from test_simulate import energy, law, pendulum, slider, start
from test_simulate import run as advance

G = 9.81
BASE = constants.TL_MAX_JOINTS


def effects(*wanted):
    """A list of effects from (name, joint, values); the names of the parameters are left to the model file's tests."""
    made = ffi.new("tl_effect[]", len(wanted))
    for e, (name, joint, *values) in zip(made, wanted, strict=True):
        kind = lib.tl_effect_find(name.encode())
        assert kind, name
        typical = lib.tl_effect_typical(kind, joint)
        e.kind, e.joint, e.value = typical.kind, joint, list(typical.value)
        for i, value in enumerate(values):
            e.value[i] = value
    return made


def begin(m, q, v, *wanted):
    s, made = start(m, q, v), effects(*wanted)
    s.effect, s.effects = made, len(made)
    return s, made  # keep both


# ---- closed forms ---------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_block_with_stribeck_friction_breaks_loose_at_the_static_level(exponent):
    m = slider(viscous=30.0)
    ramp = law(lambda t, q, v: (50.0 * t, 0.0))
    s, keep = begin(m, 0.0, 0.0, ("stribeck", 0, 8.0, 0.05, exponent))  # 28 N, after 0.56 s
    check(lib.tl_simulate(m, ramp, ffi.NULL, 1e-3, s, 0.56 - 1e-10))
    assert s.mode[0] == lib.TL_MODE_STICK and s.motion.slip[0] == pytest.approx(1, abs=1e-9)
    check(lib.tl_simulate(m, ramp, ffi.NULL, 1e-3, s, 1.0))
    reference = solve_ivp(lambda t, x: [x[1], (50 * t - 20 - 30 * x[1] - 8 * np.exp(-((x[1] / 0.05) ** exponent))) / 95],
                          (0.56, 1.0), [0.0, 1e-15], "DOP853", rtol=1e-11, atol=1e-14)  # fmt: skip
    assert [s.motion.q[0], s.motion.v[0]] == pytest.approx(reference.y[:, -1], rel=1e-6)
    assert s.changes == 1 and keep


def test_mass_on_a_parallel_spring_swings_at_its_frequency():
    m = slider(mass=2.0, coulomb=0.0, viscous=0.0)
    s, _keep = begin(m, 0.1, 0.0, ("parallel_spring", 0, 50.0, 0.0, 0.5))
    for t in (0.3, 1.0, 4.0):
        advance(m, s, t)
        assert s.motion.q[0] == pytest.approx(-0.01 + 0.11 * math.cos(5.0 * t), abs=1e-9)


@pytest.mark.parametrize("share, turns", [(0.98, False), (1.02, True)])
def test_cogging_holds_up_to_its_barrier(share, turns):
    m = pendulum(inertia=0.001, moment=0.0, viscous=2.0)
    check(lib.tl_transmission_fixed(ffi.addressof(m.drive[0], "transmission"), 10.0))
    s, _keep = begin(m, 0.0, 0.0, ("cogging", 0, 0.05, 0.0, 0.0, 0.0, 6.0))  # 0.5 N m at the joint, 60 per turn of it
    if turns:
        # an overdamped rotor takes 2 pi / 60 viscous / sqrt(torque^2 - barrier^2) from well to well
        period = 2 * math.pi / 60 * 2.0 / (0.5 * math.sqrt(share**2 - 1))
        advance(m, s, 5 * period, (0.5 * share, 0.0))
        assert s.motion.q[0] == pytest.approx(5 * 2 * math.pi / 60, rel=0.01)
    else:
        advance(m, s, 20.0, (0.5 * share, 0.0))
        assert s.motion.q[0] == pytest.approx(math.asin(share) / 60, rel=1e-6) and abs(s.motion.v[0]) < 1e-6


def test_block_with_load_friction():
    """Speeding up the load's friction acts against inertia, slowing down it helps to slow: m (1 +- c)."""
    m, c = slider(viscous=0.0), 0.2
    s, _keep = begin(m, 0.0, 1.0, ("load_friction", 0, c))
    advance(m, s, 0.1, (60.0, 0.0))
    faster = (60.0 - 20.0) / (95 * (1 + c))
    assert s.motion.a[0] == pytest.approx(faster, rel=1e-12)
    assert s.motion.v[0] == pytest.approx(1 + 0.1 * faster, rel=1e-12)
    advance(m, s, 0.1 + (1 + 0.1 * faster) * 95 * (1 - c) / 20 - 1e-9, (0.0, 0.0))
    assert 0 < s.motion.v[0] < 1e-8 and s.motion.a[0] == pytest.approx(-20 / (95 * (1 - c)), rel=1e-9)


def test_block_whose_rotor_is_no_load():
    """Only half of its mass is carried by the gear: m (1 +- c / 2)."""
    m, c = slider(viscous=0.0), 0.2
    s, _keep = begin(m, 0.0, 1.0, ("load_friction", 0, c, 0.5))
    advance(m, s, 0.1, (60.0, 0.0))
    assert s.motion.a[0] == pytest.approx((60.0 - 20.0) / (95 * (1 + 0.5 * c)), rel=1e-9)
    advance(m, s, 0.2, (0.0, 0.0))
    assert s.motion.a[0] == pytest.approx(-20 / (95 * (1 - 0.5 * c)), rel=1e-9)


def test_block_that_carries_a_constant_force():
    m, c = slider(viscous=0.0), 0.2
    m.force_offset_N = 5.0
    s, _keep = begin(m, 0.0, 1.0, ("load_friction", 0, c, 1.0, 0.0, 1.0))
    advance(m, s, 0.1, (60.0, 0.0))  # m a = 60 - 20 - 5 - c (m a + 5)
    assert s.motion.a[0] == pytest.approx((60.0 - 20.0 - 5.0 * (1 + c)) / (95 * (1 + c)), rel=1e-9)


HANG = 1.5 * 9.81 * math.sin(0.5)  # of the pendulum at 0.5 rad


@pytest.mark.parametrize("effect, up, down", [
    (("load_friction", 0, 0.2), 0.8 + 0.2 * HANG, 0.8 + 0.2 * HANG),
    (("directional_efficiency", 0, 0.3, 0.1), 0.8 + 0.3 * HANG, 0.8 + 0.1 * HANG),
    (("asymmetric_friction", 0, 0.3, 0.0), 1.1, 0.5),
    (("position_friction", 0, 0.4, 0.8), 0.8 + 0.4 * 0.5 + 0.8 * 0.25, 0.8 + 0.4 * 0.5 + 0.8 * 0.25),
    (("stribeck", 0, 0.6), 1.4, 1.4),
])  # fmt: skip
def test_a_held_pendulum_gives_way_at_the_level_of_each_direction(effect, up, down):
    for level, sign in ((up, 1.0), (down, -1.0)):
        for share in (0.999, 1.001):
            m = pendulum(coulomb=0.8)
            s, _keep = begin(m, 0.5, 0.0, effect)
            advance(m, s, 1e-3, (HANG + sign * share * level, 0.0))
            if share < 1:
                assert s.motion.v[0] == 0 and s.motion.slip[0] == pytest.approx(sign * share, abs=1e-12)
            else:
                assert sign * s.motion.v[0] > 0


def test_friction_that_drifts_starts_where_it_is_told():
    m = slider(viscous=0.0)
    s, _keep = begin(m, 0.0, 1.0, ("friction_drift", 0, -8.0, 0.0, 0.0, 0.0, 0.0, 0.0, 10.0))
    s.effects_begin_s = 2.0
    advance(m, s, 1.5)
    assert s.motion.a[0] == pytest.approx(-20 / 95, rel=1e-12)
    advance(m, s, 3.0)
    assert s.motion.a[0] == pytest.approx(-(20 - 8 * (1 - math.exp(-0.1))) / 95, rel=1e-12)


# ---- against energy and inverse dynamics ------------------------------------------------

MIXED = [("stribeck", 0, 0.5, 0.2, 2.0), ("load_friction", 0, 0.15), ("position_friction", 0, 0.3, 0.5),
         ("asymmetric_friction", 1, 0.2, 0.1), ("directional_efficiency", 1, 0.2, 0.05), ("gravity_tilt", BASE, 0.04),
         ("nonlinear_viscous", 1, 0.2, 1.5)]  # fmt: skip


def test_the_energy_balance_closes_through_stops():
    m = leg()
    s, _keep = begin(m, [1.2, 0.4], [3.0, -9.0], *MIXED)
    before, rng = energy(m, s), np.random.default_rng(5)
    for until in np.arange(1, 201) * 0.02:
        advance(m, s, until, rng.normal(size=2) * [0.25, 0.03] - [0, 0.02 * s.motion.q[1]], step=2e-4)
        assert energy(m, s) + s.dissipated_J - s.work_J == pytest.approx(before, abs=2e-7)
    assert s.changes > 30 and s.work_J > 1


def test_joints_at_rest_and_in_motion_obey_the_law_that_prediction_uses():
    """The torque that the motion needs, by inverse dynamics and the effects' sum along it, is the torque that acts."""
    m, rng, seen = leg(), np.random.default_rng(11), set()
    made = effects(*MIXED)
    for _ in range(1000):
        q, v = rng.uniform(-0.5, 0.5, 2), rng.normal(size=2) * rng.integers(0, 2, 2) * 2
        torque = rng.normal(size=2) * [0.12, 0.03]
        s = start(m, q, v)
        s.effect, s.effects = made, len(made)
        advance(m, s, 0.0, torque)
        needed = ffi.new("double[2]")
        at = ffi.new("tl_motion *", s.motion)
        slides = [j for j in (0, 1) if s.mode[j] != lib.TL_MODE_STICK]
        for j in (0, 1):
            if j not in slides:
                assert s.motion.a[j] == 0 and abs(s.motion.slip[j]) <= 1 + 1e-9
            elif v[j] == 0:
                assert s.mode[j] * s.motion.a[j] > 0
        lib.tl_inverse(m, at, needed)
        for j in slides:
            total = needed[j] + lib.tl_effects_torque(made, len(made), m, at, j, 0.0, 0.0, ffi.NULL)
            assert total == pytest.approx(torque[j], abs=1e-12)
        seen.add((s.mode[0], s.mode[1]))
    assert seen == {(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)}


def test_an_effect_without_strength_changes_nothing():
    m = leg()
    plain = advance(m, start(m, [1.2, 0.4], [3.0, -9.0]), 1.0, (0.1, 0.01))
    s, _keep = begin(m, [1.2, 0.4], [3.0, -9.0], ("stribeck", 1, 0.0), ("load_friction", 0, 0.0))
    advance(m, s, 1.0, (0.1, 0.01))
    assert list(s.motion.q) == pytest.approx(list(plain.motion.q), abs=1e-11) and s.changes == plain.changes


def test_friction_that_outgrows_the_load_jams_and_says_so():
    m = slider(viscous=0.0)
    s, _keep = begin(m, 0.0, 1.0, ("load_friction", 0, 0.6), ("directional_efficiency", 0, 0.1, 0.6))
    done = lib.tl_simulate(m, lib.tl_held_torque, ffi.new("double[2]", [0.0, 0.0]), 1e-3, s, 1.0)
    assert done == lib.TL_ERR_NO_CONVERGENCE and s.t_s == 0


# ---- talus-sim against talus-predict ------------------------------------------------------

MODEL = {plant: REPOSITORY / "models" / f"{plant}.yaml" for plant in ("leg", "pendulum", "slider")}
CASES = [
    ("stribeck", "knee", {"extra_Nm": 0.6, "speed_rad_s": 0.1, "exponent": 1.0}),
    ("stribeck", "ankle", {"extra_Nm": 0.4, "speed_rad_s": 0.1, "exponent": 2.0}),
    ("load_friction", "knee", {"coefficient": 0.2}),
    ("load_friction", "ankle", {"coefficient": 0.2}),
    ("asymmetric_friction", "ankle", {"coulomb_Nm": 0.2, "viscous_Nms_rad": 0.1}),
    ("nonlinear_viscous", "knee", {"size_Nm": 0.3, "exponent": 0.5}),
    ("position_friction", "ankle", {"slope_Nm_rad": 0.5, "bend_Nm_rad2": 1.0}),
    ("friction_drift", "knee", {"coulomb_Nm": -0.3, "viscous_Nms_rad": -0.1, "time_constant_s": 20.0}),
    ("directional_efficiency", "knee", {"driving": 0.15, "back_driving": 0.05}),
    ("kinematic_error", "knee", {"sine_Nm": 0.3, "cosine_Nm": 0.1, "per_turn": 2.0}),
    ("cogging", "knee", {"sine_Nm": 0.01, "cosine_Nm": 0.0, "per_turn": 6.0}),
    ("torque_saturation", "knee", {"droop_1_Nm": 0.5, "exponent": 1.0}),
    ("current_offset", "ankle", {"torque_Nm": 0.002}),
    ("gravity_tilt", "base", {"tilt_rad": 0.05}),
    ("parallel_spring", "ankle", {"stiffness_Nm_rad": 3.0, "stiffening_Nm_rad3": 1.0, "preload_Nm": 0.2}),
    ("delay", "knee", {"delay_s": 0.004}),
    ("delay", "ankle", {"delay_s": -0.003}),
    ("linkage_error", "ankle", {"AB_m": 0.0, "BO_m": 0.0015, "AC_m": 0.0}),
    ("presliding", "ankle", {"friction_Nm": 0.6, "travel_rad": 0.005}),
    ("encoder_eccentricity", "ankle",
     {"motor_sine_rad": 0.02, "motor_cosine_rad": 0.0, "joint_sine_rad": 0.0, "joint_cosine_rad": 0.0}),
]  # fmt: skip


def model_with(path, plant, *wanted):
    tree = yaml.safe_load(MODEL[plant].read_text())
    tree["effects"] = [{"effect": e, "joint": j, "parameters": p} for e, j, p in wanted]
    path.write_text(yaml.safe_dump(tree))
    return path


def rows(path):
    return np.genfromtxt(path, delimiter=",", names=True)


def simulate(folder, model, *options):
    run("talus-sim", "--ideal", "--model", model, "--out", folder / "r.csv", "--motion", folder / "m.csv",
        "--truth", folder / "t.json", *options)  # fmt: skip
    return rows(folder / "r.csv"), rows(folder / "m.csv")


def residuals(folder, model, recording, motion):
    """Scored residual of talus-predict with this model, for knee and ankle."""
    run("talus-predict", "--model", model, "--out", folder / "p.csv", folder / "r.csv")
    predicted = rows(folder / "p.csv")
    return [score(recording["time_s"], 0.1031 * recording[f"{joint}_current_A"], predicted[f"{joint}_motor_torque_Nm"],
                  np.abs(motion[f"{joint}_velocity_rad_s"]))[0] for joint in ("knee", "ankle")]  # fmt: skip


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plain")
    return residuals(folder, MODEL["leg"], *simulate(folder, MODEL["leg"], "--excitation", "ramps"))


@pytest.mark.parametrize("effect, joint, parameters", CASES, ids=[f"{e}-{j}" for e, j, _ in CASES])
def test_the_model_that_was_simulated_explains_the_recording_and_the_plain_one_does_not(
    effect, joint, parameters, plain, tmp_path
):
    model = model_with(tmp_path / "e.yaml", "leg", (effect, joint, parameters))
    recording, motion = simulate(tmp_path, model, "--excitation", "ramps")
    told = json.loads((tmp_path / "t.json").read_text())["effects"]
    assert told == [{"effect": effect, "joint": joint, "parameters": parameters}]
    explained, unexplained = (residuals(tmp_path, m, recording, motion) for m in (model, MODEL["leg"]))
    at = ("knee", "ankle").index(joint) if joint != "base" else 0
    # friction that falls with speed makes the ankle jump out of rest, faster than the samples show
    bar = 2.0 if (effect, joint) == ("stribeck", "ankle") else 1.25
    assert explained[at] < bar * plain[at] and unexplained[at] > 5 * plain[at]
    assert explained[1 - at] < 1.1 * plain[1 - at]


def test_effects_together(plain, tmp_path):
    model = model_with(tmp_path / "e.yaml", "leg", *[CASES[k] for k in (1, 2, 6, 11, 13)])
    recording, motion = simulate(tmp_path, model, "--excitation", "ramps")
    explained, unexplained = (residuals(tmp_path, m, recording, motion) for m in (model, MODEL["leg"]))
    assert all(e < 2.0 * p < 0.05 * u for e, p, u in zip(explained, plain, unexplained, strict=True))


def test_the_current_shows_measured_effects_and_the_motion_does_not(tmp_path):
    """Offset and droop on top of the torque that acts: K i = torque + offset + droop torque |torque|."""
    motion = [simulate(tmp_path, MODEL["leg"], "--duration", 5)[1]]
    model = model_with(tmp_path / "e.yaml", "leg", ("current_offset", "knee", {"torque_Nm": 0.01}),
                       ("torque_saturation", "knee", {"droop_1_Nm": 0.5, "exponent": 1.0}))  # fmt: skip
    recording, now = simulate(tmp_path, model, "--duration", 5)
    assert np.array_equal(motion[0]["knee_position_rad"], now["knee_position_rad"])
    torque = now["knee_torque_Nm"]
    shown = torque + 0.01 + 0.5 * torque * np.abs(torque)
    assert 0.1031 * recording["knee_current_A"] == pytest.approx(shown, abs=1e-11)
    assert 0.1031 * recording["ankle_current_A"] == pytest.approx(now["ankle_torque_Nm"], abs=1e-12)


@pytest.mark.parametrize("plant, joint, gain", [("pendulum", "joint", 0.091 * 9), ("slider", "slider", 1.0)])
def test_other_plants_take_effects(plant, joint, gain, tmp_path):
    size = {"pendulum": 0.1, "slider": 8.0}[plant]
    wanted = [("load_friction", joint, {"coefficient": 0.15}), ("current_offset", joint, {"torque_Nm": 0.05}),
              ("stribeck", joint, {"extra_Nm": size, "speed_rad_s": 0.1, "exponent": 2.0})]  # fmt: skip
    model = model_with(tmp_path / "e.yaml", plant, *wanted)
    recording, motion = simulate(tmp_path, model, "--duration", 10)
    shown = gain * recording["joint_current_A" if plant == "pendulum" else "slider_force_N"]
    found = []
    for m in (model, MODEL[plant]):
        run("talus-predict", "--model", m, "--out", tmp_path / "p.csv", tmp_path / "r.csv")
        predicted = rows(tmp_path / "p.csv")["joint_torque_Nm" if plant == "pendulum" else "slider_force_N"]
        speed = np.abs(motion[f"{joint}_velocity_rad_s" if plant == "pendulum" else "slider_velocity_m_s"])
        found.append(score(recording["time_s"], shown, predicted, speed)[2])
    assert found[0] < 0.5 and found[1] > 10 * found[0]


# ---- sensors ----------------------------------------------------------------------------

ANKLE = {"AB_m": 0.090, "BO_m": 0.040, "AC_m": 0.035}


def ankle_motor(q, **change):
    """The motor's angle of the leg's linkage with dimensions changed, by the closed form of docs/equations.md."""
    size = {k: v + change.get(k, 0.0) for k, v in ANKLE.items()}

    def nut(x):
        phi = math.pi - math.radians(84.75) - x
        return size["BO_m"] * np.cos(phi) + np.sqrt(size["AB_m"] ** 2 - (size["AC_m"] - size["BO_m"] * np.sin(phi)) ** 2)

    return 2 * math.pi / 0.002 * (nut(q) - nut(0.0))


@pytest.mark.parametrize("samples", [1, -1, 3])
def test_a_delayed_current_is_that_of_an_earlier_sample(samples, tmp_path):
    plain, _ = simulate(tmp_path, MODEL["leg"], "--duration", 4)
    model = model_with(tmp_path / "e.yaml", "leg", ("delay", "ankle", {"delay_s": 0.004 * samples}))
    late, _ = simulate(tmp_path, model, "--duration", 4)
    assert late["ankle_motor_rad"] == pytest.approx(plain["ankle_motor_rad"], abs=1e-8)
    assert late["knee_current_A"] == pytest.approx(plain["knee_current_A"], abs=1e-8)
    now, then = late["ankle_current_A"], np.roll(plain["ankle_current_A"], samples)
    assert now[3:-3] == pytest.approx(then[3:-3], abs=1e-8)


def test_encoders_off_their_axis(tmp_path):
    parameters = {"motor_sine_rad": 0.02, "motor_cosine_rad": -0.01, "joint_sine_rad": 0.004, "joint_cosine_rad": 0.003}
    model = model_with(tmp_path / "e.yaml", "leg", ("encoder_eccentricity", "ankle", parameters))
    recording, motion = simulate(tmp_path, model, "--duration", 4)
    q = motion["ankle_position_rad"]
    assert recording["ankle_joint_rad"] == pytest.approx(q + 0.004 * np.sin(q) + 0.003 * np.cos(q), abs=1e-11)
    motor = ankle_motor(q)
    motor *= np.sign(motor @ recording["ankle_motor_rad"])
    shown = motor + 0.02 * np.sin(motor) - 0.01 * np.cos(motor)
    assert recording["ankle_motor_rad"] == pytest.approx(shown, abs=1e-9)


def test_a_linkage_built_otherwise(tmp_path):
    change = {"AB_m": 0.001, "BO_m": 0.002, "AC_m": -0.0015}
    model = model_with(tmp_path / "e.yaml", "leg", ("linkage_error", "ankle", change))
    recording, motion = simulate(tmp_path, model, "--duration", 4)
    motor = ankle_motor(motion["ankle_position_rad"], **change)
    motor *= np.sign(motor @ recording["ankle_motor_rad"])
    assert recording["ankle_motor_rad"] == pytest.approx(motor, abs=1e-9)
    assert recording["ankle_joint_rad"] == pytest.approx(motion["ankle_position_rad"], abs=1e-11)


def test_a_linkage_that_cannot_close_is_refused(tmp_path):
    tree = yaml.safe_load(MODEL["leg"].read_text())
    tree["ankle"]["transmission"]["AB_m"] = 0.012  # closes, but not 10 mm shorter
    change = {"AB_m": -0.01, "BO_m": 0.0, "AC_m": 0.0}
    tree["effects"] = [{"effect": "linkage_error", "joint": "ankle", "parameters": change}]
    (tmp_path / "e.yaml").write_text(yaml.safe_dump(tree))
    done = run("talus-sim", "--model", tmp_path / "e.yaml", "--out", tmp_path / "r.csv", status=2)
    assert "e.yaml:" in done.stderr and "linkage_error" in done.stderr and len(done.stderr.splitlines()) == 1


# ---- memory and further bodies ---------------------------------------------------------------


@pytest.mark.parametrize("share", [0.3, 0.9, -0.6])
def test_presliding_friction_is_a_spring_below_its_level(share):
    """Dahl: F = level z, z' = v (1 - z sgn v) / travel, so a force creeps to travel ln 1 / (1 - F / level)."""
    m = slider(mass=1.0, viscous=200.0)
    s, _keep = begin(m, 0.0, 0.0, ("presliding", 0, 20.0, 0.01))
    advance(m, s, 20.0, (20.0 * share, 0.0))
    assert s.motion.q[0] == pytest.approx(-0.01 * math.copysign(1, share) * math.log1p(-abs(share)), rel=1e-6)
    assert s.link.z[0] == pytest.approx(share, rel=1e-6)


def test_presliding_friction_slides_at_its_level():
    m = slider(mass=2.0, viscous=0.0)
    s, _keep = begin(m, 0.0, 0.0, ("presliding", 0, 20.0, 0.005))
    advance(m, s, 2.0, (26.0, 0.0))
    assert s.motion.a[0] == pytest.approx(3.0, rel=1e-6) and s.link.z[0] == pytest.approx(1.0, abs=1e-6)


def rotor(inertia=1.0):
    return pendulum(inertia=inertia, moment=0.0)


def test_a_twisting_transmission_swings_as_two_bodies_do():
    """Torque on the motor's side, 0.4 of the inertia: the twist is torque / (I1 w^2) (1 - cos w t)."""
    m, motor, link = rotor(), 0.4, 0.6
    s, _keep = begin(m, 0.0, 0.0, ("elasticity", 0, 1.0, 0.0, 0.0, 200.0, 0.0))
    w = math.sqrt(200.0 * (1 / motor + 1 / link))
    for t in (0.05, 0.3, 1.0):
        advance(m, s, t, (0.5, 0.0))
        twist = 0.5 / (motor * w * w) * (1 - math.cos(w * t))
        assert s.motion.q[0] - s.link.q[0] == pytest.approx(twist, abs=2e-7)
        assert motor * s.motion.v[0] + link * s.link.v[0] == pytest.approx(0.5 * t, rel=1e-9)


@pytest.mark.parametrize("effect, free", [(("elasticity", 0, 1.0, 0.0, 0.0, 400.0, 0.01), 0.0),
                                          (("backlash", 0, 1.0, 0.02, 400.0), 0.01)])  # fmt: skip
@pytest.mark.parametrize("side", [1, -1])
def test_a_hanging_load_twists_its_transmission(effect, free, side):
    m = pendulum(coulomb=30.0)  # the motor's side sticks, the arm beyond it settles
    s, _keep = begin(m, 0.5 * side, 0.0, effect)
    advance(m, s, 60.0)
    link = s.link.q[0]
    assert s.motion.q[0] == 0.5 * side and abs(s.link.v[0]) < 1e-4
    twist = free * side + 1.5 * G * math.sin(link) / 400.0
    assert s.motion.q[0] - link == pytest.approx(twist, abs=2e-6)
    joints = ffi.new("tl_motion *")
    lib.tl_simulation_joints(m, s, joints)
    assert joints.q[0] == link


@pytest.mark.parametrize("effect, joint, parameters", [
    ("elasticity", "ankle", {"share": 1.0, "stiffness_Nm_rad": 300.0, "damping_s": 0.001}),
    ("backlash", "ankle", {"share": 1.0, "gap_rad": 0.006, "stiffness_Nm_rad": 3000.0}),
])  # fmt: skip
def test_the_two_encoders_of_the_ankle_tell(effect, joint, parameters, tmp_path):
    """Joint less motor through the linkage is minus the foot's load over the stiffness, or half the gap to its other side."""
    model = model_with(tmp_path / "e.yaml", "leg", (effect, joint, parameters))
    recording, motion = simulate(tmp_path, model, "--excitation", "ramps")
    plain = leg()  # owns the memory that the transmission lies in
    address = ffi.new("tl_transmission *", plain.drive[1].transmission)
    motor = np.array([lib.tl_transmission_joint_angle(address, x) for x in recording["ankle_motor_rad"]])
    difference = recording["ankle_joint_rad"] - motor
    foot, ankle = motion["knee_position_rad"] + motion["ankle_position_rad"], motion["ankle_position_rad"]
    load = 0.442 * 0.055 * G * np.sin(foot)
    turning = motion["knee_acceleration_rad_s2"] + motion["ankle_acceleration_rad_s2"]
    moving = (0.0021 + 0.442 * 0.055**2) * turning + 0.442 * 0.3615 * 0.055 * (
        np.cos(ankle) * motion["knee_acceleration_rad_s2"] + np.sin(ankle) * motion["knee_velocity_rad_s"] ** 2)  # fmt: skip
    slow = np.abs(motion["knee_velocity_rad_s"]) + np.abs(motion["ankle_velocity_rad_s"]) < 0.1
    if effect == "elasticity":
        load += moving
        assert (difference @ load) / (load @ load) == pytest.approx(-1 / 300.0, rel=0.005)
        assert np.corrcoef(difference, load)[0, 1] < -0.99
    else:
        loaded = slow & (np.abs(load) > 0.05)
        assert np.median(difference[loaded] * np.sign(load[loaded])) == pytest.approx(-0.003, abs=1e-4)


@pytest.mark.parametrize("hz, ratio", [(6.0, 0.05), (9.0, 0.02)])
def test_a_mount_rings_at_its_frequency_with_the_leg_at_rest(hz, ratio):
    m, compliance = leg(), 5e-4
    for drive in m.drive:
        drive.coulomb_Nm = 1e3  # both joints stick
    s, _keep = begin(m, [0.0, 0.0], [0.0, 0.0], ("base_compliance", BASE, compliance, 0.0, 0.0, hz, ratio))
    s.link.begun, s.link.q[BASE] = 1, 1e-3
    t, x = np.arange(1, 2001) * 5e-4, []
    for until in t:
        advance(m, s, until)
        x.append(s.link.q[BASE])
    gravity = 9.81 * (1.624 * 0.160 + 0.4112 * 0.120 + 0.442 * (0.3615 + 0.055))
    w = 2 * math.pi * hz * math.sqrt(1 + gravity * compliance)
    # the damping's own rate does not change with gravity's spring
    decay = ratio * 2 * math.pi * hz
    swing = math.sqrt(w**2 - decay**2)
    expected = 1e-3 * np.exp(-decay * t) * (np.cos(swing * t) + decay / swing * np.sin(swing * t))
    assert np.array(x) == pytest.approx(expected, abs=2e-6)


# of one mount: compliance that turns, sways and rises, frequency
MODES = [
    [(5e-4, 0.0, 0.0, 6.0), (3e-4, 0.0, 0.0, 9.0)],
    [(0.0, 2e-5, 0.0, 6.0), (0.0, 1e-5, 0.0, 9.0)],
    [(0.0, 0.0, 2e-5, 6.0), (0.0, 0.0, 2e-5, 7.0)],
    [(5e-4, 0.0, 0.0, 7.0), (0.0, 2e-5, 0.0, 7.0)],
    [(0.0, 2e-5, 0.0, 7.0), (5e-4, 0.0, 0.0, 7.0), (0.0, 0.0, 1e-5, 8.0), (2e-4, 0.0, 0.0, 11.0)],
]


@pytest.mark.parametrize("modes", MODES)
def test_the_modes_of_one_mount_ring_side_by_side(modes):
    """With the leg at rest, each at its own frequency, whatever the others do."""
    m, ratio = leg(), 0.03
    m.gravity_m_s2 = 0.0
    for drive in m.drive:
        drive.coulomb_Nm = 1e4  # both joints stick
    s, _keep = begin(m, [0.0, 0.0], [0.0, 0.0], *[("base_compliance", BASE, *mode, ratio) for mode in modes])
    s.link.begun = 1
    for k in range(len(modes)):
        s.link.q[BASE + k] = 1e-6 * (k + 1)
    t, x = np.arange(1, 1001) * 1e-3, []
    for until in t:
        advance(m, s, until)
        x.append(list(s.link.q)[BASE:BASE + len(modes)])
    for k, w in enumerate(2 * math.pi * mode[3] for mode in modes):
        decay, swing = ratio * w, w * math.sqrt(1 - ratio**2)
        expected = 1e-6 * (k + 1) * np.exp(-decay * t) * (np.cos(swing * t) + decay / swing * np.sin(swing * t))
        assert np.array(x)[:, k] == pytest.approx(expected, abs=2e-11)


def mount_energy(m, s, modes):
    """Of leg and mount: the leg on a base that turns and moves, and the inertia and springs of the modes beside it."""
    x, v = (np.array(list(of))[BASE:BASE + len(modes)] for of in (s.link.q, s.link.v))
    sort = [next(k for k in range(3) if mode[k] > 0.0) for mode in modes]
    compliance = np.array([mode[k] for mode, k in zip(modes, sort, strict=True)])
    inertia = np.diag(1.0 / (compliance * (2 * math.pi * np.array([mode[3] for mode in modes])) ** 2))
    shank = m.shank_mass_kg * m.shank_com_m + m.ankle_motor_mass_kg * m.ankle_motor_com_m + m.foot_mass_kg * m.shank_length_m
    foot, whole = m.foot_mass_kg * m.foot_com_m, ffi.new("double[4]")
    lib.tl_inertia_matrix(m, [0.0, 0.0], whole)
    hanging = (whole[0], shank + foot, 0.0)  # coupling of each sort with what turns, at rest
    for i, j in np.ndindex(inertia.shape):
        if i != j and 0 in (sort[i], sort[j]):
            inertia[i, j] -= hanging[sort[i] or sort[j]]
        elif i == j and sort[i] == 0:
            inertia[i, i] -= hanging[0]
    turned = ffi.new("tl_motion *", s.motion)
    turned.q[0] += sum(x[k] for k in range(len(modes)) if sort[k] == 0)
    turned.v[0] += sum(v[k] for k in range(len(modes)) if sort[k] == 0)
    kinetic, potential = ffi.new("double *"), ffi.new("double *")
    lib.tl_energy(m, turned, kinetic, potential)
    absolute, rate = np.cumsum(list(turned.q)), np.cumsum(list(turned.v))
    front = sum(mass * np.cos(a) * w for mass, a, w in zip((shank, foot), absolute, rate, strict=True))
    up = sum(mass * np.sin(a) * w for mass, a, w in zip((shank, foot), absolute, rate, strict=True))
    moved = sum(v[k] * (front, up)[sort[k] - 1] for k in range(len(modes)) if sort[k] > 0)
    return kinetic[0] + potential[0] + moved + 0.5 * v @ inertia @ v + 0.5 * np.sum(x**2 / compliance)


def test_modes_that_turn_sway_and_rise_keep_the_energy():
    m, modes = leg(), MODES[-1]
    for drive in m.drive:
        drive.coulomb_Nm = drive.viscous_Nms_rad = 0.0
    s, _keep = begin(m, [0.9, 0.2], [0.5, -3.0], *[("base_compliance", BASE, *mode, 0.0) for mode in modes])
    advance(m, s, 0.01)
    begun = mount_energy(m, s, modes)
    for until in np.arange(0.02, 1.0, 0.01):
        advance(m, s, until)
        assert mount_energy(m, s, modes) == pytest.approx(begun, abs=1e-6)


@pytest.mark.parametrize("modes", [
    [{"compliance_rad_Nm": 0.01, "frequency_Hz": 15.0}],
    [{"compliance_rad_Nm": 0.001, "frequency_Hz": 9.0}] * 2,  # each alone could
    [{"compliance_rad_Nm": 0.0, "sway_m_N": 1e-6, "frequency_Hz": 9.0}] * 5,
])  # fmt: skip
def test_a_mount_that_cannot_ring_there_is_refused(tmp_path, modes):
    model = model_with(tmp_path / "e.yaml", "leg", *[("base_compliance", "base", {**mode, "damping_ratio": 0.05}) for mode in modes])
    done = run("talus-sim", "--model", model, "--out", tmp_path / "r.csv", status=2)
    assert len(done.stderr.splitlines()) == 1


BODIES = [
    ("elasticity", "knee", {"share": 1.0, "stiffness_Nm_rad": 500.0, "damping_s": 0.002}, 0.2),
    ("elasticity", "knee", {"share": 1.0, "stiffness_Nm_rad": 2000.0, "damping_s": 0.001}, 0.2),
    ("backlash", "knee", {"share": 1.0, "gap_rad": 0.005, "stiffness_Nm_rad": 3000.0}, 0.4),
    ("base_compliance", "base", {"compliance_rad_Nm": 0.001, "frequency_Hz": 8.0, "damping_ratio": 0.05}, 0.4),
]


@pytest.mark.parametrize("effect, joint, parameters, bar", BODIES)
def test_first_order_prediction_takes_most_of_a_further_bodys_gap(effect, joint, parameters, bar, tmp_path):
    model = model_with(tmp_path / "e.yaml", "leg", (effect, joint, parameters))
    recording, motion = simulate(tmp_path, model, "--duration", 20, "--camera")
    explained, unexplained = (residuals(tmp_path, m, recording, motion)[0] for m in (model, MODEL["leg"]))
    assert explained < bar * unexplained
    if joint == "base":  # the camera sees the sway
        assert np.std(recording["shank_rad"] - recording["knee_motor_rad"] / 51) > 1e-4


# ---- a constant torque on either side of a gap -----------------------------------------------


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_a_constant_torque_moves_the_side_of_a_gap_that_it_acts_on(share):
    """Within the gap motor and link move by themselves, and its work is their energy."""
    m, motor, link, t = pendulum(inertia=0.5, moment=0.0), 0.2, 0.3, 0.1
    m.torque_offset_Nm = 0.4
    s, _keep = begin(m, 0.0, 0.0, ("backlash", 0, 1.0, 0.1, 3000.0, 0.0, 0.0, 0.0, 0.4, 0.0, share))
    advance(m, s, t)
    assert [s.motion.v[0], s.link.v[0]] == pytest.approx([-(1 - share) * 0.4 * t / motor, -share * 0.4 * t / link], rel=1e-9)
    assert s.work_J == pytest.approx(0.5 * (motor * s.motion.v[0] ** 2 + link * s.link.v[0] ** 2), rel=1e-6)


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_prediction_holds_the_link_to_the_face_that_a_constant_force_presses_it_to(share, tmp_path):
    play = {"share": 1.0, "gap_rad": 0.001, "stiffness_Nm_rad": 4e5, "damping_s": 0.01, "friction_share": 0.3, "motor_share": 0.4}
    tree = yaml.safe_load(MODEL["slider"].read_text()) | {"force_offset_N": 12.0}
    models = {}
    for side in (share, 1.0 - share):
        tree["effects"] = [{"effect": "backlash", "joint": "slider", "parameters": {**play, "offset_share": side}}]
        models[side] = tmp_path / f"{side}.yaml"
        models[side].write_text(yaml.safe_dump(tree))
    recording, motion = simulate(tmp_path, models[share], "--duration", 10, "--rate", 1000)
    off = {}
    for side, model in models.items():
        run("talus-predict", "--model", model, "--out", tmp_path / "p.csv", tmp_path / "r.csv")
        predicted, speed = rows(tmp_path / "p.csv")["slider_force_N"], np.abs(motion["slider_velocity_m_s"])
        off[side] = score(recording["time_s"], recording["slider_force_N"], predicted, speed)[2]
    assert off[share] < 0.2 * off[1.0 - share]


# ---- drag between motor and link ----------------------------------------------------------


def dragging(inertia, drag, coulomb=0.0, friction_share=0.0):
    """A joint without gravity, from rest, whose teeth do not meet; its simulation and what that must keep."""
    m = pendulum(inertia=inertia, moment=0.0, coulomb=coulomb)
    s, keep = begin(m, 0.0, 0.0, ("backlash", 0, 1.0, 0.1, 3000.0, 0.0, friction_share, 0.0, 0.4, drag))
    return m, s, keep


@pytest.mark.parametrize("torque", [0.5, -2.0])
def test_drag_takes_the_link_along_up_to_its_level(torque):
    inertia, drag, t = 0.5, 0.6, 0.1
    m, s, _keep = dragging(inertia, drag)
    advance(m, s, t, (torque, 0.0))
    motor, link = 0.4 * inertia, 0.6 * inertia
    together = abs(torque) / inertia * link <= drag  # 0.3 and 1.2 N m
    of_motor = torque / inertia if together else (torque - math.copysign(drag, torque)) / motor
    of_link = torque / inertia if together else math.copysign(drag, torque) / link
    assert [s.motion.v[0], s.link.v[0]] == pytest.approx([of_motor * t, of_link * t], rel=1e-9)
    assert (s.motion.v[0] == s.link.v[0]) == together and s.dissipated_J == pytest.approx(
        drag * abs(s.motion.q[0] - s.link.q[0]), rel=1e-9)  # fmt: skip
    # without a torque the motor slows down to the link's speed, and both go on together
    both = motor * s.motion.v[0] + link * s.link.v[0]
    advance(m, s, t + 0.3)
    assert s.motion.v[0] == s.link.v[0] == pytest.approx(both / inertia, rel=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_motor_and_link_rest_while_their_frictions_and_drag_hold(share):
    """Of 0.8 N m at rest: what the motor's friction leaves of the torque, drag hands on to the link's."""
    inertia, coulomb, drag = 0.5, 0.8, 0.3
    holds = (1.0 - share) * coulomb + min(share * coulomb, drag)
    for torque in (0.99 * holds, -0.99 * holds, 1.01 * holds):
        m, s, _keep = dragging(inertia, drag, coulomb, share)
        advance(m, s, 0.02, (torque, 0.0))
        assert (s.motion.v[0] == 0.0) == (abs(torque) < holds)
        if abs(torque) < holds:
            assert s.link.v[0] == 0.0 and abs(s.link.drag_slip[0]) <= 1 + 1e-9


def test_drag_keeps_the_energy_through_sticking_and_slipping():
    m, s, _keep = dragging(0.5, 0.3, 0.4, 0.5)
    for until in np.arange(1, 401) * 0.005:
        advance(m, s, until, (1.5 * math.sin(23 * until) + 0.6 * math.sin(61 * until), 0.0))
        kinetic = 0.5 * (0.2 * s.motion.v[0] ** 2 + 0.3 * s.link.v[0] ** 2)
        twist = max(abs(s.motion.q[0] - s.link.q[0]) - 0.05, 0.0)
        assert kinetic + 1500.0 * twist**2 + s.dissipated_J - s.work_J == pytest.approx(0.0, abs=1e-6)
    assert s.changes > 40


# ---- refusals ---------------------------------------------------------------------------


def test_what_only_a_sensor_at_the_output_shows_is_refused(tmp_path):
    model = model_with(tmp_path / "e.yaml", "pendulum", ("torque_constant", "joint", {"excess": 0.1}))
    done = run("talus-sim", "--model", model, "--out", tmp_path / "r.csv", status=2)
    assert "e.yaml: effects: 'torque_constant'" in done.stderr and not (tmp_path / "r.csv").exists()


def test_the_papers_form_takes_no_effects(tmp_path):
    tree = yaml.safe_load(MODEL["leg"].read_text())
    tree["form"] = "paper"
    tree["effects"] = [{"effect": "gravity_tilt", "joint": "base", "parameters": {"tilt_rad": 0.01}}]
    (tmp_path / "e.yaml").write_text(yaml.safe_dump(tree))
    done = run("talus-sim", "--model", tmp_path / "e.yaml", "--out", tmp_path / "r.csv", status=2)
    assert "form: paper" in done.stderr
