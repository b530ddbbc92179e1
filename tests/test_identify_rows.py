"""tl_regressor_fold, tl_base_at: a motion in memory against the regressor row by row and numpy.linalg."""

import numpy as np
import pytest
from leg_example import fixed, leg, linkage, table
from talus import TalusError, check, constants, ffi, lib, pointer

NO_ERROR_BEYOND = 1e-13


def pendulum():
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_PENDULUM))
    m.inertia_kg_m2, m.gravity_moment_kg_m, m.gravity_zero_rad, m.torque_offset_Nm = 0.02, 0.15, 0.3, -0.05
    m.drive[0].coulomb_Nm, m.drive[0].viscous_Nms_rad = 0.2, 0.05
    return m


def slider():
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_SLIDER))
    m.mass_kg, m.force_offset_N = 90.0, -3.0
    m.drive[0].coulomb_Nm, m.drive[0].viscous_Nms_rad = 20.0, 200.0
    return m


def paper_leg():
    m = leg()
    m.form = lib.TL_FORM_PAPER
    return m


TABLE, KNOTS = table(linkage(), 200)
MODELS = {
    "leg": leg,
    "leg, fixed ratio": lambda: leg(fixed(60.0)),
    "leg, table": lambda: leg(TABLE),
    "leg, paper": paper_leg,
    "pendulum": pendulum,
    "slider": slider,
}


@pytest.fixture(params=MODELS)
def model(request):
    return MODELS[request.param]()


def motion(m, n, seed=1):
    """Random q, v, a (joints, n), the torques they need, and noise on them."""
    random, joints = np.random.default_rng(seed), lib.tl_joint_count(m)
    q = random.uniform(-0.5, 0.5, (joints, n))
    v, a = random.normal(size=(joints, n)), 10.0 * random.normal(size=(joints, n))
    torque = np.empty((joints, n))
    lib.tl_inverse_batch(m, n, pointer(q), pointer(v), pointer(a), ffi.NULL, pointer(torque))
    return q, v, a, torque + 1e-3 * random.normal(size=(joints, n))


def factors(m):
    joints, index = lib.tl_joint_count(m), ffi.new("int[]", constants.TL_MAX_ROW)
    f = ffi.new("tl_factor[]", joints)
    for j in range(joints):
        check(lib.tl_factor_init(f + j, lib.tl_row_index(m, j, index)))
    return f


def fold(m, f, q, v, a, torque, slip=None):
    check(lib.tl_regressor_fold(m, q.shape[1], pointer(q), pointer(v), pointer(a), pointer(slip), pointer(torque), f))
    return f


def rows_of(m, q, v, a, slip=None):
    """Rows (joints, n, TL_MAX_ROW) and known parts (joints, n) by tl_regressor, one instant at a time."""
    joints, n = q.shape
    row, known = np.zeros((2, constants.TL_MAX_ROW)), np.zeros(2)
    rows, knowns = np.zeros((joints, n, constants.TL_MAX_ROW)), np.zeros((joints, n))
    now = ffi.new("tl_motion *")
    for i in range(n):
        for j in range(joints):
            now.q[j], now.v[j], now.a[j] = q[j, i], v[j, i], a[j, i]
        lib.tl_slip_from_velocity(m, now)
        if slip is not None:
            for j in range(joints):
                now.slip[j] = slip[j, i]
        lib.tl_regressor(m, now, pointer(row), pointer(known))
        rows[:, i], knowns[:, i] = row[:joints], known[:joints]
    return rows, knowns


def triangle(f):
    stride, p = constants.TL_FACTOR_STRIDE, f.columns
    return np.triu(np.frombuffer(ffi.buffer(f.r)).reshape(stride, stride)[: p + 1, : p + 1])


def assert_gram(f, x, target):
    """R'R is X'X over all rows with the target, to rounding."""
    full = np.column_stack([x, target])
    r, size = triangle(f), np.linalg.norm(full, axis=0)
    assert np.abs((r.T @ r - full.T @ full) / np.outer(size, size)).max() <= NO_ERROR_BEYOND


@pytest.mark.parametrize("n", [1, 63, 64, 65, 1000])
@pytest.mark.parametrize("slips", [False, True])
def test_factor_holds_the_rows_of_the_regressor(model, n, slips):
    q, v, a, torque = motion(model, n)
    slip = np.random.default_rng(3).uniform(-1.0, 1.0, q.shape) if slips else None
    f = fold(model, factors(model), q, v, a, torque, slip)
    rows, known = rows_of(model, q, v, a, slip)
    for j in range(len(q)):
        assert f[j].rows == n
        assert_gram(f[j], rows[j, :, : f[j].columns], torque[j] - known[j])
        assert np.array_equal(triangle(f[j]), row_by_row(f[j].columns, rows[j], torque[j] - known[j]))


def row_by_row(columns, rows, target):
    """The factor of the regressor's rows, 64 at a time as the fold takes them: the same bits are wanted."""
    f = ffi.new("tl_factor *")
    check(lib.tl_factor_init(f, columns))
    for first in range(0, len(target), 64):
        part = slice(first, first + 64)
        block = np.ascontiguousarray(np.column_stack([rows[part, :columns], target[part]]).T)
        lib.tl_factor_add(f, pointer(block), block.shape[1], block.shape[1])
    return triangle(f)


def test_least_squares_is_that_of_numpy(model):
    q, v, a, torque = motion(model, 3000)
    f = fold(model, factors(model), q, v, a, torque)
    rows, known = rows_of(model, q, v, a)
    for j in range(len(q)):
        p = f[j].columns
        b = np.empty(p)
        check(lib.tl_factor_solve(f + j, 1e-12, pointer(b), ffi.NULL))
        expected = np.linalg.lstsq(rows[j, :, :p], torque[j] - known[j], rcond=None)[0]
        # the paper's form holds columns that depend on each other: compare what they predict
        assert rows[j, :, :p] @ b == pytest.approx(rows[j, :, :p] @ expected, rel=1e-9, abs=1e-9)


def test_pieces_of_whole_blocks_give_the_same_bits(model):
    """64 instants are folded at a time: cut there, a motion gives the same factor."""
    q, v, a, torque = motion(model, 200)
    whole, parts = fold(model, factors(model), q, v, a, torque), factors(model)
    for piece in (slice(0, 128), slice(128, 200)):
        fold(model, parts, *(np.ascontiguousarray(x[:, piece]) for x in (q, v, a, torque)))
    assert all(np.array_equal(triangle(whole[j]), triangle(parts[j])) for j in range(len(q)))


@pytest.mark.parametrize("far", [3e5, -2e8])
def test_angles_far_from_zero(far):
    """Angles for which sine and cosine need the longer reduction, in between ordinary ones."""
    m = leg(fixed(60.0))
    q, v, a, torque = motion(m, 130)
    q[0, 70] = q[1, 5] = far
    f = fold(m, factors(m), q, v, a, torque)
    rows, known = rows_of(m, q, v, a)
    for j in range(2):
        assert_gram(f[j], rows[j, :, : f[j].columns], torque[j] - known[j])


def test_what_is_not_a_number_comes_through():
    m = leg()
    q, v, a, torque = motion(m, 10)
    q[1, 4] = np.nan
    f = fold(m, factors(m), q, v, a, torque)
    assert np.isnan(triangle(f[1])).any()
    with pytest.raises(TalusError):
        check(lib.tl_factor_solve(f + 1, 1e-12, pointer(np.empty(5)), ffi.NULL))


def test_bad_arguments(model):
    q, v, a, torque = (pointer(x) for x in motion(model, 10))
    f = factors(model)
    assert lib.tl_regressor_fold(model, 0, q, v, a, ffi.NULL, torque, f) == lib.TL_OK and f[0].rows == 0
    for missing in range(7):
        arguments = [model, q, v, a, torque, f]
        if missing < 6:
            arguments[missing] = ffi.NULL
        else:
            check(lib.tl_factor_init(f, 31))
        m, q_, v_, a_, torque_, f_ = arguments
        assert lib.tl_regressor_fold(m, 10, q_, v_, a_, ffi.NULL, torque_, f_) == lib.TL_ERR_ARGUMENT


def test_base_parameters_at_others_than_the_model_s(model):
    """tl_base_at is tl_base_values of a model that has been given the parameters."""
    count = ffi.new("int *")
    lib.tl_parameters(model, count)
    p = np.random.default_rng(5).uniform(0.1, 2.0, count[0])
    at, changed = np.empty(lib.tl_base_count(model)), ffi.new("tl_model *", model[0])
    lib.tl_base_at(model, pointer(p), pointer(at))
    lib.tl_parameters_set(changed, pointer(p))
    values = np.empty_like(at)
    lib.tl_base_values(changed, pointer(values))
    assert np.array_equal(at, values)
    # linear in what it is made of: torque = known + row base at the same instant
    q, v, a, _ = motion(changed, 20)
    torque, index = np.empty_like(q), ffi.new("int[]", constants.TL_MAX_ROW)
    lib.tl_inverse_batch(changed, 20, pointer(q), pointer(v), pointer(a), ffi.NULL, pointer(torque))
    rows, known = rows_of(model, q, v, a)
    for j in range(len(q)):
        n = lib.tl_row_index(model, j, index)
        by_rows = known[j] + rows[j, :, :n] @ at[[index[k] for k in range(n)]]
        assert by_rows == pytest.approx(torque[j], rel=1e-11, abs=1e-11)
