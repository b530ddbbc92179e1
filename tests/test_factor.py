"""talus/factor.h against numpy.linalg: streamed least squares and the small SVD."""

import numpy as np
import pytest
from talus import check, constants, ffi, lib, pointer

EPS = np.finfo(float).eps


def rows(x, z):
    """Column-major block (x | z), as tl_factor_add takes it; it is overwritten."""
    return np.asfortranarray(np.column_stack([x, z])).T.copy()


def add(f, x, z, stride_more=0):
    block = rows(x, z)
    n = block.shape[1]
    padded = np.full((block.shape[0], n + stride_more), np.nan)  # what lies between is not read
    padded[:, :n] = block
    lib.tl_factor_add(f, pointer(padded), n, n + stride_more)


def factor_of(x, z, pieces=1):
    f = ffi.new("tl_factor *")
    check(lib.tl_factor_init(f, x.shape[1]))
    for part in np.array_split(np.arange(len(z)), pieces):
        add(f, x[part], z[part])
    return f


def triangle(f):
    stride, p = constants.TL_FACTOR_STRIDE, f.columns
    r = np.frombuffer(ffi.buffer(f.r), dtype=float).reshape(stride, stride)[: p + 1, : p + 1]
    return np.triu(r)


def solve(f, tolerance=1e-12):
    b, rank = np.empty(f.columns), ffi.new("int *")
    check(lib.tl_factor_solve(f, tolerance, pointer(b), rank))
    return b, rank[0]


def covariance(f, tolerance=1e-12):
    c = np.empty((f.columns, f.columns))
    check(lib.tl_factor_covariance(f, tolerance, pointer(c)))
    return c


def problem(n, p, seed=0, noise=0.1):
    random = np.random.default_rng(seed)
    x = random.normal(size=(n, p))
    return x, x @ random.normal(size=p) + noise * random.normal(size=n)


@pytest.mark.parametrize("n, p", [(50, 1), (7, 6), (1000, 6), (257, 9), (5000, 32), (3, 9)])
def test_triangle_is_that_of_a_qr_of_all_rows(n, p):
    x, z = problem(n, p)
    full = np.column_stack([x, z])
    r = triangle(factor_of(x, z))
    assert (np.diag(r) >= 0).all()
    # R'R = A'A decides R up to the signs of its rows
    np.testing.assert_allclose(
        r.T @ r, full.T @ full, rtol=0, atol=20 * n * EPS * np.abs(full.T @ full).max()
    )
    if n > p:
        expected = np.linalg.qr(full, mode="r")
        expected *= np.sign(np.diag(expected))[:, None]
        np.testing.assert_allclose(r, expected, rtol=0, atol=1e-11 * np.linalg.norm(full))


@pytest.mark.parametrize("n, p", [(60, 1), (1000, 6), (300, 9), (2000, 32)])
def test_solution_covariance_and_cost_against_lstsq(n, p):
    x, z = problem(n, p, seed=p)
    f = factor_of(x, z)
    b, rank = solve(f)
    expected, residual, expected_rank, _ = np.linalg.lstsq(x, z, rcond=None)
    assert rank == expected_rank == p and f.rows == n
    np.testing.assert_allclose(b, expected, rtol=1e-11, atol=1e-12)
    assert lib.tl_factor_cost(f, pointer(b)) == pytest.approx(residual[0], rel=1e-11)
    np.testing.assert_allclose(covariance(f), np.linalg.inv(x.T @ x), rtol=1e-9, atol=1e-14)


def test_cost_is_the_residual_of_all_rows_anywhere():
    x, z = problem(700, 6, seed=3)
    f = factor_of(x, z, pieces=4)
    for b in np.random.default_rng(1).normal(0, 3, (20, 6)):
        assert lib.tl_factor_cost(f, pointer(b)) == pytest.approx(np.sum((x @ b - z) ** 2), rel=1e-12)


def test_cost_keeps_its_digits_without_noise():
    # |z|^2 is about 3e4 and the cost 4e-15: a Gram matrix, which subtracts numbers of the first
    # size, would leave 1e-12 and no digit of it
    x, z = problem(4000, 6, seed=4, noise=0.0)
    true = np.linalg.lstsq(x, z, rcond=None)[0]
    z = z + 1e-9 * np.random.default_rng(5).normal(size=4000)
    b, _ = solve(factor_of(x, z))
    cost = lib.tl_factor_cost(factor_of(x, z), pointer(b))
    assert cost == pytest.approx(np.sum((x @ np.linalg.lstsq(x, z, rcond=None)[0] - z) ** 2), rel=1e-5)
    np.testing.assert_allclose(b, true, rtol=1e-9)


def test_excess_is_the_cost_above_its_least_to_the_last_digits():
    x, z = problem(4000, 6, seed=11, noise=1.0)
    f = factor_of(x, z)
    b, _ = solve(f)
    least = lib.tl_factor_cost(f, pointer(b))
    for size in (1.0, 1e-4, 1e-8, 1e-10):
        step = size * np.random.default_rng(12).normal(size=6)
        # |X (b + step) - z|^2 - |X b - z|^2 = |X step|^2, which the cost itself could not show below 1e-8
        assert lib.tl_factor_excess(f, pointer(b + step)) == pytest.approx(np.sum((x @ step) ** 2), rel=1e-4)
        assert lib.tl_factor_cost(f, pointer(b + step)) == pytest.approx(
            least + np.sum((x @ step) ** 2), rel=1e-12
        )


@pytest.mark.parametrize("pieces", [2, 7, 50, 1000])
def test_split_into_chunks_gives_the_same_triangle(pieces):
    x, z = problem(1000, 6, seed=6)
    whole, split = factor_of(x, z), factor_of(x, z, pieces)
    assert split.rows == whole.rows == 1000
    np.testing.assert_allclose(triangle(split), triangle(whole), rtol=0, atol=1e-12 * np.linalg.norm(x))
    np.testing.assert_allclose(solve(split)[0], solve(whole)[0], rtol=1e-12, atol=1e-13)


def test_stride_larger_than_the_block_and_no_rows():
    x, z = problem(100, 4)
    plain, padded = factor_of(x, z), factor_of(x[:0], z[:0])
    add(padded, x, z, stride_more=5)
    assert np.array_equal(triangle(padded), triangle(plain))
    lib.tl_factor_add(padded, ffi.NULL, 0, 0)
    assert padded.rows == 100 and np.array_equal(triangle(padded), triangle(plain))


def scaled_minimum_norm(x, z, rcond):
    length = np.linalg.norm(x, axis=0)
    length[length == 0] = 1
    return np.linalg.lstsq(x / length, z, rcond=rcond)[0] / length


def test_rank_deficient_gives_the_minimum_norm_solution():
    x, z = problem(400, 5, seed=8)
    x = np.column_stack([x, x[:, 0] + 2 * x[:, 1], np.zeros(400)])
    f = factor_of(x, z)
    b, rank = solve(f)
    assert rank == 5 and b[6] == 0.0
    np.testing.assert_allclose(b, scaled_minimum_norm(x, z, 1e-12), rtol=1e-10, atol=1e-12)
    # on the kept directions the covariance is the pseudo-inverse
    length = np.where(np.linalg.norm(x, axis=0) > 0, np.linalg.norm(x, axis=0), 1.0)
    expected = np.linalg.pinv((x / length).T @ (x / length), rcond=1e-10) / np.outer(length, length)
    np.testing.assert_allclose(covariance(f), expected, rtol=1e-8, atol=1e-14)
    assert (covariance(f)[6] == 0).all()


def test_columns_of_very_different_scale():
    random = np.random.default_rng(9)
    scale = 10.0 ** np.array([8, -8, 0, 4, -4, 8])
    x, z = problem(800, 6, seed=9)
    b, rank = solve(factor_of(x * scale, z))
    expected = np.linalg.lstsq(x, z, rcond=None)[0] / scale
    assert rank == 6
    np.testing.assert_allclose(b, expected, rtol=1e-11)
    # and rows of very different weight, the heavy ones last
    weight = 10.0 ** random.uniform(-8, 0, 800)
    weight.sort()
    b, _ = solve(factor_of(x * weight[:, None], z * weight, pieces=11))
    expected = np.linalg.lstsq(x * weight[:, None], z * weight, rcond=None)[0]
    np.testing.assert_allclose(b, expected, rtol=1e-9)


def test_tolerance_decides_the_rank():
    random = np.random.default_rng(10)
    x = random.normal(size=(300, 4))
    x[:, 3] = x[:, 2] + 1e-6 * random.normal(size=300)
    z = random.normal(size=300)
    f = factor_of(x, z)
    assert solve(f, 1e-9)[1] == 4 and solve(f, 1e-4)[1] == 3
    np.testing.assert_allclose(solve(f, 1e-9)[0], np.linalg.lstsq(x, z, rcond=None)[0], rtol=1e-7)
    np.testing.assert_allclose(solve(f, 1e-4)[0], scaled_minimum_norm(x, z, 1e-4), rtol=1e-7)


def test_merge_is_the_stacked_problem():
    # a joint sees some of the common parameters; its rows count with a weight
    parts = [([0, 2, 3], 0.5), ([3, 1, 4, 0], 7.0), ([4], 1e-3)]
    total = ffi.new("tl_factor *")
    check(lib.tl_factor_init(total, 5))
    stacked_x, stacked_z = [], []
    for seed, (index, weight) in enumerate(parts):
        x, z = problem(90 + seed, len(index), seed=seed)
        lib.tl_factor_merge(total, factor_of(x, z), ffi.new("int[]", index), weight)
        wide = np.zeros((len(z), 5))
        wide[:, index] = x
        stacked_x.append(weight * wide)
        stacked_z.append(weight * z)
    x, z = np.concatenate(stacked_x), np.concatenate(stacked_z)
    assert total.rows == len(z)
    np.testing.assert_allclose(solve(total)[0], np.linalg.lstsq(x, z, rcond=None)[0], rtol=1e-10)
    b = np.arange(5.0)
    assert lib.tl_factor_cost(total, pointer(b)) == pytest.approx(np.sum((x @ b - z) ** 2), rel=1e-12)


def test_rows_of_zeros_and_an_empty_factor():
    x, z = problem(50, 3)
    f = factor_of(x, z)
    before = triangle(f).copy()
    add(f, np.zeros((10, 3)), np.zeros(10))
    assert np.array_equal(triangle(f), before) and f.rows == 60
    empty = factor_of(x[:0], z[:0])
    b, rank = solve(empty)
    assert rank == 0 and (b == 0).all() and (covariance(empty) == 0).all()
    assert lib.tl_factor_cost(empty, pointer(np.ones(3))) == 0.0
    b, rank = solve(factor_of(np.zeros((10, 3)), np.ones(10)))
    assert rank == 0 and (b == 0).all()


def test_refusals():
    f = ffi.new("tl_factor *")
    for columns in (0, -1, constants.TL_FACTOR_MAX + 1):
        assert lib.tl_factor_init(f, columns) == lib.TL_ERR_ARGUMENT
    assert lib.tl_factor_init(ffi.NULL, 3) == lib.TL_ERR_ARGUMENT
    x, z = problem(20, 3)
    good = factor_of(x, z)
    b = np.full(3, 7.0)
    for tolerance in (-1.0, np.nan):
        assert lib.tl_factor_solve(good, tolerance, pointer(b), ffi.NULL) == lib.TL_ERR_ARGUMENT
        assert lib.tl_factor_covariance(good, tolerance, pointer(np.empty(9))) == lib.TL_ERR_ARGUMENT
    assert lib.tl_factor_solve(good, 0.0, ffi.NULL, ffi.NULL) == lib.TL_ERR_ARGUMENT
    x[4, 1] = np.nan
    assert lib.tl_factor_solve(factor_of(x, z), 1e-12, pointer(b), ffi.NULL) == lib.TL_ERR_NOT_FINITE
    assert lib.tl_factor_covariance(factor_of(x, z), 1e-12, pointer(np.empty(9))) == lib.TL_ERR_NOT_FINITE
    x[4, 1], z[3] = 1.0, np.inf
    assert lib.tl_factor_solve(factor_of(x, z), 1e-12, pointer(b), ffi.NULL) == lib.TL_ERR_NOT_FINITE
    assert (b == 7.0).all()


def svd(a):
    a = np.array(a, dtype=float)
    m, n = a.shape
    us, singular, v = a.copy(), np.empty(n), np.empty((n, n))
    check(lib.tl_svd(pointer(us), m, n, pointer(singular), pointer(v)))
    return us, singular, v


def hilbert(n):
    i = np.arange(n)
    return 1.0 / (i[:, None] + i[None, :] + 1)


MATRICES = {
    "one number": [[-3.0]],
    "one column": [[1.0], [2.0], [-2.0]],
    "tall": np.random.default_rng(1).normal(size=(40, 7)),
    "square": np.random.default_rng(2).normal(size=(32, 32)),
    "orthogonal": np.linalg.qr(np.random.default_rng(3).normal(size=(9, 9)))[0],
    "triangular": np.triu(np.random.default_rng(4).normal(size=(10, 10))),
    "rank 2": np.random.default_rng(5).normal(size=(8, 2)) @ np.random.default_rng(6).normal(size=(2, 6)),
    "ill conditioned": hilbert(8),
    "zeros": np.zeros((5, 3)),
    "equal columns": np.ones((6, 4)),
    "huge": 1e300 * np.random.default_rng(7).normal(size=(5, 5)),
    "tiny": 1e-300 * np.random.default_rng(8).normal(size=(5, 5)),
    "graded": np.random.default_rng(9).normal(size=(6, 6)) * 10.0 ** -np.arange(0, 60, 10),
}


@pytest.mark.parametrize("name", MATRICES)
def test_svd_against_numpy(name):
    a = np.array(MATRICES[name], dtype=float)
    us, singular, v = svd(a)
    n, size = a.shape[1], max(np.abs(a).max(), 1e-307)
    assert (np.diff(singular) <= 0).all() and (singular >= 0).all()
    np.testing.assert_allclose(singular, np.linalg.svd(a, compute_uv=False), rtol=0, atol=50 * EPS * n * size)
    np.testing.assert_allclose(v.T @ v, np.eye(n), atol=50 * EPS)
    # A V = U S, column k of length s_k, columns orthogonal
    np.testing.assert_allclose(us / size, a / size @ v, atol=50 * EPS * n)
    np.testing.assert_allclose(np.linalg.norm(us / size, axis=0), singular / size, atol=50 * EPS * n)
    gram = (us / size).T @ (us / size)
    lengths = np.outer(singular / size, singular / size)
    assert (np.abs(gram - np.diag(np.diag(gram))) <= 1e-13 * lengths + 1e-300).all()


def test_svd_keeps_relative_accuracy_of_small_singular_values():
    # graded columns: one-sided Jacobi finds each singular value to its own last digits (Demmel and
    # Veselic 1992), where a bidiagonal SVD loses those below 1e-16 of the largest; reference in 80 digits
    from mpmath import mp

    a = MATRICES["graded"]
    with mp.workdps(120):
        exact = mp.svd_r(mp.matrix(a.tolist()), compute_uv=False)
        exact = [float(exact[i]) for i in range(len(exact))]
    np.testing.assert_allclose(svd(a)[1], exact, rtol=1e-13)


def test_svd_is_deterministic_and_refuses():
    a = MATRICES["square"]
    first, second = svd(a), svd(a)
    assert all(np.array_equal(x, y) for x, y in zip(first, second))
    out = pointer(np.empty(9))
    square = pointer(np.ones(9))
    assert lib.tl_svd(square, 2, 3, out, out) == lib.TL_ERR_ARGUMENT
    assert lib.tl_svd(square, 3, 0, out, out) == lib.TL_ERR_ARGUMENT
    assert lib.tl_svd(ffi.NULL, 3, 3, out, out) == lib.TL_ERR_ARGUMENT
    for bad in (np.nan, np.inf, -np.inf):
        a = np.ones((3, 3))
        a[1, 2] = bad
        assert lib.tl_svd(pointer(a), 3, 3, out, out) == lib.TL_ERR_NOT_FINITE
