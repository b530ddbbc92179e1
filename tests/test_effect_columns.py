"""lib/effect_columns.c: an angle's ripple loses to the window what the recorded motion has lost to it."""

import numpy as np
import pytest
import talus
from scipy.signal import savgol_coeffs, savgol_filter
from talus import ffi, lib, pointer

STEP_S, SAMPLES = 0.004, 9
ORDER = 5
WINDOW_S = (SAMPLES - 1) * STEP_S
PER_TURN = 8.0


def pendulum():
    """A pendulum of inertia alone, driven by its motor directly."""
    joint = {"transmission": {"type": "fixed", "ratio": 1}, "torque_constant_Nm_A": 1.0}
    return talus.Model.from_tree({"plant": "pendulum", "gravity_m_s2": 9.81, "inertia_kg_m2": 0.2, "gravity_moment_kg_m": 0.0, "gravity_zero_rad": 0.0,
                                  "joint": {**joint, "friction": {"coulomb_Nm": 0.0, "viscous_Nms_rad": 0.0}}})  # fmt: skip


def turning(n=600):
    """(t, q, v, a) of a joint that turns ever faster."""
    t = STEP_S * np.arange(n)
    return t, 0.3 + 2.0 * t + 1.5 * t**2, 2.0 + 3.0 * t, np.full(n, 3.0)


def columns(kind, shape, model, motion, window, effort=None):
    """Columns of an effect along a motion without stops; `effort`: the drive's torque beside a sensor at the output."""
    t, *rows = (np.ascontiguousarray(x) for x in motion)
    found = lib.tl_effect_find(kind.encode())
    work, out = np.empty(lib.tl_effect_stretch_work(len(t))), np.zeros((found.strengths, len(t)))
    slip = np.sign(rows[1])
    s = ffi.new("tl_effect_stretch *", {"model": model.struct, "n": len(t), "t_s": pointer(t), "work": pointer(work)})
    for name, values in zip(("q", "v", "a", "slip"), (*rows, slip), strict=True):
        getattr(s, name)[0] = pointer(values)
    s.window[0] = ffi.NULL if window is None else window
    s.effort_Nm = ffi.NULL if effort is None else pointer(effort)
    lib.tl_effect_columns_along(found, 0, pointer(np.array(shape)), s, 0, pointer(out))
    return out


def test_a_ripple_in_angle_is_differentiated_by_the_recordings_own_window():
    """Inertia alone: the torque is inertia times the ripple's second derivative, as a Savitzky-Golay filter has it."""
    model = pendulum()
    motion = turning()
    window = ffi.new("tl_window *", {"order": ORDER, "length_s": WINDOW_S})
    got = columns("kinematic_error", [PER_TURN, 0.0], model, motion, window)
    load = 0.2 * motion[3]
    for k, (wave, slope) in enumerate([(np.sin, np.cos), (np.cos, lambda x: -np.sin(x))]):
        ripple = wave(PER_TURN * motion[1])
        second = savgol_filter(ripple, SAMPLES, ORDER, deriv=2, delta=STEP_S)
        want = 0.2 * second + load * PER_TURN * slope(PER_TURN * motion[1])  # and the slope carries the load
        inside = slice(SAMPLES, -SAMPLES)
        assert np.abs(got[2 + k] - want)[inside].max() < 2e-3 * np.abs(want).max()


def test_without_a_window_the_ripples_exact_rates_stand():
    model, motion = pendulum(), turning()
    got = columns("kinematic_error", [PER_TURN, 0.0], model, motion, None)
    _, q, v, a = motion
    want = 0.2 * (PER_TURN * np.cos(PER_TURN * q) * a - (PER_TURN * v) ** 2 * np.sin(PER_TURN * q))
    want += 0.2 * a * PER_TURN * np.cos(PER_TURN * q)
    assert np.abs(got[2] - want).max() < 1e-4 * np.abs(want).max()


def test_the_law_of_what_shows_of_a_ripple_follows_the_windows_own_response():
    """A free motor's acceleration takes the ripple's place, and the window leaves of it what it leaves of any."""
    lowpass_Hz = 30.0  # whose window has nine samples of 4 ms
    weights = savgol_coeffs(SAMPLES, ORDER, deriv=2, delta=STEP_S, use="dot")
    at = STEP_S * (np.arange(SAMPLES) - SAMPLES // 2)
    for share_of_lowpass in (0.3, 0.6, 1.0, 1.3, 1.67):
        hz = share_of_lowpass * lowpass_Hz
        left = -(weights * np.cos(2 * np.pi * hz * at)).sum() / (2 * np.pi * hz) ** 2
        now = ffi.new("tl_effect_instant *", {"v": 2 * np.pi * hz, "ratio": 1.0, "motor_rad": np.pi / 2})
        torque, friction = np.zeros(4), np.zeros(4)
        kind = lib.tl_effect_find(b"cogging")
        kind.law(now, pointer(np.array([1.0, 1.67 * lowpass_Hz])), pointer(torque), pointer(friction))
        assert abs(torque[0] - left) < 0.06


def test_what_a_sensor_at_the_output_tells_of_the_drive():
    """Torque that must be asked for more: a constant that gives more, a current that is old, telemetry that is."""
    model, motion = pendulum(), turning()
    t, inside = motion[0], slice(2, -2)
    effort = 1.5 * np.sin(3.0 * t)
    slope = 4.5 * np.cos(3.0 * t)
    assert np.array_equal(columns("torque_constant", [], model, motion, None, effort)[0], -effort)
    assert columns("delay", [0.0], model, motion, None, effort)[0][inside] == pytest.approx(-slope[inside], abs=1e-3)
    assert columns("delay", [1.0], model, motion, None, effort)[0][inside] == pytest.approx(-slope[inside], abs=1e-3)
    # without a sensor a late current shows an earlier torque, and telemetry that is late as a whole shows nothing
    moving = (t, motion[1], motion[2], 3.0 + t)
    assert columns("delay", [0.0], model, moving, None)[0] == pytest.approx(-0.2, abs=1e-9)
    assert not columns("delay", [1.0], model, moving, None).any()
    # beside one, late angles tell of a later torque
    assert columns("delay", [1.0], model, moving, None, 0 * t)[0] == pytest.approx(0.2, abs=1e-9)
