"""lib/gap/stepped.c: laws with a memory, against closed forms and SciPy's integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from talus import ffi, lib, pointer


def dahl(position, travel, squared):
    state = np.empty(len(position))
    lib.tl_gap_dahl(pointer(position), len(position), travel, squared, pointer(state))
    return state


@pytest.mark.parametrize("power", [1, 2])
def test_dahls_state_is_the_solution_of_its_differential_equation(power):
    t = np.linspace(0, 3, 4001)
    position = 0.01 * np.sin(2 * np.pi * t) + 0.004 * np.sin(5.3 * t)
    speed = lambda s: 0.02 * np.pi * np.cos(2 * np.pi * s) + 0.004 * 5.3 * np.cos(5.3 * s)
    rate = lambda s, z: (1 - np.sign(speed(s)) * z) ** power * speed(s) / 0.003
    want = solve_ivp(rate, (0, 3), [0.0], t_eval=t, rtol=1e-9, atol=1e-11, max_step=1e-3).y[0]
    # a sample that straddles a reversal moves less than its path: 0.002 of the travel, once a reversal
    assert np.abs(dahl(position, 0.003, power == 2) - want).max() < 5e-3


def test_dahls_state_settles_at_one_over_a_long_travel():
    assert dahl(np.linspace(0, 1, 100), 0.01, False)[-1] == pytest.approx(1.0, abs=1e-12)


def link_along(shape, motor_rad_s, other_Nm):
    link = ffi.new("tl_gap_link *", {"friction_share": 0.0, "coulomb_Nm": 0.0, "viscous_Nms_rad": 0.0, "gap_rad": 0.0, **shape})
    angle, torque = np.empty(len(motor_rad_s)), np.empty(len(motor_rad_s))
    lib.tl_gap_link_along(link, pointer(motor_rad_s), pointer(other_Nm), len(angle), pointer(angle), pointer(torque))
    return angle, torque


def test_a_link_behind_a_spring_is_a_driven_oscillator():
    step_s, k, inertia = 0.001, 300.0, 0.05
    t = np.arange(0, 2, step_s)
    motor, load = np.sin(4 * t), 0.8 * np.sin(9 * t)
    damping = 0.2 * np.sqrt(k * inertia)
    rate = lambda s, x: [x[1] - np.sin(4 * s), (-k * x[0] - damping * (x[1] - np.sin(4 * s)) - 0.8 * np.sin(9 * s)) / inertia]
    want = solve_ivp(rate, (0, 2), [0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-12).y[0]
    got, _ = link_along({"stiffness_Nm_rad": k, "inertia_kg_m2": inertia, "step_s": step_s}, motor, load)
    assert np.abs(got - want).max() < 0.02 * np.abs(want).max()  # first order in the step


def test_a_constant_load_twists_by_load_over_stiffness_and_takes_up_the_gap():
    n = 4000
    shape = {"stiffness_Nm_rad": 500.0, "gap_rad": 0.006, "inertia_kg_m2": 0.02, "step_s": 0.002}
    angle, torque = link_along(shape, np.zeros(n), np.full(n, 1.5))
    assert angle[-1] == pytest.approx(-(0.003 + 1.5 / 500), rel=1e-6)
    assert torque[-1] == pytest.approx(1.5, rel=1e-6)


def test_friction_at_the_link_holds_a_load_below_it():
    n = 500
    shape = {"stiffness_Nm_rad": 500.0, "inertia_kg_m2": 0.02, "friction_share": 1.0, "coulomb_Nm": 2.0, "step_s": 0.002}
    angle, torque = link_along(shape, np.zeros(n), np.full(n, 1.5))
    assert not angle.any() and not torque.any()


@pytest.mark.parametrize("stiffness", [1.0, 1e3, 1e9])
def test_steps_are_enough_for_the_oscillation_and_bounded(stiffness):
    link = ffi.new("tl_gap_link *", {"stiffness_Nm_rad": stiffness, "inertia_kg_m2": 0.01, "step_s": 0.004})
    steps, turn = lib.tl_gap_link_steps(link), 0.004 * np.sqrt(stiffness / 0.01)
    assert 4 <= steps <= 60 and (steps == 60 or turn / steps <= 0.4)
