"""lib/kinematics*.c: joint motion from angles, against motions known in closed form."""

import itertools

import numpy as np
import pytest
import talus
import yaml
from support import REPOSITORY, run
from talus import check, ffi, lib, pointer


def slider_model():
    return talus.Model.from_tree(
        {"plant": "slider", "mass_kg": 1.0, "friction": {"coulomb_N": 1.0, "viscous_Ns_m": 1.0}, "force_offset_N": 0.0})


def slider_recording(t, x, **score):
    return talus.Recording({"time_s": t, "slider_m": x, "slider_force_N": np.zeros(len(t))}, score)


def sensing(t, x):
    return talus.Regression(slider_model(), slider_recording(t, x)).sensing()


def decelerate_rest_leave(t, rest=(1.0, 1.06), a_before=-6.0, a_after=-2.0):
    """Moves forward, comes to rest with one acceleration, stands, leaves backwards with another."""
    begin, end = rest
    before, after = np.minimum(t - begin, 0), np.maximum(t - end, 0)
    position = 0.5 * a_before * before**2 + 0.5 * a_after * after**2
    velocity = a_before * before + a_after * after
    acceleration = np.where(t < begin, a_before, np.where(t > end, a_after, 0.0))
    return position, velocity, acceleration


def test_a_stop_does_not_smear_the_acceleration():
    rng = np.random.default_rng(1)
    t = np.arange(500) * 0.004 + rng.uniform(-3e-4, 3e-4, 500)
    x, v, a = decelerate_rest_leave(t)
    recording = slider_recording(t, x)
    regression = talus.Regression(slider_model(), recording)
    motion = regression.motion()
    moving = (np.abs(v) > 0.02) & (t > 0.05) & (t < 1.95)
    assert np.max(np.abs(motion["a"][0] - a)[moving]) < 1e-3 * 6
    assert np.max(np.abs(motion["v"][0] - v)[moving]) < 1e-5
    # the same window across the stop would be wrong by a tenth of the jump beside it
    window, work = regression.struct.sensing[0].window, np.empty(lib.tl_reconstruct_workspace(500))
    uncut = np.empty(500)
    check(lib.tl_reconstruct(ffi.addressof(window), pointer(t), pointer(x), 500, ffi.NULL, ffi.NULL, pointer(uncut),
                             pointer(work), len(work)))
    assert np.max(np.abs(uncut - a)[moving]) > 0.6


def shaken_to_rest(t, begin, hz, size):
    """Braked by 20 m/s2 and a ripple of `size` (what cogging does), at rest from `begin` on for 50 ms."""
    w, before, after = 2 * np.pi * hz, np.minimum(t - begin, 0), np.maximum(t - begin - 0.05, 0)
    acceleration = np.where(t < begin, -20.0 + size * np.sin(w * before), 0.0)
    return -10.0 * before**2 + size * (before / w - np.sin(w * before) / w**2) - 5.0 * after**2, acceleration


def test_the_last_row_before_a_stop_does_not_overshoot():
    """The instant of rest falls anywhere between samples; the one-sided window of the whole piece is the measure."""
    ours, plain = [], []
    for begin in 1.0 + np.arange(0.0, 0.004, 0.00025):
        t = np.arange(500) * 0.004
        x, truth = shaken_to_rest(t, begin, 60.0, 10.0)
        x = np.round(x / 8e-6) * 8e-6
        regression = talus.Regression(slider_model(), slider_recording(t, x))
        space, _alive = regression._segment(0, 500, with_rows=False)
        last = space.track.stop[0][0].before
        window, work, uncut = regression.struct.sensing[0].window, np.empty(lib.tl_reconstruct_workspace(500)), np.empty(500)
        check(lib.tl_reconstruct(ffi.addressof(window), pointer(t), pointer(x), last + 1, ffi.NULL, ffi.NULL,
                                 pointer(uncut), pointer(work), len(work)))
        ours.append(space.track.a[0][last] - truth[last])
        plain.append(uncut[last] - truth[last])
    rms = lambda error: np.sqrt(np.mean(np.square(error)))
    assert rms(ours) < 0.5 * rms(plain)


STICTION = {"effect": "stribeck", "joint": "knee", "parameters": {"extra_Nm": 0.5, "speed_rad_s": 0.12, "exponent": 2.0}}


def first_rows(folder, effects):
    """(ours, plain) errors of the knee's acceleration at the first rows after stops, against the twin's true motion; plain
    is the window of the whole piece."""
    tree = {**yaml.safe_load((REPOSITORY / "models/leg.yaml").read_text()), "effects": effects}
    (folder / "truth.yaml").write_text(yaml.safe_dump(tree))
    run("talus-sim", "--model", folder / "truth.yaml", "--out", folder / "leg.csv", "--duration", 40,
        "--motion", folder / "motion.csv")  # fmt: skip
    truth = np.genfromtxt(folder / "motion.csv", delimiter=",", names=True)["knee_acceleration_rad_s2"]
    recording = talus.Recording.read(folder / "leg.csv")
    t, x, n = recording.t, recording.columns["knee_motor_rad"] / 51, len(recording.t)
    regression = talus.Regression(talus.Model.read(REPOSITORY / "models/leg.yaml"), recording)
    space, _alive = regression._segment(0, n, with_rows=False)
    window, work = regression.struct.sensing[0].window, np.empty(lib.tl_reconstruct_workspace(n))
    stops, errors = [space.track.stop[0][k] for k in range(space.track.stops[0])], []
    for stop, following in itertools.pairwise(stops):
        if following.before - stop.after < 12:
            continue
        piece = slice(stop.after, following.before + 1)
        t_s, angle, uncut = t[piece].copy(), x[piece].copy(), np.empty(piece.stop - piece.start)
        check(lib.tl_reconstruct(ffi.addressof(window), pointer(t_s), pointer(angle), len(angle), ffi.NULL, ffi.NULL,
                                 pointer(uncut), pointer(work), len(work)))
        errors.append([space.track.a[0][stop.after] - truth[stop.after], uncut[0] - truth[stop.after]])
    return np.array(errors).T


@pytest.mark.parametrize("effects", [[], [STICTION]])
def test_the_first_row_after_a_stop_is_nearer_to_the_true_motion(effects, tmp_path):
    """Where friction lets a joint go, its acceleration rises within a few samples."""
    ours, plain = first_rows(tmp_path, effects)
    assert len(ours) > 100
    rms = lambda error: np.sqrt(np.mean(np.square(error)))
    assert rms(ours) < 0.95 * rms(plain)


STOP = (20, 26, 0.0812)  # last row before, first row after, instant of rest


def bridged(column, stops, t):
    out = np.array(column, float)
    lib.tl_bridge_stops(ffi.new("tl_stop[]", stops), len(stops), pointer(t), len(t), pointer(out))
    return out


def test_a_bridge_begins_and_ends_on_the_lines_through_the_rows_beside_it():
    rng = np.random.default_rng(4)
    t = np.arange(60) * 0.004 + rng.uniform(-3e-4, 3e-4, 60)
    column = rng.standard_normal(60)
    before, after, begin_s = STOP
    near = [np.flatnonzero((t <= t[before]) & (t > t[before] - 0.018)), np.flatnonzero((t >= t[after]) & (t < t[after] + 0.018))]
    left, right = (np.polyval(np.polyfit(t[i], column[i], 1), t[row]) for i, row in zip(near, (before, after)))
    share = (np.clip(t[before + 1:after] - begin_s, 0, None) / (t[after] - begin_s)) ** 2
    want = column.copy()
    want[before + 1:after] = (1 - share) * left + share * right
    np.testing.assert_allclose(bridged(column, [STOP], t), want, atol=1e-12)


def test_a_bridge_does_not_reach_over_its_neighbours_nor_touch_a_hold():
    t = np.arange(80) * 0.004
    column = np.where(np.arange(80) < 17, 100.0, np.where(np.arange(80) > 29, -100.0, 1.0))
    column[27:30] = 3.0
    crowded = [(10, 17, t[10]), STOP, (29, 36, t[29])]  # rows 17 to 20 and 26 to 29 are the middle one's
    out = bridged(column, crowded, t)
    assert np.all((out[21:26] >= 0.0) & (out[21:26] <= 3.0))
    hold, no_row = (20, 60, t[20]), 2**64 - 1
    assert np.array_equal(bridged(column, [hold], t), column)
    assert np.array_equal(bridged(column, [(no_row, 5, t[0]), (70, no_row, t[70])], t), column)


def test_slip_passes_from_sign_to_sign_through_a_short_stop_and_fades_in_a_hold():
    t = np.arange(1000) * 0.004
    x, v, _ = decelerate_rest_leave(t, rest=(1.0, 1.06))
    slip = talus.Regression(slider_model(), slider_recording(t, x)).motion()["slip"][0]
    assert np.all(slip[t < 0.98] == 1.0) and np.all(slip[t > 1.08] == -1.0)
    middle = np.argmin(np.abs(t - 1.03))
    assert abs(slip[middle]) < 0.25 and np.all(np.diff(slip) <= 1e-12)
    x, v, _ = decelerate_rest_leave(t, rest=(1.0, 3.0))
    slip = talus.Regression(slider_model(), slider_recording(t, x)).motion()["slip"][0]
    assert np.all(slip[(t > 1.08) & (t < 2.92)] == 0.0) and np.all(slip[t > 3.05] == -1.0)


@pytest.mark.parametrize("begin", [1.0, 1.0013, 1.0027, 1.0039])
def test_the_instant_of_rest_is_found_between_samples(begin):
    t = np.arange(500) * 0.004
    x, *_ = decelerate_rest_leave(t, rest=(begin, begin + 0.05))
    regression = talus.Regression(slider_model(), slider_recording(t, x))
    space, _alive = regression._segment(0, 500, with_rows=False)
    assert space.track.stops[0] == 1
    assert abs(space.track.stop[0][0].begin_s - begin) < 0.5e-3


def test_motion_of_the_legs_ankle_comes_through_the_linkage():
    model = talus.Model.from_tree(leg_tree())
    t = np.arange(2000) * 0.004
    q, v, a = 0.2 * np.sin(3 * t), 0.6 * np.cos(3 * t), -1.8 * np.sin(3 * t)
    transmission = ffi.addressof(model.struct.drive[1], "transmission")
    motor = np.array([lib.tl_transmission_motor_angle(transmission, x) for x in q])
    knee = 0.3 * np.sin(2 * t)
    columns = {"time_s": t, "knee_motor_rad": 51 * knee, "ankle_motor_rad": motor, "ankle_joint_rad": q,
               "knee_current_A": 0 * t, "ankle_current_A": 0 * t}
    motion = talus.Regression(model, talus.Recording(columns)).motion()
    inner = (np.abs(v) > 0.05) & (t > 0.1) & (t < 7.9)
    assert np.max(np.abs(motion["q"][1] - q)[inner]) < 1e-9
    assert np.max(np.abs(motion["v"][1] - v)[inner]) < 1e-6
    assert np.max(np.abs(motion["a"][1] - a)[inner]) < 2e-3
    inner = (np.abs(np.cos(2 * t)) > 0.1) & (t > 0.1) & (t < 7.9)
    assert np.max(np.abs(motion["a"][0] + 1.2 * np.sin(2 * t))[inner]) < 2e-3


def pendulum_model(gravity_moment_kg_m):
    return talus.Model.from_tree({
        "plant": "pendulum", "gravity_m_s2": 9.81, "inertia_kg_m2": 1.0, "gravity_moment_kg_m": gravity_moment_kg_m,
        "gravity_zero_rad": 0.0, "joint": {"transmission": {"type": "fixed", "ratio": 1}, "torque_constant_Nm_A": 1.0,
                                           "friction": {"coulomb_Nm": 1.0, "viscous_Nms_rad": 1.0}}})


def velocity_regression(t, v, gravity_moment_kg_m):
    """Of a recording that has the velocity alone."""
    columns = {"time_s": t, "joint_velocity_rad_s": v, "joint_torque_Nm": 0 * t}
    recording = talus.Recording(columns, {"lowpass_hz": 10.0, "order": 2, "standstill": 0.05})
    return talus.Regression(pendulum_model(gravity_moment_kg_m), recording)


def test_a_velocity_column_alone_serves():
    t = np.arange(2000) * 0.01
    v, a = 2 * np.sin(2 * t), 4 * np.cos(2 * t)
    regression = velocity_regression(t, v, 1.0)
    motion = regression.motion()
    assert np.max(np.abs(motion["v"][0] - v)) < 1e-2 and np.max(np.abs(motion["a"][0] - a)[5:-5]) < 0.02
    assert regression.struct.model.gravity_m_s2 == 0.0  # gravity needs an angle


def test_one_noisy_row_of_a_recorded_velocity_does_not_turn_its_friction():
    """Runs of 0.4 rad/s, whose middle rows are outliers of the other sign; nothing is bridged: a velocity runs on."""
    t = np.arange(2000) * 0.01
    truth = 0.4 * np.tanh(6 * np.sin(np.pi * t))
    v = truth + np.random.default_rng(1).normal(0, 0.005, len(t))
    v[50::100] = -0.5 * truth[50::100]
    regression = velocity_regression(t, v, 0.0)
    slip, inside = regression.motion()["slip"][0], (t % 1.0 > 0.15) & (t % 1.0 < 0.85)
    assert np.array_equal(slip[inside], np.sign(truth)[inside])
    space, _alive = regression._segment(0, len(t))
    raw = np.frombuffer(ffi.buffer(space.raw[0] + 4 * space.capacity, 8 * len(t)))
    assert np.array_equal(raw, slip)  # Coulomb's column


def test_noise_and_resolution_are_measured():
    rng = np.random.default_rng(3)
    t = np.arange(4000) * 0.004 + rng.uniform(-3e-4, 3e-4, 4000)
    x = 0.5 * np.sin(3 * t) + 0.2 * np.sin(7 * t)
    found = sensing(t, x + 1e-3 * rng.standard_normal(4000))
    assert found["noise"] == pytest.approx(1e-3, rel=0.1)
    assert found["order"] == 5 and found["window_s"] == pytest.approx(8.5 * 0.004, rel=1e-3)
    found = sensing(t, np.round(x / 2e-4) * 2e-4)
    assert found["step"] == pytest.approx(2e-4, rel=1e-6)
    assert found["noise"] == pytest.approx(2e-4 / np.sqrt(12), rel=0.25)


def test_a_noisier_angle_takes_a_longer_look_for_stops():
    rng = np.random.default_rng(4)
    t = np.arange(3000) * 0.004
    x = 0.5 * np.sin(2 * t)
    calm = sensing(t, x + 1e-7 * rng.standard_normal(3000))
    loud = sensing(t, x + 2e-4 * rng.standard_normal(3000))
    assert calm["quick_s"] < loud["quick_s"]
    assert calm["standstill"] == 0.008 and loud["standstill"] > 0.008


def leg_tree():
    return {
        "plant": "leg", "gravity_m_s2": 9.81,
        "shank": {"length_m": 0.3615, "mass_kg": 1.624, "com_m": 0.160, "inertia_kg_m2": 0.0420},
        "foot": {"mass_kg": 0.442, "com_m": 0.055, "inertia_kg_m2": 0.0021},
        "ankle_motor": {"mass_kg": 0.4112, "com_m": 0.120},
        "knee": {"transmission": {"type": "fixed", "ratio": 51}, "torque_constant_Nm_A": 0.1031,
                 "friction": {"coulomb_Nm": 1.2, "viscous_Nms_rad": 0.45}},
        "ankle": {"transmission": {"type": "screw_linkage", "lead_m": 0.002, "AB_m": 0.090, "BO_m": 0.040,
                                   "AC_m": 0.035, "BOF_deg": 84.75},
                  "torque_constant_Nm_A": 0.1031, "rotor_inertia_kg_m2": 2.4e-6,
                  "friction": {"coulomb_Nm": 0.8, "viscous_Nms_rad": 0.30}},
    }
