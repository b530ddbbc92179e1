"""talus/experimental/twin.h: the recordings must be what the plant did, seen through sensors of known faults."""

import math

import numpy as np
import pytest
from leg_example import leg
from scipy import stats
from talus import TalusError, check, constants, ffi, lib, pointer

KNEE, ANKLE = lib.TL_CHANNEL_KNEE_MOTOR, lib.TL_CHANNEL_ANKLE_MOTOR
CURRENTS = [lib.TL_CHANNEL_KNEE_CURRENT, lib.TL_CHANNEL_ANKLE_CURRENT]
IDEAL = {
    "drive_step_rad": [0, 0], "ankle_step_rad": 0, "current_noise_A": [0, 0], "camera_noise_rad": 0,
    "jitter_s": 0, "clock_s": 0,
}  # fmt: skip


def bit(*channels):
    return sum(1 << c for c in {*channels})


def pendulum():
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_PENDULUM))
    m.inertia_kg_m2, m.gravity_moment_kg_m, m.gravity_zero_rad, m.torque_offset_Nm = 0.4, 1.5, 0.3, 0.2
    d = m.drive[0]
    d.coulomb_Nm, d.viscous_Nms_rad, d.torque_constant_Nm_A = 0.7, 0.3, 0.1
    check(lib.tl_transmission_fixed(ffi.addressof(d, "transmission"), 50.0))
    return m


def slider(coulomb=20.0):
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_SLIDER))
    m.mass_kg, m.force_offset_N = 95.0, 3.0
    m.drive[0].coulomb_Nm, m.drive[0].viscous_Nms_rad = coulomb, 200.0
    return m


PLANTS = {"leg": leg, "pendulum": pendulum, "slider": slider}


def multisine(m, **settings):
    e, s = ffi.new("tl_excitation *"), ffi.new("tl_multisine_settings *", lib.tl_multisine_defaults(m))
    for name, value in settings.items():
        setattr(s, name, value)
    check(lib.tl_excitation_multisine(e, lib.tl_joint_count(m), s))
    return e


def ramps(m):
    e, s = ffi.new("tl_excitation *"), ffi.new("tl_ramp_settings *", lib.tl_ramp_defaults(m))
    check(lib.tl_excitation_ramps(e, lib.tl_joint_count(m), s))
    return e


class Run:
    """n samples of a bench: rows, and the truth at each of them."""

    def __init__(self, m, e, n, **settings):
        self.model, self.excitation = m, e
        self.settings = ffi.new("tl_twin_settings *", lib.tl_twin_defaults(m, e))
        for name, value in settings.items():
            setattr(self.settings, name, value)
        bench = ffi.new("tl_twin *")
        check(lib.tl_twin_init(bench, m, e, self.settings))
        self.row = np.empty((n, lib.TL_CHANNEL_COUNT))
        self.q, self.v, self.a, self.slip, self.torque, self.current = np.empty((6, n, 2))
        for k in range(n):
            check(lib.tl_twin_next(bench, pointer(self.row[k])))
            now = bench.simulation.motion
            for field in ("q", "v", "a", "slip"):
                getattr(self, field)[k] = list(getattr(now, field))
            self.torque[k], self.current[k] = list(bench.torque), list(bench.current_A)
        self.bench, self.t = bench, self.row[:, lib.TL_CHANNEL_TIME]

    def reference(self, settled):
        at, out = ffi.new("tl_motion *"), []
        for t in self.t:
            lib.tl_excitation_at(self.excitation, t + settled, at)
            out.append(list(at.q))
        return np.array(out)


@pytest.fixture(scope="module")
def ordinary():
    m = leg()
    everything = bit(*range(0, 1), *range(KNEE, lib.TL_CHANNEL_FOOT + 1))
    return Run(m, multisine(m, seed=3), 6000, channels=everything)


# ---- the plant ------------------------------------------------------------------------


@pytest.mark.parametrize("plant", PLANTS)
def test_torque_is_that_of_the_motion_and_the_current(plant):
    m = PLANTS[plant]()
    run = Run(m, multisine(m), 2000, **IDEAL)
    joints = lib.tl_joint_count(m)
    columns = [np.ascontiguousarray(x.T) for x in (run.q, run.v, run.a, run.slip)]
    torque = np.zeros((2, len(run.t)))
    lib.tl_inverse_batch(m, len(run.t), *map(pointer, columns), pointer(torque))
    scale = np.abs(run.torque).max(0)
    assert np.abs(torque.T - run.torque)[:, :joints].max(0) == pytest.approx(0, abs=1e-12 * scale.max())
    assert (np.abs(run.slip) <= 1 + 1e-12).all() and (run.v == 0).any()  # it does stick
    if plant == "leg":
        assert np.all(run.row[:, CURRENTS] * 0.1031 == run.torque)
    if plant == "pendulum":
        assert run.row[:, lib.TL_CHANNEL_JOINT_CURRENT] * 5.0 == pytest.approx(run.torque[:, 0], rel=1e-14)
    if plant == "slider":
        assert np.all(run.row[:, lib.TL_CHANNEL_SLIDER_FORCE] == run.torque[:, 0])


def test_ideal_sensors_show_the_motion():
    m = leg()
    run = Run(m, multisine(m), 500, **IDEAL, channels=bit(0, KNEE, ANKLE, *range(KNEE, lib.TL_CHANNEL_FOOT + 1)))
    ankle = [lib.tl_transmission_motor_angle(ffi.addressof(m.drive[1].transmission), q) for q in run.q[:, 1]]
    assert np.all(run.row[:, KNEE] == 51 * run.q[:, 0]) and np.all(run.row[:, ANKLE] == ankle)
    assert np.all(run.row[:, lib.TL_CHANNEL_ANKLE_JOINT] == run.q[:, 1])
    assert np.all(run.row[:, lib.TL_CHANNEL_SHANK] == run.q[:, 0])
    assert np.all(run.row[:, lib.TL_CHANNEL_FOOT] == run.q[:, 0] + run.q[:, 1])


def test_position_control_is_the_loop_it_says():
    """The loop by hand, on a slider without dry friction, whose motion under a held force is known exactly."""
    m = slider(coulomb=0.0)
    e = multisine(m, seed=4)
    given = {"stiffness": [3e4, 0], "damping": [2.5e3, 0], "current_limit_A": [60.0, 0], "velocity_hz": 40.0,
             "control_hz": 500.0, "sample_hz": 500.0, "settle_s": 0.0}  # fmt: skip
    run = Run(m, e, 1000, **{**IDEAL, **given, "drive_step_rad": [1e-4, 0]})
    at, dt, rate = ffi.new("tl_motion *"), 1 / 500, 200.0 / 95.0
    lib.tl_excitation_at(e, 0.0, at)
    q, v, velocity, forces, places = at.q[0], 0.0, 0.0, [], []
    seen_before = round(q / 1e-4) * 1e-4
    for k in range(1000):
        lib.tl_excitation_at(e, k * dt, at)
        seen = math.floor(q / 1e-4 + 0.5) * 1e-4
        velocity += (1 - math.exp(-2 * math.pi * 40 * dt)) * ((seen - seen_before) / dt - velocity)
        seen_before = seen
        force = 3e4 * (at.q[0] - seen) + 2.5e3 * (at.v[0] - velocity)
        force = min(max(force, -60.0), 60.0)
        end = (force - 3.0) / 200.0

        def fly(t, q=q, v=v, end=end):
            gone = math.exp(-rate * t)
            return q + end * t + (v - end) * (1 - gone) / rate, end + (v - end) * gone

        forces.append(force)
        places.append(fly(dt / 2)[0])  # samples lie amid two ticks
        q, v = fly(dt)
    assert run.t == pytest.approx((np.arange(1000) + 0.5) * dt, abs=1e-12)
    assert run.row[:, lib.TL_CHANNEL_SLIDER_FORCE] == pytest.approx(forces, abs=1e-6)
    assert run.q[:, 0] == pytest.approx(places, abs=1e-10)
    assert 20 < np.sum(np.abs(forces) == 60.0) < 900


@pytest.mark.parametrize("plant", PLANTS)
def test_defaults_follow_the_reference(plant):
    m = PLANTS[plant]()
    run = Run(m, multisine(m), 4000)
    joints, settled = lib.tl_joint_count(m), run.settings.settle_s
    reference = run.reference(settled)[:, :joints]
    error, size = np.abs(run.q[:, :joints] - reference).max(0), np.ptp(reference, axis=0)
    assert (error < 0.06 * size).all()
    limits = ffi.new("tl_limits[2]")
    lib.tl_twin_limits(m, run.settings, limits)
    for j in range(joints):
        assert np.abs(run.current[:, j]).max() < 0.7 * run.settings.current_limit_A[j]
        assert np.abs(run.torque[:, j]).max() < limits[j].torque
    # settled: one period is as the next
    assert settled % 4 == 0 and settled >= 3
    period = 1000
    twice = Run(m, multisine(m), 2 * period, **IDEAL)
    assert np.abs(twice.q[:period] - twice.q[period:]).max() < 1e-3 * size.max()


def test_current_limit_holds():
    m = leg()
    run = Run(m, multisine(m), 2000, current_limit_A=[0.6, 0.1])
    assert np.abs(run.current).max(0) == pytest.approx([0.6, 0.1])
    assert np.abs(run.torque).max(0) == pytest.approx([0.6 * 0.1031, 0.1 * 0.1031])


def test_ramps_begin_at_rest_when_the_recording_does():
    m = leg()
    run = Run(m, ramps(m), 5000)
    reference = run.reference(0.0)
    assert run.settings.settle_s == 1.0 and np.abs(run.q - reference).max() < 0.02
    assert np.abs(run.q[0]).max() < 1e-3 and np.abs(run.q[:, 0]).max() > 0.3
    assert np.all(run.v[:4000, 1] == 0)  # the ankle is held by its own friction while the knee moves alone


# ---- sensors --------------------------------------------------------------------------


def test_times_are_the_true_ones(ordinary):
    steps = np.diff(ordinary.t)
    assert (steps > 0).all() and ordinary.t[0] >= 0 and steps.mean() == pytest.approx(0.004, abs=1e-6)
    assert np.abs(ordinary.t * 1e6 - np.round(ordinary.t * 1e6)).max() < 1e-6  # whole microseconds
    jitter = ordinary.t - np.arange(len(ordinary.t)) * 0.004
    jitter -= 0.5e-3  # amid two ticks
    assert np.abs(jitter).max() <= 0.3e-3 + 0.5e-6
    assert stats.kstest(jitter, stats.uniform(-0.3e-3, 0.6e-3).cdf).pvalue > 1e-3
    assert abs(np.corrcoef(jitter[:-1], jitter[1:])[0, 1]) < 4 / math.sqrt(len(jitter))
    # the angle recorded is the angle at that time
    assert ordinary.bench.simulation.t_s == pytest.approx(ordinary.t[-1] + ordinary.settings.settle_s, abs=1e-12)


def test_encoders_round_to_their_step(ordinary):
    ankle = [
        lib.tl_transmission_motor_angle(ffi.addressof(ordinary.model.drive[1].transmission), q) for q in ordinary.q[:, 1]
    ]
    for channel, truth, bits in ((KNEE, 51 * ordinary.q[:, 0], 14), (ANKLE, np.array(ankle), 14),
                                 (lib.TL_CHANNEL_ANKLE_JOINT, ordinary.q[:, 1], 16)):  # fmt: skip
        step = 2 * np.pi / 2**bits
        count = ordinary.row[:, channel] / step
        assert np.abs(count - np.round(count)).max() < 1e-7
        error = ordinary.row[:, channel] - truth
        assert np.abs(error).max() <= 0.5000001 * step and error.std() == pytest.approx(step / 12**0.5, rel=0.1)


def test_noise_is_white_normal_and_its_own_for_each_sensor(ordinary):
    camera = ordinary.row[:, [lib.TL_CHANNEL_SHANK, lib.TL_CHANNEL_FOOT]]
    camera = (camera - np.cumsum(ordinary.q, axis=1)) / 1e-3
    noise = np.column_stack([(ordinary.row[:, CURRENTS] - ordinary.current) / [0.020, 0.005], camera])
    n = len(noise)
    for x in noise.T:
        assert stats.kstest(x, stats.norm.cdf).pvalue > 1e-3
        assert abs(np.corrcoef(x[:-1], x[1:])[0, 1]) < 4 / math.sqrt(n)
    apart = np.corrcoef(noise.T) - np.eye(4)
    assert np.abs(apart).max() < 4 / math.sqrt(n)


def test_a_seed_is_a_recording():
    m = leg()
    e = multisine(m)
    one, again, other = Run(m, e, 300), Run(m, e, 300), Run(m, e, 300, seed=2)
    assert one.row.tobytes() == again.row.tobytes()
    assert not np.any(one.row[:, CURRENTS] == other.row[:, CURRENTS]) and np.any(one.t != other.t)
    # noise is in the sensors, not in the plant
    quiet, noisy = Run(m, e, 300, jitter_s=0, current_noise_A=[0, 0]), Run(m, e, 300, jitter_s=0, seed=9)
    assert np.all(quiet.q == noisy.q)


def test_channels_that_were_not_asked_for_are_nan():
    m = leg()
    run = Run(m, multisine(m), 3)
    asked = [0, KNEE, ANKLE, lib.TL_CHANNEL_ANKLE_JOINT, *CURRENTS]
    others = [c for c in range(lib.TL_CHANNEL_COUNT) if c not in asked]
    assert run.settings.channels == bit(*asked)
    assert np.isfinite(run.row[:, asked]).all() and np.isnan(run.row[:, others]).all()
    for plant, channels in ((pendulum, (0, lib.TL_CHANNEL_JOINT, lib.TL_CHANNEL_JOINT_CURRENT)),
                            (slider, (0, lib.TL_CHANNEL_SLIDER, lib.TL_CHANNEL_SLIDER_FORCE))):  # fmt: skip
        m = plant()
        assert lib.tl_twin_defaults(m, multisine(m)).channels == bit(*channels)


# ---- from a recording back to the truth --------------------------------------------------


def test_least_squares_on_recorded_angles_finds_the_leg():
    """Ideal sensors: what is left is the control's own staircase. Any slip of sign, time or unit shows here."""
    m = leg()
    fast = {"control_hz": 8000.0, "sample_hz": 1000.0, "velocity_hz": 400.0, "step_s": 5e-4}
    run = Run(m, multisine(m), 12000, **{**IDEAL, **fast})
    n, motions = len(run.t), []
    for j in range(2):
        t = ffi.addressof(m.drive[j].transmission)
        q = np.array([lib.tl_transmission_joint_angle(t, x) for x in run.row[:, (KNEE, ANKLE)[j]]])
        one, two = (np.array([np.roll(q, -k), np.roll(q, k)]) for k in (1, 2))
        v = (8 * (one[0] - one[1]) - (two[0] - two[1])) / 12e-3  # five points, exact to the fourth order
        a = (16 * one.sum(0) - two.sum(0) - 30 * q) / 12e-6
        motions.append((q, v, a))
    q, v, a = np.array(motions).transpose(1, 0, 2)
    keep = np.ones(n, bool)
    keep[:50] = keep[-50:] = False
    for j in range(2):
        turns = np.flatnonzero((np.abs(v[j]) < 0.008) | (np.sign(v[j]) != np.sign(np.roll(v[j], 1))))
        for k in range(-12, 13):
            keep[np.clip(turns + k, 0, n - 1)] = False
    rows, right = [], []
    buffer, known = ffi.new("double[]", 2 * constants.TL_MAX_ROW), ffi.new("double[2]")
    index, at = ffi.new("int[]", constants.TL_MAX_ROW), ffi.new("tl_motion *")
    for i in np.flatnonzero(keep):
        at.q, at.v, at.a, at.slip = q[:, i].tolist(), v[:, i].tolist(), a[:, i].tolist(), np.sign(v[:, i]).tolist()
        lib.tl_regressor(m, at, buffer, known)
        for j, channel in enumerate(CURRENTS):
            row = np.zeros(9)
            for k in range(lib.tl_row_index(m, j, index)):
                row[index[k]] = buffer[j * constants.TL_MAX_ROW + k]
            rows.append(row * (1, 4)[j])
            right.append((0.1031 * run.row[i, channel] - known[j]) * (1, 4)[j])
    truth = np.zeros(9)
    lib.tl_base_values(m, pointer(truth))
    scale = np.linalg.norm(rows, axis=0)
    found = np.linalg.lstsq(np.array(rows) / scale, np.array(right), rcond=None)[0] / scale
    assert keep.sum() > 5000 and found == pytest.approx(truth, rel=1e-4)


# ---- refusals ---------------------------------------------------------------------------


@pytest.mark.parametrize("wrong", [
    {"control_hz": 0.0}, {"sample_hz": 1001.0}, {"sample_hz": 0.0}, {"jitter_s": 0.002}, {"jitter_s": -1e-6},
    {"clock_s": 0.001}, {"settle_s": -1.0}, {"settle_s": math.nan}, {"step_s": 0.0}, {"stiffness": [-1.0, 0.0]},
    {"damping": [math.nan, 0.0]}, {"current_limit_A": [1.0, math.inf]}, {"current_noise_A": [0.0, -0.1]},
    {"drive_step_rad": [2.0, 0.0]}, {"velocity_hz": 0.0}, {"camera_noise_rad": math.nan}, {"ankle_step_rad": -1.0},
])  # fmt: skip
def test_settings_out_of_range(wrong):
    m = leg()
    with pytest.raises(TalusError) as refusal:
        Run(m, multisine(m), 1, **wrong)
    assert refusal.value.status == lib.TL_ERR_RANGE


def test_other_refusals():
    m, bench = leg(), ffi.new("tl_twin *")
    e = multisine(m)
    s = ffi.new("tl_twin_settings *", lib.tl_twin_defaults(m, e))
    s.channels |= bit(lib.TL_CHANNEL_KNEE_TEMP)
    assert lib.tl_twin_init(bench, m, e, s) == lib.TL_ERR_UNSUPPORTED
    s.channels = bit(lib.TL_CHANNEL_SLIDER)
    assert lib.tl_twin_init(bench, m, e, s) == lib.TL_ERR_UNSUPPORTED
    s.channels = bit(0)
    assert lib.tl_twin_init(bench, pendulum(), e, s) == lib.TL_ERR_ARGUMENT
    m.form = lib.TL_FORM_PAPER
    assert lib.tl_twin_init(bench, m, e, s) == lib.TL_ERR_UNSUPPORTED
    assert bench.model == ffi.NULL
