"""lib/score.c against the scoring rule written in SciPy."""

import numpy as np
import pytest
from scoring_reference import score as reference
from talus import check, ffi, lib, pointer


def settings(**changes):
    s = ffi.new("tl_score_settings *", lib.tl_score_defaults())
    for name, value in changes.items():
        setattr(s, name, value)
    return s


def score(t, y, yhat, speed, valid=None, **changes):
    n = len(t)
    work = np.empty(lib.tl_score_workspace(n))
    out = ffi.new("tl_score_result *")
    mask = ffi.NULL if valid is None else ffi.from_buffer("uint8_t[]", np.ascontiguousarray(valid, dtype=np.uint8))
    check(lib.tl_score(settings(**changes), pointer(t), mask, pointer(y), pointer(yhat), pointer(speed), n,
                       pointer(work), len(work), out))
    return out.residual_rms, out.measured_rms, out.relative_percent, out.reversal_rms


def recording(seed, n=3000, jitter=3e-4, step=0.004):
    rng = np.random.default_rng(seed)
    t = np.arange(n) * step + rng.uniform(-jitter, jitter, n)
    speed = 0.5 * np.sin(2 * np.pi * 0.7 * t) + 0.2 * np.sin(2 * np.pi * 1.9 * t)
    y = np.sign(speed) + speed + 0.05 * rng.standard_normal(n)
    return t, y, np.sign(speed) + 0.9 * speed, speed


@pytest.mark.parametrize("changes", [{}, {"lowpass_hz": 8.0, "order": 2}, {"standstill": 0.0, "guard_s": 0.0},
                                     {"lowpass_hz": 200.0}, {"trim_s": 1.0, "guard_s": 0.05}])
def test_equals_the_rule(changes):
    t, y, yhat, speed = recording(1)
    want = reference(t, y, yhat, speed, **changes)
    assert score(t, y, yhat, speed, **changes) == pytest.approx(want, rel=1e-9, abs=1e-12)


def test_gaps_and_invalid_rows_cut_segments():
    t, y, yhat, speed = recording(2)
    keep = np.ones(len(t), bool)
    keep[1000:1100] = False  # a gap in time
    t, y, yhat, speed = t[keep], y[keep], yhat[keep], speed[keep]
    valid = np.ones(len(t), np.uint8)
    valid[500:530] = 0
    valid[1800:1810] = 0
    valid[1825:1840] = 0  # leaves 15 rows between: too short to score
    assert score(t, y, yhat, speed, valid) == pytest.approx(reference(t, y, yhat, speed, valid), rel=1e-9)


def test_uneven_steps_such_as_2_and_12_ms():
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.choice([0.002, 0.010, 0.012, 0.049], 2000, p=[0.05, 0.85, 0.08, 0.02]))
    speed = np.sin(t)
    y, yhat = np.cos(t), np.cos(t + 0.01)
    changes = {"lowpass_hz": 8.0, "order": 2, "standstill": 0.02}
    assert score(t, y, yhat, speed, **changes) == pytest.approx(reference(t, y, yhat, speed, **changes), rel=1e-9)


@pytest.mark.parametrize("n", [2, 3, 10, 11, 1000, 1001])
def test_median_step(n):
    t = np.cumsum(np.random.default_rng(n).choice([0.001, 0.002, 0.004, 0.0041], n))
    assert lib.tl_median_step(pointer(t), n, pointer(np.empty(n - 1))) == np.median(np.diff(t))


def test_too_short_or_too_little_room():
    t, y, yhat, speed = recording(4, n=100)  # 0.4 s: shorter than three trims
    out, work = ffi.new("tl_score_result *"), np.empty(lib.tl_score_workspace(100))
    call = lambda n, room: lib.tl_score(settings(), pointer(t), ffi.NULL, pointer(y), pointer(yhat), pointer(speed), n,
                                        pointer(work), room, out)
    assert call(100, len(work)) == lib.TL_ERR_TOO_SHORT
    assert call(10, len(work)) == lib.TL_ERR_TOO_SHORT
    assert call(100, 10) == lib.TL_ERR_WORKSPACE
