"""talus/experimental/simulate.h against motions known in closed form, energy, and an event-located reference."""

import math

import numpy as np
import pytest
from leg_example import EXAMPLE, EXAMPLE_DRIVES, EXAMPLE_LINKAGE, fixed, leg
from scipy.integrate import solve_ivp
from scipy.special import ellipk
from talus import check, ffi, lib

HELD = lib.tl_held_torque
G = 9.81


def slider(mass=95.0, coulomb=20.0, viscous=200.0, offset=0.0):
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_SLIDER))
    m.mass_kg, m.force_offset_N = mass, offset
    m.drive[0].coulomb_Nm, m.drive[0].viscous_Nms_rad = coulomb, viscous
    return m


def pendulum(inertia=0.4, moment=1.5, coulomb=0.0, viscous=0.0, offset=0.0):
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_PENDULUM))
    m.inertia_kg_m2, m.gravity_moment_kg_m, m.torque_offset_Nm = inertia, moment, offset
    m.drive[0].coulomb_Nm, m.drive[0].viscous_Nms_rad, m.drive[0].torque_constant_Nm_A = coulomb, viscous, 0.1
    return m


def start(m, q, v):
    s = ffi.new("tl_simulation *")
    check(lib.tl_simulation_init(s, m, [*np.atleast_1d(q)], [*np.atleast_1d(v)]))
    return s


def run(m, s, until, torque=(0.0, 0.0), step=1e-3):
    check(lib.tl_simulate(m, HELD, ffi.new("double[2]", [*torque]), step, s, until))
    return s


def law(function):
    """A torque law from a Python function of (t, q, v) that gives the torques; keep what it returns."""

    @ffi.callback("void(*)(const void *, double, const tl_motion *, double *)")
    def call(_, t, motion, torque):
        for j, value in enumerate(function(t, list(motion.q), list(motion.v))):
            torque[j] = value

    return call


def energy(m, s):
    kinetic, potential = ffi.new("double *"), ffi.new("double *")
    lib.tl_energy(m, ffi.addressof(s.motion), kinetic, potential)
    return kinetic[0] + potential[0]


# ---- one joint: closed forms --------------------------------------------------------


def test_block_under_constant_force():
    m = slider(offset=1.5)
    s = start(m, 0.2, 0.05)
    # 95 v' = 300 - 1.5 - 20 - 200 v
    end, rate = (300 - 1.5 - 20) / 200, 200 / 95
    for t in (0.0004, 0.3, 1.7):
        run(m, s, t, (300.0, 0.0))
        gone = math.exp(-rate * t)
        assert s.motion.v[0] == pytest.approx(end + (0.05 - end) * gone, rel=1e-11)
        assert s.motion.q[0] == pytest.approx(0.2 + end * t + (0.05 - end) * (1 - gone) / rate, rel=1e-11)
        assert s.motion.a[0] == pytest.approx((0.05 - end) * -rate * gone, rel=1e-10)
        assert s.motion.slip[0] == 1 and s.t_s == t and s.changes == 0


@pytest.mark.parametrize("direction", [1, -1])
def test_block_comes_to_rest_when_it_must(direction):
    m = slider()
    mass, c, b, v0 = 95.0, 20.0, 200.0, 0.4 * direction
    stop = mass / b * math.log1p(b * abs(v0) / c)
    way = direction * mass / b * (abs(v0) - c / b * math.log1p(b * abs(v0) / c))
    s = run(m, start(m, 0.0, v0), stop - 1e-10, step=2e-4)
    assert 0 < direction * s.motion.v[0] < 1e-10
    run(m, s, stop + 1e-10, step=2e-4)
    assert s.motion.v[0] == 0 and s.motion.a[0] == 0 and s.changes == 1
    assert s.motion.q[0] == pytest.approx(way, rel=1e-11)
    q = s.motion.q[0]
    run(m, s, 10.0)
    assert s.motion.q[0] == q and s.motion.slip[0] == 0


@pytest.mark.parametrize("share", [0.0, 0.5, -0.999999, 1.0, -1.0])
def test_block_sticks_below_the_coulomb_level(share):
    m = slider(offset=3.0)
    s = run(m, start(m, 0.7, 0.0), 5.0, (3.0 + 20.0 * share, 0.0))
    assert s.motion.q[0] == 0.7 and s.motion.v[0] == 0 and s.motion.a[0] == 0
    assert s.motion.slip[0] == pytest.approx(share, abs=1e-15) and s.mode[0] == lib.TL_MODE_STICK
    assert s.dissipated_J == 0 and s.work_J == 0


def test_block_breaks_loose_at_the_coulomb_level():
    m = slider(viscous=0.0)
    ramp = law(lambda t, q, v: (50.0 * t, 0.0))  # reaches 20 N after 0.4 s
    s = start(m, 0.0, 0.0)
    check(lib.tl_simulate(m, ramp, ffi.NULL, 1e-3, s, 0.4 - 1e-11))
    assert s.motion.v[0] == 0 and s.mode[0] == lib.TL_MODE_STICK
    assert s.motion.slip[0] == pytest.approx(1, abs=1e-9)
    check(lib.tl_simulate(m, ramp, ffi.NULL, 1e-3, s, 1.0))
    assert s.motion.q[0] == pytest.approx(50.0 * 0.6**3 / (6 * 95.0), rel=1e-10)
    assert s.motion.v[0] == pytest.approx(50.0 * 0.6**2 / (2 * 95.0), rel=1e-10)


def test_spring_and_dry_friction_lose_the_same_at_every_turn():
    # m q'' = -k q -+ c: each half swing takes pi sqrt(m/k) and shortens the reach by 2 c / k
    mass, k, c = 2.0, 50.0, 1.0
    m = slider(mass=mass, coulomb=c, viscous=0.0)
    spring = law(lambda t, q, v: (-k * q[0], 0.0))
    half, loss = math.pi * math.sqrt(mass / k), 2 * c / k
    s, reach = start(m, 0.2101, 0.0), 0.2101
    for swing in range(1, 6):
        check(lib.tl_simulate(m, spring, ffi.NULL, 5e-4, s, swing * half + 1e-9))
        reach -= loss
        assert abs(s.motion.q[0]) == pytest.approx(abs(reach), abs=1e-11)
    # 0.2101 - 5 * 0.04 is within c / k = 0.02 of the middle: there it stays
    check(lib.tl_simulate(m, spring, ffi.NULL, 5e-4, s, 10.0))
    assert s.motion.q[0] == pytest.approx(-0.0101, abs=1e-11) and s.motion.v[0] == 0
    assert s.motion.slip[0] == pytest.approx(k * 0.0101 / c, abs=1e-8)


def test_thousands_of_changes_in_one_call():
    m = slider(mass=1.0, coulomb=1.0, viscous=0.0)
    shake = law(lambda t, q, v: (1.3 * math.sin(20 * math.pi * t), 0.0))
    s = start(m, 0.0, 0.0)
    check(lib.tl_simulate(m, shake, ffi.NULL, 1e-3, s, 100.0))
    # 2,000 half periods, each breaking loose where 1.3 sin = 1, at 50.3 degrees, and at rest again at
    # 171.5, where the integral of 1.3 sin - 1 from there is 0 again
    assert abs(s.changes - 4000) <= 4


def test_pendulum_swings_as_long_as_the_elliptic_integral_says():
    m, reach = pendulum(), 2.5
    period = 4 * math.sqrt(0.4 / (1.5 * G)) * ellipk(math.sin(reach / 2) ** 2)
    s = run(m, start(m, reach, 0.0), period, step=1e-4)
    assert s.motion.q[0] == pytest.approx(reach, abs=1e-10) and abs(s.motion.v[0]) < 1e-9
    assert s.mode[0] == lib.TL_MODE_FREE


# ---- energy -------------------------------------------------------------------------


@pytest.mark.parametrize("torque", [0.0, 3.0])
def test_pendulum_keeps_its_energy_balance(torque):
    m = pendulum(coulomb=0.8, viscous=0.1, offset=0.3)
    s = start(m, 2.0, -6.0)
    before = energy(m, s)
    for until in np.arange(1, 41) * 0.1:
        run(m, s, until, (torque, 0.0), step=2e-4)
        assert energy(m, s) + s.dissipated_J - s.work_J == pytest.approx(before, abs=1e-9)
    assert s.changes >= 3 and s.dissipated_J > 5


def test_leg_keeps_its_energy_balance_through_stops():
    m = leg()
    s = start(m, [1.2, 0.4], [3.0, -9.0])
    before, rng = energy(m, s), np.random.default_rng(5)
    for until in np.arange(1, 201) * 0.02:
        run(m, s, until, rng.normal(size=2) * [0.15, 0.02] - [0, 0.02 * s.motion.q[1]], step=2e-4)
        assert energy(m, s) + s.dissipated_J - s.work_J == pytest.approx(before, abs=1e-9)
    assert s.changes > 40 and s.work_J > 1 and abs(s.motion.q[1]) < 0.5


def test_leg_without_friction_keeps_its_energy():
    m = leg(friction=False)
    s = start(m, [0.5, 0.1], [0.0, 0.0])
    before = energy(m, s)
    run(m, s, 10.0, step=2e-4)
    assert abs(energy(m, s) - before) < 1e-8 * before and s.dissipated_J == 0 and s.work_J == 0


# ---- the leg against a reference of its own ---------------------------------------------


class ReferenceLeg:
    """The leg in absolute angles (shank, foot) as equations.md writes it, friction apart: M(q) a = r(q, v)."""

    def __init__(self, friction=(1.2, 0.8)):
        self.coulomb = np.array(friction)

    @staticmethod
    def ratio(q):
        lead, ab, bo, ac, bof = EXAMPLE_LINKAGE

        def k(x):
            phi = math.pi - math.radians(bof) - x
            root = math.sqrt(ab**2 - (ac - bo * math.sin(phi)) ** 2)
            return 2 * math.pi / lead * (bo * math.sin(phi) - (ac - bo * math.sin(phi)) * bo * math.cos(phi) / root)

        h = 1e-3  # the slope by an eight-order difference
        weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
        return k(q), sum(w * (k(q + i * h) - k(q - i * h)) for i, w in enumerate(weights, 1)) / h

    def equations(self, q, v, torque):
        """M and r in joint coordinates, by congruence from the absolute ones; without Coulomb friction."""
        e = EXAMPLE
        ms, ds, mf, df = e["shank_mass_kg"], e["shank_com_m"], e["foot_mass_kg"], e["foot_com_m"]
        mm, dma, ls = e["ankle_motor_mass_kg"], e["ankle_motor_com_m"], e["shank_length_m"]
        ima = EXAMPLE_DRIVES[1]["rotor_inertia_kg_m2"]
        ka, slope = self.ratio(q[1])
        ts, tf, vs, vf = q[0], q[0] + q[1], v[0], v[0] + v[1]
        c, s = math.cos(ts - tf), math.sin(ts - tf)
        j = e["shank_inertia_kg_m2"] + ms * ds**2 + mm * dma**2 + mf * ls**2
        absolute = np.array([
            [j + ima * ka**2, mf * ls * df * c - ima * ka**2],
            [mf * ls * df * c - ima * ka**2, e["foot_inertia_kg_m2"] + mf * df**2 + ima * ka**2],
        ])  # fmt: skip
        bias = np.array([
            mf * ls * df * s * vf**2 - ima * ka * slope * v[1] ** 2 + (ms * ds + mm * dma + mf * ls) * G * math.sin(ts),
            -mf * ls * df * s * vs**2 + ima * ka * slope * v[1] ** 2 + mf * df * G * math.sin(tf),
        ])  # fmt: skip
        to_joint = np.array([[1.0, 0.0], [1.0, 1.0]])  # (ts, tf) from (knee, ankle)
        viscous = [EXAMPLE_DRIVES[k]["viscous_Nms_rad"] for k in range(2)]
        drive = np.array([51 * torque[0] - viscous[0] * v[0], ka * torque[1] - viscous[1] * v[1]])
        return to_joint.T @ absolute @ to_joint, drive - to_joint.T @ bias

    def accelerate(self, q, v, torque, mode):
        """Accelerations and Coulomb friction; mode None where the joint is at rest and may do as it must:
        there the minimum of a'M a / 2 - r'a + coulomb |a|, by coordinate descent."""
        matrix, r = self.equations(q, v, torque)
        r = r - self.coulomb * [m or 0 for m in mode]
        a = np.zeros(2)
        for _ in range(200):
            for j in range(2):
                left = r[j] - matrix[j, 1 - j] * a[1 - j]
                level = self.coulomb[j] if mode[j] is None else 0.0
                a[j] = math.copysign(max(abs(left) - level, 0), left) / matrix[j, j]
        return a, r - matrix @ a + self.coulomb * [m or 0 for m in mode]

    def solve(self, q, v, torque, until):
        """State at `until`: each piece between two changes by solve_ivp up to its event."""
        t, x = 0.0, np.array([*q, *v], dtype=float)
        while t < until:
            a, _ = self.accelerate(x[:2], x[2:], torque, [np.sign(w) if w else None for w in x[2:]])
            mode = [np.sign(x[2 + j]) or np.sign(a[j]) for j in range(2)]  # 0: sticks
            piece = solve_ivp(
                lambda _, y, mode=mode: [*y[2:], *self.held(y, torque, mode)[0]],
                (t, until), x, "DOP853", rtol=1e-12, atol=1e-13,
                events=[self.event(j, torque, mode) for j in range(2)],
            )  # fmt: skip
            t, x = piece.t[-1], piece.y[:, -1]
            for j in range(2):
                if len(piece.t_events[j]):  # at rest; or torn loose: a nudge over the border
                    x[2 + j] = 0.0 if mode[j] else 1e-13 * np.sign(self.held(x, torque, mode)[1][j])
        return x

    def held(self, y, torque, mode):
        """Accelerations in a mode, and the friction that the sticking joints need for it."""
        matrix, r = self.equations(y[:2], y[2:], torque)
        slides = np.flatnonzero(mode)
        a = np.zeros(2)
        a[slides] = np.linalg.solve(matrix[np.ix_(slides, slides)], (r - self.coulomb * mode)[slides])
        return a, r - matrix @ a

    def event(self, j, torque, mode):
        def change(_, y):
            if mode[j]:
                return mode[j] * y[2 + j]
            return self.coulomb[j] - abs(self.held(y, torque, mode)[1][j])

        change.terminal, change.direction = True, -1
        return change


def test_leg_agrees_with_the_event_located_reference():
    # the ankle stops first, is torn loose by the knee, and both come to rest
    for q, v, torque in (([0.6, 0.2], [2.0, -1.0], [0.0, 0.0]), ([1.2, -0.2], [0.0, 3.0], [0.02, -0.01]),
                         ([-1.0, 0.1], [-4.0, 0.5], [0.1, 0.004])):  # fmt: skip
        m = leg()
        s = start(m, q, v)
        for until in (0.15, 0.4, 0.8):
            run(m, s, until, torque, step=5e-4)
            expected = ReferenceLeg().solve(q, v, torque, until)
            assert [*s.motion.q, *s.motion.v] == pytest.approx(expected, abs=2e-9)
        assert s.changes >= 2


def test_joints_at_rest_move_as_the_minimum_says():
    rng = np.random.default_rng(11)
    seen = set()
    for _ in range(2000):
        m, reference = leg(), ReferenceLeg(rng.uniform(0.05, 2.0, 2))
        for j in range(2):
            m.drive[j].coulomb_Nm = reference.coulomb[j]
        q, v = rng.uniform(-0.5, 0.5, 2), rng.normal(size=2) * rng.integers(0, 2, 2) * 2
        torque = rng.normal(size=2) * [0.08, 0.02]
        s = start(m, q, v)
        run(m, s, 0.0, torque)
        a, friction = reference.accelerate(q, v, torque, [np.sign(w) if w else None for w in v])
        assert list(s.motion.a) == pytest.approx(a, rel=1e-9, abs=1e-9)
        assert list(s.motion.slip) == pytest.approx(friction / reference.coulomb, abs=1e-9)
        seen.add((s.mode[0], s.mode[1], v[0] == 0, v[1] == 0))
    at_rest = {(a, b) for a, b, c, d in seen if c and d}
    assert at_rest == {(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)}  # every pattern came up


def test_order_of_convergence_is_four_through_changes():
    m = leg()

    def end(step):
        s = run(m, start(m, [0.6, 0.2], [2.0, -1.0]), 0.64, step=step)
        assert s.changes >= 2
        return np.array([*s.motion.q, *s.motion.v])

    truth = end(1e-4)
    error = [np.abs(end(step) - truth).max() for step in (16e-3, 8e-3, 4e-3, 2e-3)]
    order = np.log2(np.array(error[:-1]) / error[1:])
    assert order.mean() > 3.7 and order.min() > 3.0 and error[-1] < 1e-7


# ---- use ------------------------------------------------------------------------------


def test_in_pieces_it_is_the_same_motion():
    m = leg()
    whole, pieces = start(m, [0.6, 0.2], [2.0, -1.0]), start(m, [0.6, 0.2], [2.0, -1.0])
    run(m, whole, 0.7, step=1e-4)
    for until in np.sort(np.random.default_rng(2).uniform(0, 0.7, 300)):
        run(m, pieces, until, step=1e-4)
        copy = ffi.new("tl_simulation *", pieces[0])
        assert copy.t_s == until
        pieces = copy
    run(m, pieces, 0.7, step=1e-4)
    assert list(pieces.motion.q) == pytest.approx(list(whole.motion.q), abs=1e-11)
    assert pieces.changes == whole.changes


def test_the_same_call_gives_the_same_bits():
    m = leg()
    once, again = (run(m, start(m, [1.2, 0.4], [3.0, -9.0]), 1.0, (0.1, 0.01)) for _ in range(2))
    assert bytes(ffi.buffer(once)) == bytes(ffi.buffer(again))


def test_what_is_no_number_is_said_and_the_last_state_kept():
    m, s = slider(), start(slider(), 0.0, 1.0)
    broken = law(lambda t, q, v: (math.nan if t > 0.5 else 300.0, 0.0))
    assert lib.tl_simulate(m, broken, ffi.NULL, 1e-3, s, 5.0) == lib.TL_ERR_NOT_FINITE
    assert s.t_s == pytest.approx(0.5, abs=2e-3) and math.isfinite(s.motion.q[0]) and s.motion.v[0] > 1


def test_refusals():
    m, s = leg(), ffi.new("tl_simulation *")
    s.t_s = 123.0
    zero = [0.0, 0.0]
    assert lib.tl_simulation_init(s, m, [math.nan, 0.0], zero) == lib.TL_ERR_NOT_FINITE
    assert lib.tl_simulation_init(s, m, zero, [0.0, math.inf]) == lib.TL_ERR_NOT_FINITE
    assert lib.tl_simulation_init(s, ffi.NULL, zero, zero) == lib.TL_ERR_ARGUMENT
    m.form = lib.TL_FORM_PAPER
    assert lib.tl_simulation_init(s, m, zero, zero) == lib.TL_ERR_UNSUPPORTED
    assert s.t_s == 123.0
    m.form = lib.TL_FORM_LAGRANGE
    s = start(m, zero, zero)
    assert lib.tl_simulate(m, HELD, ffi.new("double[2]"), 0.0, s, 1.0) == lib.TL_ERR_ARGUMENT
    assert lib.tl_simulate(m, HELD, ffi.new("double[2]"), 1e-3, s, -1.0) == lib.TL_ERR_ARGUMENT
    assert lib.tl_simulate(m, HELD, ffi.new("double[2]"), 1e-3, s, math.nan) == lib.TL_ERR_ARGUMENT


def test_papers_form_runs_without_dry_friction_only():
    m = leg(fixed(100.0), friction=False)
    m.form = lib.TL_FORM_PAPER
    s = run(m, start(m, [0.3, 0.1], [0.0, 0.0]), 1.0)
    assert abs(s.motion.v[0]) > 0.01
