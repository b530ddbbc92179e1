"""lib/regression.c: scored rows and predictions, against NumPy, SciPy and motions known in closed form."""

import numpy as np
import pytest
import talus
from scipy.signal import butter, filtfilt
from scoring_reference import score as reference_score
from talus import check, ffi, lib
from test_kinematics import leg_tree

PENDULUM = {
    "plant": "pendulum", "gravity_m_s2": 9.81, "inertia_kg_m2": 0.8, "gravity_moment_kg_m": 1.1,
    "gravity_zero_rad": 0.2, "torque_offset_Nm": 0.3,
    "joint": {"transmission": {"type": "fixed", "ratio": 20}, "torque_constant_Nm_A": 0.1,
              "friction": {"coulomb_Nm": 0.9, "viscous_Nms_rad": 0.4}},
}  # fmt: skip


def pendulum_recording(seed=1, n=4000, noise_A=0.0, step=0.004, **more):
    """An analytic motion and the current that the closed-form equation asks for."""
    rng = np.random.default_rng(seed)
    t = np.arange(n) * step + rng.uniform(-3e-4, 3e-4, n)
    w, phase = 2 * np.pi * np.array([0.3, 0.7, 1.3]), rng.uniform(0, 6, 3)
    size = np.array([0.5, 0.25, 0.08])
    q = (size * np.sin(np.outer(t, w) + phase)).sum(1)
    v = (size * w * np.cos(np.outer(t, w) + phase)).sum(1)
    a = -(size * w**2 * np.sin(np.outer(t, w) + phase)).sum(1)
    torque = 0.8 * a + 1.1 * 9.81 * np.sin(q - 0.2) + 0.3 + 0.9 * np.sign(v) + 0.4 * v
    current = torque / 2.0 + noise_A * rng.standard_normal(n)
    return talus.Recording({"time_s": t, "joint_rad": q, "joint_current_A": current, **more}), (q, v, a, torque)


def stacked(parts, column_count):
    x, z, y = [], [], []
    for part in parts:
        keep = part.kind == lib.TL_ROW_SCORED
        dense = np.zeros((keep.sum(), column_count))
        dense[:, part.index] = part.x[keep]
        x.append(dense), z.append(part.target[keep]), y.append(part.measured[keep])
    return np.concatenate(x), np.concatenate(z), np.concatenate(y)


def test_least_squares_on_the_rows_gives_the_pendulum_back():
    model = talus.Model.from_tree(PENDULUM)
    recording, _ = pendulum_recording()
    x, z, _ = stacked(talus.Regression(model, recording).rows()[0], len(model.base))
    found = dict(zip(model.base, np.linalg.lstsq(x, z, rcond=None)[0]))
    want = {"inertia": 0.8, "gravity_sin": 1.1 * np.cos(0.2), "gravity_cos": -1.1 * np.sin(0.2),
            "torque_offset": 0.3, "coulomb": 0.9, "viscous": 0.4}
    for name, value in want.items():
        assert found[name] == pytest.approx(value, rel=5e-3), name


def test_prediction_equals_the_closed_form_away_from_stops():
    model = talus.Model.from_tree(PENDULUM)
    recording, (_, v, a, torque) = pendulum_recording()
    predicted = talus.predict(model, recording)[0]
    away = (np.abs(v) > 0.02) & (recording.t > 0.1) & (recording.t < recording.t[-1] - 0.1)
    assert np.max(np.abs(predicted - torque)[away]) < 2e-3 * np.max(np.abs(torque))


def test_rows_carry_the_same_error_as_the_scoring_rule_on_the_predictions():
    model = talus.Model.from_tree(PENDULUM)
    valid = np.ones(4000)
    valid[1500:1550] = 0
    recording, _ = pendulum_recording(noise_A=0.05, valid=valid)
    regression = talus.Regression(model, recording)
    base = np.array(list(model.base.values())) * 1.1
    predicted, speed = regression.predict(base)[0], np.nan_to_num(regression.motion()["speed"][0])
    want = reference_score(recording.t, 2.0 * recording.columns["joint_current_A"], predicted, speed, valid)
    x, z, y = stacked(regression.rows()[0], len(base))
    rms = lambda e: float(np.sqrt(np.mean(e**2)))
    assert rms(z - x @ base) == pytest.approx(want[0], rel=1e-9)
    assert rms(y) == pytest.approx(want[1], rel=1e-9)


@pytest.mark.parametrize("plant", ["pendulum", "leg"])
def test_rows_do_not_depend_on_where_the_recording_is_cut(plant):
    if plant == "pendulum":
        model, (recording, _) = talus.Model.from_tree(PENDULUM), pendulum_recording()
    else:
        model, recording = talus.Model.from_tree(leg_tree()), leg_recording()
    regression = talus.Regression(model, recording)
    whole = regression.rows()
    t, struct = recording.t, regression.struct
    margin = lib.tl_regression_margin_s(struct)
    space, _alive = regression._space(len(t), t[-1] - t[0])
    cuts = [0, 700, 701, 1900, 2600, len(t)]
    pieces = [[] for _ in model.joints]
    for begin, end in zip(cuts[:-1], cuts[1:]):
        first = int(np.searchsorted(t, t[begin] - margin))
        last = int(np.searchsorted(t, t[end - 1] + margin))
        until = t[end] if end < len(t) else float("inf")
        span = ffi.new("tl_span *", [t[0], t[-1], t[begin], until])
        check(lib.tl_regression_block(struct, recording.block(first, last), span, space))
        for joint, parts in enumerate(pieces):
            parts.append(regression._copy_rows(space.rows[joint]))
    for joint, parts in enumerate(pieces):
        joined, want = np.concatenate([p.x for p in parts]), whole[joint][0]
        assert np.array_equal(np.concatenate([p.kind for p in parts]), want.kind)
        assert np.max(np.abs(joined - want.x)) < 1e-11 * np.max(np.abs(want.x))
        assert np.max(np.abs(np.concatenate([p.target for p in parts]) - want.target)) < 1e-11


def test_short_stops_are_bridged_and_torque_stays_continuous():
    """Where a joint reverses with a rest of 40 ms the prediction passes from side to side without a jump."""
    t = np.arange(1000) * 0.004
    before, after = np.minimum(t - 2.0, 0), np.maximum(t - 2.04, 0)
    q = -3.0 * before**2 * 0.5 - 3.0 * after**2 * 0.5
    model = talus.Model.from_tree(PENDULUM)
    recording = talus.Recording({"time_s": t, "joint_rad": q, "joint_current_A": 0 * t})
    predicted = talus.predict(model, recording)[0]
    inside = (t > 1.9) & (t < 2.15)
    # coming in: inertia -3 J, friction +Fc; going out: -3 J, -Fc. One ramp of 2 Fc over about ten samples
    assert np.max(np.abs(np.diff(predicted[inside]))) < 0.5 * 2 * 0.9
    assert predicted[t < 1.98][-1] - predicted[t > 2.07][0] == pytest.approx(2 * 0.9, rel=0.15)


def test_with_a_load_sensor_current_is_the_input():
    model = talus.Model.from_tree(PENDULUM)
    recording, (q, v, a, torque) = pendulum_recording()
    load = 0.5 * np.sin(recording.t)
    columns = {**recording.columns, "joint_load_Nm": load, "joint_current_A": (torque + load) / 2.0}
    predicted = talus.predict(model, talus.Recording(columns))[0]
    away = (np.abs(v) > 0.02) & (recording.t > 0.1) & (recording.t < recording.t[-1] - 0.1)
    assert np.max(np.abs(predicted - load)[away]) < 2e-3 * np.max(np.abs(torque))


def test_target_and_columns_pass_the_same_filter():
    model = talus.Model.from_tree(PENDULUM)
    recording, _ = pendulum_recording(noise_A=0.1)
    part = talus.Regression(model, recording).rows()[0][0]
    numerator, denominator = butter(4, 2 * 30 * recording.step_s)
    grid = np.arange(recording.t[0], recording.t[-1], recording.step_s)
    torque = np.interp(grid, recording.t, 2.0 * recording.columns["joint_current_A"])
    want = filtfilt(numerator, denominator, torque, padlen=60)
    assert len(part.t) == len(grid) and np.allclose(part.t, grid)
    assert np.max(np.abs(part.measured - want)) < 1e-9 * np.max(np.abs(want))


def leg_recording(seed=2, n=4000, step=0.004):
    """Two joints moving along sines; currents are not consistent with any model and need not be."""
    rng = np.random.default_rng(seed)
    t = np.arange(n) * step + rng.uniform(-3e-4, 3e-4, n)
    knee, ankle = 0.4 * np.sin(4 * t) + 0.1 * np.sin(9 * t), 0.25 * np.sin(5 * t + 1)
    model = talus.Model.from_tree(leg_tree())
    transmission = ffi.addressof(model.struct.drive[1], "transmission")
    motor = np.array([lib.tl_transmission_motor_angle(transmission, x) for x in ankle])
    current = rng.standard_normal((2, n))
    return talus.Recording({"time_s": t, "knee_motor_rad": 51 * knee, "ankle_motor_rad": motor,
                            "ankle_joint_rad": ankle, "knee_current_A": current[0], "ankle_current_A": current[1]})


def test_leg_prediction_is_inverse_dynamics_of_the_reconstructed_motion():
    model, recording = talus.Model.from_tree(leg_tree()), leg_recording()
    regression = talus.Regression(model, recording)
    motion, predicted = regression.motion(), regression.predict(model.base)
    torque = model.inverse(motion["q"], motion["v"], motion["a"], motion["slip"])
    sliding = np.all(np.abs(motion["v"]) > 0.05, axis=0)
    assert np.max(np.abs(predicted - torque)[:, sliding]) < 1e-12 * np.max(np.abs(torque)) * 100


def test_impossible_calls_are_refused():
    model = talus.Model.from_tree(PENDULUM)
    recording, _ = pendulum_recording()
    struct = ffi.new("tl_regression *")
    time_only = 1 << lib.TL_CHANNEL_TIME
    call = lambda recorded, step: lib.tl_regression_init(struct, model.struct, recorded, recording.score, step)
    assert call(time_only, 0.004) == lib.TL_ERR_UNSUPPORTED
    assert call(recording.recorded, 0.0) == lib.TL_ERR_RANGE
    regression = talus.Regression(model, recording)
    space, _alive = regression._space(100, 1.0)
    span = ffi.new("tl_span *", [recording.t[0], recording.t[-1], recording.t[0], float("inf")])
    assert lib.tl_regression_block(regression.struct, recording.block(0, 4000), span, space) == lib.TL_ERR_WORKSPACE
    assert lib.tl_regression_block(regression.struct, recording.block(0, 10), span, space) == lib.TL_ERR_TOO_SHORT
