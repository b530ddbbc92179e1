"""lib/gap/recording.c: a recording prepared for diagnosis, against the streamed regression and SciPy."""

import numpy as np
import pytest
import talus
from scipy.signal import butter, filtfilt
from talus import check, ffi, lib, pointer
from test_kinematics import leg_tree
from test_regression import PENDULUM, leg_recording, pendulum_recording


def prepare(model, recording, size=200_000_000):
    regression = talus.Regression(model, recording)
    memory = np.empty(size // 8)
    arena, out = ffi.new("tl_arena *"), ffi.new("tl_gap_recording *")
    lib.tl_arena_init(arena, pointer(memory), size)
    valid = ffi.NULL if recording.valid is None else pointer((recording.valid != 0).astype(np.uint8))
    block = recording.block(0, len(recording.t))
    status = lib.tl_gap_prepare(out, regression.struct, block, valid, arena)
    return status, out, regression, (memory, arena, block)


def array(address, n):
    return np.frombuffer(ffi.buffer(address, 8 * n))


def with_invalid_rows(recording, *ranges):
    valid = np.ones(len(recording.t))
    for begin, end in ranges:
        valid[begin:end] = 0
    return talus.Recording({**recording.columns, "valid": valid})


@pytest.mark.parametrize("plant", ["pendulum", "leg", "pendulum in pieces"])
def test_rows_and_motion_are_those_of_the_regression(plant):
    if plant == "leg":
        model, recording = talus.Model.from_tree(leg_tree()), leg_recording()
    else:
        model, (recording, _) = talus.Model.from_tree(PENDULUM), pendulum_recording()
    if plant == "pendulum in pieces":
        recording = with_invalid_rows(recording, (700, 750), (2000, 2400))
    status, out, regression, _alive = prepare(model, recording)
    check(status)
    rows, motion = regression.rows(), regression.motion()
    assert out.segments == len(rows[0]) and out.n == len(recording.t)
    for joint in range(len(model.joints)):
        want = np.concatenate([part.x for part in rows[joint]])
        assert out.m == len(want)
        assert np.array_equal(array(out.x[joint], out.m * out.columns[joint]).reshape(-1, out.m).T, want)
        assert np.array_equal(array(out.target[joint], out.m), np.concatenate([p.target for p in rows[joint]]))
        kind = np.frombuffer(ffi.buffer(out.kind[joint], out.m), dtype=np.uint8)
        assert np.array_equal(kind, np.concatenate([p.kind for p in rows[joint]]))
        assert np.allclose(array(out.grid_s, out.m), np.concatenate([p.t for p in rows[joint]]))
        for name in ("q", "v", "a", "slip"):
            assert np.array_equal(array(getattr(out, name)[joint], out.n), np.nan_to_num(motion[name][joint]))


def test_the_operator_makes_the_models_own_columns():
    """The joint's speed, bridged, on the grid and filtered, is the viscous column."""
    model, (recording, _) = talus.Model.from_tree(PENDULUM), pendulum_recording()
    status, out, regression, _alive = prepare(model, recording)
    check(status)
    speed = array(out.v[0], out.n).copy()
    lib.tl_gap_bridge(out, 0, pointer(speed))
    grid = np.empty(out.m)
    lib.tl_gap_resample(out, pointer(speed), pointer(grid))
    lib.tl_gap_lowpass(out, pointer(grid))
    part = regression.rows()[0][0]
    viscous = part.index.index(list(model.base).index("viscous"))
    assert np.array_equal(grid, part.x[:, viscous])


def test_resample_and_filter_against_scipy():
    model, (recording, _) = talus.Model.from_tree(PENDULUM), pendulum_recording()
    _, out, _, _alive = prepare(model, recording)
    x = np.random.default_rng(1).standard_normal(out.n)
    grid = np.empty(out.m)
    lib.tl_gap_resample(out, pointer(x), pointer(grid))
    at = np.arange(recording.t[0], recording.t[-1], recording.step_s)
    assert np.max(np.abs(grid - np.interp(at, recording.t, x))) < 1e-12
    lib.tl_gap_lowpass(out, pointer(grid))
    b, a = butter(4, 60 * recording.step_s)
    assert np.max(np.abs(grid - filtfilt(b, a, np.interp(at, recording.t, x), padlen=60))) < 1e-10


def test_too_little_memory_is_said_and_how_much_is_wanted():
    model, (recording, _) = talus.Model.from_tree(PENDULUM), pendulum_recording()
    status, _, _, (_, arena, _) = prepare(model, recording, size=80_000)
    assert status == lib.TL_ERR_WORKSPACE and arena.wanted > 80_000
    none = with_invalid_rows(recording, (0, 4000))
    regression = talus.Regression(model, recording)
    out = ffi.new("tl_gap_recording *")
    lib.tl_arena_init(arena, ffi.NULL, 0)
    mask = np.zeros(4000, dtype=np.uint8)
    block = none.block(0, 4000)
    assert lib.tl_gap_prepare(out, regression.struct, block, pointer(mask), arena) == lib.TL_ERR_TOO_SHORT


def test_arena_gives_aligned_memory_until_it_is_used_up():
    memory, arena = np.empty(64), ffi.new("tl_arena *")
    lib.tl_arena_init(arena, pointer(memory), 512)
    first, second = (int(ffi.cast("uintptr_t", lib.tl_arena_take(arena, 100))) for _ in range(2))
    assert second - first == 112 and (first - memory.ctypes.data) % 16 == 0
    assert lib.tl_arena_take(arena, 512) == ffi.NULL and arena.used == 224 and arena.wanted == 736
