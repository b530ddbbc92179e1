"""lib/signal.c against NumPy's Legendre fits and SciPy's Savitzky-Golay filter."""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.signal import savgol_coeffs, savgol_filter
from talus import check, ffi, lib, pointer


def reconstruct(t, x, order, length_s):
    w = ffi.new("tl_window *", {"order": order, "length_s": length_s})
    out = [np.empty(len(t)) for _ in range(3)]
    work = np.empty(lib.tl_reconstruct_workspace(len(t)))
    check(lib.tl_reconstruct(w, pointer(t), pointer(x), len(t), *map(pointer, out), pointer(work), len(work)))
    return out


def exact_legendre(t, x, order, length_s):
    """The same windows by numpy.polynomial.legendre, one fit a sample."""
    edge = 0.5 * length_s
    half = edge * (1 + 1e-9)
    out = np.empty((3, len(t)))
    for i, at in enumerate(t):
        centre = max(min(at, t[-1] - edge), t[0] + edge)
        rows = np.flatnonzero(np.abs(t - centre) <= half)
        scale = 0.5 * (t[rows[-1]] - t[rows[0]])
        c = legendre.legfit((t[rows] - centre) / scale, x[rows], order)
        u = (at - centre) / scale
        for d in range(3):
            out[d, i] = legendre.legval(u, legendre.legder(c, d) if d else c) / scale**d
    return out


def multisine(t, seed):
    """0.5 rad peak, eight harmonics of 0.25 Hz: angle, velocity, acceleration."""
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, 8)
    w = 2 * np.pi * 0.25 * np.arange(1, 9)
    argument = np.outer(t, w) + phase
    scale = 0.5 / np.max(np.abs(np.sin(argument).sum(1)))
    return scale * np.sin(argument).sum(1), scale * (w * np.cos(argument)).sum(1), -scale * (w**2 * np.sin(argument)).sum(1)


def noisy(seed, n=4000, rate=200.0):
    rng = np.random.default_rng(seed)
    t = np.arange(n) / rate + rng.uniform(-3e-4, 3e-4, n)
    q, v, a = multisine(t, seed)
    return t, q + 1e-4 * rng.standard_normal(n), v, a


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


@pytest.mark.parametrize("order, length_s", [(4, 0.1), (6, 0.255), (20, 1.0)])
def test_jittered_samples_equal_a_fit_at_true_times(order, length_s):
    t, x, v, a = noisy(1, n=900)
    mine, want = reconstruct(t, x, order, length_s), exact_legendre(t, x, order, length_s)
    for d, size in enumerate([1e-12, 1e-10, 1e-8]):
        assert np.max(np.abs(mine[d] - want[d])) < size * (1 + np.max(np.abs(want[d])))


def test_known_multisine_against_exact_fit_and_savgol():
    """Errors at most 1.02 of the exact Legendre fit and half of savgol(51, 6)."""
    t, x, v, a = noisy(7)
    inner = slice(200, -200)
    _, mine_v, mine_a = reconstruct(t, x, 6, 51 / 200.0)
    _, exact_v, exact_a = exact_legendre(t, x, 6, 51 / 200.0)
    savgol_v = savgol_filter(x, 51, 6, deriv=1, delta=1 / 200.0)
    savgol_a = savgol_filter(x, 51, 6, deriv=2, delta=1 / 200.0)
    for mine, exact, savgol, true in ((mine_v, exact_v, savgol_v, v), (mine_a, exact_a, savgol_a, a)):
        error, best, other = (rms((y - true)[inner]) for y in (mine, exact, savgol))
        print(f"error / exact fit {error / best:.4f}, error / savgol {error / other:.3f}")
        assert error <= 1.02 * best
        assert error <= 0.5 * other


@pytest.mark.parametrize("order, samples", [(2, 5), (4, 9), (5, 51)])
def test_even_samples_take_the_same_kernel_as_savgol(order, samples):
    t = np.arange(1200) / 1000.0
    x = np.random.default_rng(samples).standard_normal(1200)
    mine = reconstruct(t, x, order, samples / 1000.0 - 0.0005)
    for d in range(3):
        want = np.convolve(x, savgol_coeffs(samples, order, deriv=d, delta=0.001), mode="valid")
        half = samples // 2
        assert np.max(np.abs(mine[d][half:-half] - want)) < 1e-9 * np.max(np.abs(want))


def test_even_samples_of_high_order_equal_the_legendre_fit():
    t = np.arange(700) / 1000.0
    x = np.random.default_rng(24).standard_normal(700)
    mine, want = reconstruct(t, x, 24, 0.2005), exact_legendre(t, x, 24, 0.2005)
    for d in range(3):
        assert np.max(np.abs(mine[d] - want[d])) < 1e-9 * np.max(np.abs(want[d]))


def test_polynomials_come_back_exactly_even_at_the_ends_and_across_uneven_steps():
    rng = np.random.default_rng(4)
    t = np.cumsum(rng.choice([0.002, 0.010, 0.012], 500))
    c = [0.3, -1.2, 0.7, 0.4, -0.1]
    p = np.polynomial.Polynomial(c)
    for got, want in zip(reconstruct(t, p(t), 4, 0.3), (p(t), p.deriv()(t), p.deriv(2)(t))):
        assert np.max(np.abs(got - want)) < 1e-8 * np.max(np.abs(want))


def test_mixed_even_and_uneven_runs_agree_with_the_fit():
    t = np.concatenate([np.arange(300) * 0.01, 3.0 + np.cumsum(np.full(100, 0.0101)), 4.02 + np.arange(300) * 0.01])
    x = np.sin(3 * t) + 0.01 * np.random.default_rng(5).standard_normal(len(t))
    mine, want = reconstruct(t, x, 3, 0.115), exact_legendre(t, x, 3, 0.115)
    for d in range(3):
        assert np.max(np.abs(mine[d] - want[d])) < 1e-8 * np.max(np.abs(want[d]))


def test_a_window_with_too_few_samples_takes_its_neighbours():
    t = np.arange(50) * 0.01
    p, v, a = reconstruct(t, t**2, 2, 0.0)  # at least order + 1 samples
    assert np.allclose(p, t**2) and np.allclose(v, 2 * t) and np.allclose(a, 2.0)


def test_bad_calls():
    t = np.arange(50) * 0.01
    w = lambda order, length: ffi.new("tl_window *", {"order": order, "length_s": length})
    call = lambda window, n, room: lib.tl_reconstruct(window, pointer(t), pointer(t), n, ffi.NULL, ffi.NULL, ffi.NULL,
                                                      pointer(np.empty(1000)), room)
    assert call(w(1, 0.1), 50, 1000) == lib.TL_ERR_RANGE
    assert call(w(25, 0.1), 50, 1000) == lib.TL_ERR_RANGE
    assert call(w(4, float("nan")), 50, 1000) == lib.TL_ERR_RANGE
    assert call(w(4, 0.1), 4, 1000) == lib.TL_ERR_TOO_SHORT
    assert call(w(4, 0.5), 50, 6) == lib.TL_ERR_WORKSPACE
