"""lib/effect_columns.c: an angle's ripple loses to the window what the recorded motion has lost to it."""

import numpy as np
import pytest
import talus
from scipy.linalg import expm
from scipy.signal import savgol_coeffs, savgol_filter
from support import REPOSITORY
from talus import constants, ffi, lib, pointer

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
    out, slip = np.zeros((found.strengths, len(t))), np.sign(rows[1])
    s = ffi.new("tl_effect_segment *", {"model": model.struct, "n": len(t), "t_s": pointer(t)})
    for name, values in zip(("q", "v", "a", "slip"), (*rows, slip), strict=True):
        getattr(s, name)[0] = pointer(values)
    s.window[0] = ffi.NULL if window is None else window
    s.effort_Nm = ffi.NULL if effort is None else pointer(effort)
    memory, prepared = np.empty(lib.tl_effect_prepared_memory(1, len(t))), ffi.new("tl_effect_prepared *")
    lib.tl_effect_prepare(prepared, s, pointer(memory))
    wanted = ffi.new("tl_effect_wanted *", {"strengths": (1 << found.strengths) - 1, "shown": [pointer(out)]})
    lib.tl_effect_segment_columns(found, 0, pointer(np.array(shape)), 1, prepared, wanted)
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
    assert columns("delay", [0.0, 0.0], model, motion, None, effort)[0][inside] == pytest.approx(-slope[inside], abs=1e-3)
    assert columns("delay", [1.0, 0.0], model, motion, None, effort)[0][inside] == pytest.approx(-slope[inside], abs=1e-3)
    # without a sensor a late current shows an earlier torque, and telemetry that is late as a whole shows nothing
    moving = (t, motion[1], motion[2], 3.0 + t)
    assert columns("delay", [0.0, 0.0], model, moving, None)[0] == pytest.approx(-0.2, abs=1e-9)
    assert not columns("delay", [1.0, 0.0], model, moving, None).any()
    # beside one, late angles tell of a later torque
    assert columns("delay", [1.0, 0.0], model, moving, None, 0 * t)[0] == pytest.approx(0.2, abs=1e-9)


def test_a_delays_column_is_a_secant_to_the_delay_it_is_asked_near():
    """Strength times column is then the change itself, whatever the delay."""
    model, (t, q, v, _) = pendulum(), turning()
    torque = 0.2 * np.sin(40 * t)
    for near_s in (-0.013, 0.002, 0.013):
        found = columns("delay", [0.0, near_s], model, (t, q, v, np.sin(40 * t)), None)[0]
        want = (np.interp(t - near_s, t, torque) - torque) / near_s
        assert found == pytest.approx(want, abs=1e-9)


# ---- a leg ------------------------------------------------------------------------------


class LegSegment:
    """Any motion of the leg over unevenly spaced rows, and its columns; without its first rows."""

    def __init__(self, n=400, first=0):
        self.model, random = talus.Model.read(REPOSITORY / "models/leg.yaml"), np.random.default_rng(3)
        self.t, n = np.cumsum(STEP_S + random.uniform(-3e-4, 3e-4, n))[first:], n - first
        turn = np.array([5.0 * self.t, 7.0 * self.t + 1.0])
        self.q, self.v = np.array([[0.4], [0.2]]) * np.sin(turn), np.array([[2.0], [1.4]]) * np.cos(turn)
        self.a = np.array([[-10.0], [-9.8]]) * np.sin(turn)
        self.slip = np.sign(self.v)
        self.rows = [np.ascontiguousarray(x) for x in (*self.q, *self.v, *self.a, *self.slip)]
        self.segment = ffi.new("tl_effect_segment *", {"model": self.model.struct, "n": n, "t_s": pointer(self.t)})
        for k, name in enumerate(("q", "v", "a", "slip")):
            for j in range(2):
                getattr(self.segment, name)[j] = pointer(self.rows[2 * k + j])
        self.memory = np.empty(lib.tl_effect_prepared_memory(2, n))

    def columns(self, effect, joint, shapes, strengths, channels):
        """(channels, shapes, strengths, rows); what was not asked for stays NaN."""
        kind, prepared = lib.tl_effect_find(effect.encode()), ffi.new("tl_effect_prepared *")
        lib.tl_effect_prepare(prepared, self.segment, pointer(self.memory))
        out = np.full((len(channels), len(shapes), kind.strengths, len(self.t)), np.nan)
        wanted = ffi.new("tl_effect_wanted *", {"strengths": sum(1 << k for k in strengths)})
        for values, channel in zip(out, channels):
            wanted.shown[channel] = pointer(values)
        lib.tl_effect_segment_columns(kind, joint, pointer(np.array(shapes, float)), len(shapes), prepared, wanted)
        return out


@pytest.fixture(scope="module")
def leg():
    return LegSegment()


LINKS = [[1500.0, 0.002, 0.5, 0.0, 0.4, 0.0, 1.0, 0.0], [4000.0, 0.001, 0.0, 1.0, 0.2, 0.002, 0.5, 1e6]]


def test_many_shapes_at_once_are_each_as_alone_and_only_what_is_wanted_is_written(leg):
    channels = (0, 1, lib.TL_EFFECT_SHOWS_ENCODER, lib.TL_EFFECT_SHOWS_SHANK)
    together = leg.columns("elasticity", 1, LINKS, (0, 2), channels)
    assert np.isnan(together[:, :, 1]).all() and np.isfinite(together[:, :, [0, 2]]).all()
    for k, shape in enumerate(LINKS):
        for c, channel in enumerate(channels):
            for strength in (0, 2):
                alone = leg.columns("elasticity", 1, [shape], (strength,), (channel,))
                assert np.array_equal(alone[0, 0, strength], together[c, k, strength])


def test_what_another_joint_feels_of_a_twist_is_the_slope_of_the_inverse_dynamics(leg):
    """The whole twist against the inverse dynamics of the pose that it leads to, by differences of a plain model."""
    angle, torque = leg.columns("elasticity", 1, LINKS[:1], (1,), (lib.TL_EFFECT_SHOWS_ENCODER, 0))[:, 0, 1]
    size = 1e-6
    rate = np.gradient(size * angle, leg.t)
    ankle = np.array([[0.0], [1.0]])
    moved = [leg.q + ankle * size * angle, leg.v + ankle * rate, leg.a + ankle * np.gradient(rate, leg.t)]
    still = np.zeros_like(leg.q)  # without friction
    change = (leg.model.inverse(*moved, still) - leg.model.inverse(leg.q, leg.v, leg.a, still))[0] * 51 / size
    assert np.abs(change - torque)[20:-20].max() < 0.02 * np.abs(torque).max()


def sway(leg, *shape):
    """The angle by which the mount turns for each rad/Nm."""
    return leg.columns("base_compliance", constants.TL_MAX_JOINTS, [shape], (0,), (lib.TL_EFFECT_SHOWS_SHANK,))[0, 0, 0]


@pytest.mark.parametrize(("frequency_Hz", "damping"), [(1.1, 0.05), (3.0, 0.02), (14.0, 0.1), (30.0, 0.9), (39.0, 0.5)])
def test_a_mount_swings_as_the_matrix_exponential_has_it(leg, frequency_Hz, damping):
    """x'' + 2 d w x' + w^2 x = -w^2 M with the knee's torque M straight between rows, at uneven instants; steps of a hundredth of a
    swing and of a tenth. From where a drive that has always been the parabola of the first half swing leaves it, if that has rows."""
    found, drive = sway(leg, frequency_Hz, damping), knee_torque(leg)
    w = 2 * np.pi * frequency_Hz
    # (x, v, drive, its slope): the drive goes on by itself
    system = np.array([[0, 1, 0, 0], [-w * w, -2 * damping * w, -w * w, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
    first = leg.t - leg.t[0] <= 0.5 / frequency_Hz
    assert (first.sum() < 5) == (frequency_Hz == 39.0)  # too few rows for a parabola: the mount is at rest
    curve, slope, value = np.polyfit(leg.t[first] - leg.t[0], drive[first], 2) if first.sum() >= 5 else (0.0, 0.0, drive[0])
    # x = follows[0] + follows[1] t + follows[2] t^2 / 2 under value + slope t + curve t^2
    follows = np.linalg.solve([[w * w, 2 * damping * w, 1], [0, w * w, 2 * damping * w], [0, 0, w * w]], -w * w * np.array([value, slope, 2 * curve]))
    state, want = follows[:2], [follows[0]]
    for h, a, b in zip(np.diff(leg.t), drive, drive[1:]):
        state = (expm(h * system) @ [*state, a, (b - a) / h])[:2]
        want.append(state[0])
    assert found == pytest.approx(np.array(want), abs=1e-7 * np.abs(want).max())


@pytest.mark.parametrize("frequency_Hz", [4.0, 9.0])
def test_a_mount_that_swings_when_the_segment_begins_goes_on(frequency_Hz):
    """A motion of 0.8 and 1.1 Hz, of which the segment has only the end."""
    whole, end = (sway(LegSegment(1600, first), frequency_Hz, 0.03) for first in (0, 1000))
    assert np.abs(end - whole[1000:]).max() < 0.01 * np.abs(whole).max()


def knee_torque(leg):
    """Of inertia and gravity at the knee, friction apart."""
    bare = leg.model.copy()
    bare.struct.drive[1].rotor_inertia_kg_m2 = 0.0
    return bare.inverse(leg.q, leg.v, leg.a, np.zeros_like(leg.q))[0] * 51 - bare.struct.drive[0].viscous_Nms_rad * leg.v[0]


def test_instants_of_a_segment_are_those_of_its_rows(leg):
    found, one = ffi.new("tl_effect_instant[]", len(leg.t)), ffi.new("tl_effect_instant *")
    lib.tl_effect_instants(leg.segment, 1, found)
    for i in (0, 17, len(leg.t) - 1):
        motion = ffi.new("tl_motion *", [list(x[:, i]) for x in (leg.q, leg.v, leg.a, leg.slip)])
        lib.tl_effect_instant_of(leg.model.struct, motion, 1, leg.t[i], ffi.NULL, one)
        assert ffi.buffer(one)[:] == ffi.buffer(ffi.addressof(found, i))[:]
