"""lib/hysteresis.c: laws with a memory, against closed forms and SciPy's integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from talus import ffi, lib, pointer


def dahl(position, travel, power, first=0.0):
    state = np.empty(len(position))
    lib.tl_dahl_along(pointer(position), len(position), travel, power, first, pointer(state))
    return state


@pytest.mark.parametrize("power", [1.0, 1.4, 2.0])
def test_dahls_state_is_the_solution_of_its_differential_equation(power):
    t = np.linspace(0, 3, 4001)
    position = 0.01 * np.sin(2 * np.pi * t) + 0.004 * np.sin(5.3 * t)
    speed = lambda s: 0.02 * np.pi * np.cos(2 * np.pi * s) + 0.004 * 5.3 * np.cos(5.3 * s)
    rate = lambda s, z: (1 - min(np.sign(speed(s)) * z, 1.0)) ** power * speed(s) / 0.003
    want = solve_ivp(rate, (0, 3), [0.0], t_eval=t, rtol=1e-9, atol=1e-11, max_step=1e-3).y[0]
    # a sample that straddles a reversal moves less than its path: 0.002 of the travel, once a reversal
    assert np.abs(dahl(position, 0.003, power) - want).max() < 5e-3


def test_dahls_state_settles_at_one_over_a_long_travel():
    assert dahl(np.linspace(0, 1, 100), 0.01, 1.0)[-1] == pytest.approx(1.0, abs=1e-12)


def link_along(shape, motor_rad, motor_rad_s, other_Nm, t=None):
    shape = {"damping_s": 0.2 * np.sqrt(shape["inertia_kg_m2"] / shape["stiffness_Nm_rad"]), **shape}
    link = ffi.new("tl_two_mass *", {"friction_share": 0.0, "coulomb_Nm": 0.0, "viscous_Nms_rad": 0.0, "gap_rad": 0.0, **shape})
    t = shape["step_s"] * np.arange(len(motor_rad)) if t is None else t
    out = np.empty((3, len(t)))
    motion = ffi.new("tl_two_mass_motion *", [pointer(x) for x in out])
    lib.tl_two_mass_along(link, *map(pointer, (t, motor_rad, motor_rad_s, other_Nm)), len(t), motion)
    angle, torque, _ = out
    return angle, torque


def test_a_link_behind_a_spring_is_a_driven_oscillator():
    step_s, k, inertia = 0.001, 300.0, 0.05
    t = np.arange(0, 2, step_s)
    motor, load = np.sin(4 * t), 0.8 * np.sin(9 * t)
    damping = 0.2 * np.sqrt(k * inertia)
    rate = lambda s, x: [x[1] - np.sin(4 * s), (-k * x[0] - damping * (x[1] - np.sin(4 * s)) - 0.8 * np.sin(9 * s)) / inertia]
    want = solve_ivp(rate, (0, 2), [0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-12).y[0]
    got, _ = link_along({"stiffness_Nm_rad": k, "inertia_kg_m2": inertia, "step_s": step_s}, -np.cos(4 * t) / 4, motor, load)
    assert np.abs(got - want).max() < 0.02 * np.abs(want).max()  # first order in the step
    uneven = t + 0.3 * step_s * np.random.default_rng(3).uniform(-1, 1, len(t))
    shape = {"stiffness_Nm_rad": k, "inertia_kg_m2": inertia, "step_s": step_s}
    got, _ = link_along(shape, -np.cos(4 * uneven) / 4, np.sin(4 * uneven), 0.8 * np.sin(9 * uneven), uneven)
    assert np.abs(got - np.interp(uneven, t, want)).max() < 0.02 * np.abs(want).max()


def test_a_constant_load_twists_by_load_over_stiffness_and_takes_up_the_gap():
    n = 4000
    shape = {"stiffness_Nm_rad": 500.0, "gap_rad": 0.006, "inertia_kg_m2": 0.02, "step_s": 0.002}
    angle, torque = link_along(shape, np.zeros(n), np.zeros(n), np.full(n, 1.5))
    assert angle[-1] == pytest.approx(-(0.003 + 1.5 / 500), rel=1e-6)
    assert torque[-1] == pytest.approx(1.5, rel=1e-6)


def test_friction_at_the_link_holds_a_load_below_it():
    n = 500
    shape = {"stiffness_Nm_rad": 500.0, "inertia_kg_m2": 0.02, "friction_share": 1.0, "coulomb_Nm": 2.0, "step_s": 0.002}
    angle, torque = link_along(shape, np.zeros(n), np.zeros(n), np.full(n, 1.5))
    assert not angle.any() and not torque.any()


def test_viscous_friction_stands_on_its_own_side():
    """The link drags behind a motor at constant speed by its own share of viscous friction alone."""
    n, speed = 4000, 0.7
    shape = {"stiffness_Nm_rad": 400.0, "inertia_kg_m2": 0.02, "viscous_Nms_rad": 0.5, "step_s": 0.002}
    motor = speed * 0.002 * np.arange(n)
    for share in (0.0, 0.4, 1.0):
        angle, torque = link_along({**shape, "viscous_share": share}, motor, np.full(n, speed), np.zeros(n))
        assert torque[-1] == pytest.approx(share * 0.5 * speed, abs=1e-5)
        assert angle[-1] == pytest.approx(-share * 0.5 * speed / 400.0, abs=1e-7)


def test_friction_in_the_gap_takes_the_link_along():
    """At rest against its motor it carries a load up to its level; beyond that the link falls to the next tooth."""
    n, speed, gap = 6000, 0.7, 0.02
    shape = {"stiffness_Nm_rad": 400.0, "gap_rad": gap, "inertia_kg_m2": 0.02, "drag_Nm": 0.3, "step_s": 0.002}
    motor, speeds = speed * 0.002 * np.arange(n), np.full(n, speed)
    angle, torque = link_along(shape, motor, speeds, np.full(n, 0.25))
    assert abs(angle[-1]) < 1e-9 and torque[-1] == pytest.approx(0.25, rel=1e-6)
    angle, torque = link_along(shape, motor, speeds, np.full(n, 0.8))
    assert torque[-1] == pytest.approx(0.8, rel=1e-6)
    assert -gap / 2 - 0.8 / 400 <= angle[-1] <= -gap / 2 - 0.5 / 400  # the spring carries what friction leaves


def test_a_link_that_friction_holds_keeps_its_place_while_the_motor_speeds_up():
    n, step_s, w = 400, 0.002, 9.0
    shape = {"stiffness_Nm_rad": 400.0, "gap_rad": 0.02, "inertia_kg_m2": 0.02, "drag_Nm": 3.0, "step_s": step_s}
    t_s = step_s * np.arange(n)
    angle, torque = link_along(shape, 0.3 * np.sin(w * t_s), 0.3 * w * np.cos(w * t_s), np.zeros(n))
    assert np.abs(angle).max() < 1e-5  # of 5.4 rad/s that the speed changes by
    assert torque[1:-1] == pytest.approx(-0.02 * 0.3 * w**2 * np.sin(w * t_s[1:-1]), abs=2e-4)


@pytest.mark.parametrize("load", [0.2, 1.5, 6.0])
def test_a_spring_may_be_soft_at_first_and_harden(load):
    n, k, soft, share, cube = 8000, 500.0, 0.002, 0.4, 2e6
    shape = {"stiffness_Nm_rad": k, "soft_rad": soft, "soft_share": share, "hardening_Nm_rad3": cube,
             "inertia_kg_m2": 0.02, "step_s": 0.002}  # fmt: skip
    angle, torque = link_along(shape, np.zeros(n), np.zeros(n), np.full(n, load))
    want = brentq(lambda x: share * k * min(x, soft) + k * max(x - soft, 0) + cube * x**3 - load, 0, 0.1)
    assert angle[-1] == pytest.approx(-want, rel=1e-4)
    assert torque[-1] == pytest.approx(load, rel=1e-4)


@pytest.mark.parametrize("stiffness", [1.0, 1e3, 1e9])
def test_steps_are_enough_for_the_oscillation_and_bounded(stiffness):
    link = ffi.new("tl_two_mass *", {"stiffness_Nm_rad": stiffness, "inertia_kg_m2": 0.01, "step_s": 0.004})
    steps, turn = lib.tl_two_mass_steps(link), 0.004 * np.sqrt(stiffness / 0.01)
    assert 4 <= steps <= 60 and (steps == 60 or turn / steps <= 0.4)


def test_a_link_that_begins_under_its_load_does_not_ring():
    n, load = 500, 1.5
    shape = {"stiffness_Nm_rad": 500.0, "gap_rad": 0.006, "inertia_kg_m2": 0.02, "settle_s": 0.5, "step_s": 0.002}
    angle, torque = link_along(shape, np.zeros(n), np.zeros(n), np.full(n, load))
    assert angle == pytest.approx(-(0.003 + load / 500), rel=1e-9) and torque == pytest.approx(load, rel=1e-9)


def test_a_link_whose_recording_begins_amid_its_motion_does_not_ring():
    """The forced oscillation in closed form from the first row on; a link that began without its twist would ring for seconds."""
    step_s, k, inertia, damping_s, w = 0.004, 300.0, 0.05, 0.0008, 9.0
    t_s = step_s * np.arange(1000)
    motor = lambda power: np.ascontiguousarray(np.real(0.3 * (1j * w) ** power * np.exp(1j * (w * t_s + 0.7))))
    response = inertia * w**2 / (k - inertia * w**2 + 1j * k * damping_s * w)
    want = np.real(0.3 * response * np.exp(1j * (w * t_s + 0.7)))
    shape = {"stiffness_Nm_rad": k, "inertia_kg_m2": inertia, "step_s": step_s, "damping_s": damping_s}
    off = [np.abs(link_along({**shape, "settle_s": settle_s}, motor(0), motor(1), np.zeros(1000))[0] - want).max()
           for settle_s in (0.0, 2.0)]  # fmt: skip
    assert off[0] > 0.5 * np.abs(want).max() and off[1] < 0.05 * np.abs(want).max()


def test_the_motors_angle_counts_where_its_speed_does_not_tell():
    """A step of the motor's angle between samples of no speed moves the link as the step does."""
    n, step_s, k, inertia = 4000, 0.001, 300.0, 0.05
    motor = np.where(np.arange(n) < 1000, 0.0, 0.002)
    shape = {"stiffness_Nm_rad": k, "inertia_kg_m2": inertia, "step_s": step_s}
    angle, _ = link_along(shape, motor, np.zeros(n), np.zeros(n))
    w, decay = np.sqrt(k / inertia), 0.1 * np.sqrt(k / inertia)
    after = (np.arange(n) - 999.5)[1000:] * step_s  # the motor passes over between two samples
    swing = np.sqrt(w**2 - decay**2)
    # the damper's jolt gives the link a speed of 2 decay times the step
    want = -0.002 * np.exp(-decay * after) * (np.cos(swing * after) - decay / swing * np.sin(swing * after))
    assert np.abs(angle[1000:] - want).max() < 0.03 * 0.002


def test_links_that_take_their_steps_in_turn_move_as_each_alone_to_the_bit():
    """Of several lengths, none at all among them, and with more steps in a sample than their neighbours."""
    random = np.random.default_rng(5)
    runs, out, want, alive = ffi.new("tl_two_mass_run[]", 7), [], [], []
    for k, (n, gap_rad, stiffness) in enumerate([(900, 0.0, 300), (700, 0.01, 300), (0, 0.0, 300), (1, 0.0, 300), (900, 0.004, 9e5),
                                                 (400, 0.02, 9e5), (900, 0.0, 300)]):  # fmt: skip
        t = 0.004 * np.arange(n) + 1e-4 * random.random(n)
        arrays = [t, np.sin(3 * t), 3 * np.cos(3 * t), 4 * np.sin(7 * t + k)]
        link = ffi.new("tl_two_mass *", {"stiffness_Nm_rad": stiffness, "gap_rad": gap_rad, "soft_share": 1.0, "drag_Nm": 0.1 * k,
                                         "friction_share": 0.5, "coulomb_Nm": 1.0, "inertia_kg_m2": 0.05, "damping_s": 0.002,
                                         "settle_s": 1.0, "step_s": 0.004})  # fmt: skip
        out.append(np.full((3, n), np.nan))
        want.append(np.full((3, n), np.nan))
        runs[k] = (link[0], *map(pointer, arrays), n, [pointer(x) for x in out[-1]])
        alive.append(arrays)
        lib.tl_two_mass_along(link, *map(pointer, arrays), n, ffi.new("tl_two_mass_motion *", [pointer(x) for x in want[-1]]))
    lib.tl_two_mass_along_each(runs, len(runs))
    assert all(a.tobytes() == b.tobytes() for a, b in zip(out, want))
    assert all(np.isfinite(a).all() for a in out) and len({lib.tl_two_mass_steps(ffi.addressof(run, "link")) for run in runs}) == 2
