"""talus/random.h: published vectors, and the distributions against SciPy."""

import numpy as np
import pytest
from scipy import stats
from talus import ffi, lib, pointer

# philox4x32, 10 rounds, of the kat_vectors file that comes with Random123
# (Salmon et al. 2011): counter, key, output
KNOWN_ANSWERS = [
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]


@pytest.mark.parametrize("counter, key, expected", KNOWN_ANSWERS)
def test_known_answers(counter, key, expected):
    out = ffi.new("uint32_t[4]")
    lib.tl_philox4x32(ffi.new("uint32_t[4]", counter), ffi.new("uint32_t[2]", key), out)
    assert tuple(out) == expected


def philox_reference(counter, key):
    """Ten rounds as the paper writes them, with Python's integers."""
    c, k = list(counter), list(key)
    for _ in range(10):
        a, b = 0xD2511F53 * c[0], 0xCD9E8D57 * c[2]
        c = [(b >> 32) ^ c[1] ^ k[0], b & 0xFFFFFFFF, (a >> 32) ^ c[3] ^ k[1], a & 0xFFFFFFFF]
        k = [(k[0] + 0x9E3779B9) & 0xFFFFFFFF, (k[1] + 0xBB67AE85) & 0xFFFFFFFF]
    return c


def test_in_place_and_random_blocks():
    random = np.random.default_rng(3)
    for _ in range(200):
        block = random.integers(0, 2**32, 6, dtype=np.uint32)
        expected = philox_reference([int(v) for v in block[:4]], [int(v) for v in block[4:]])
        lib.tl_philox4x32(pointer(block[:4]), pointer(block[4:]), pointer(block[:4]))
        assert block[:4].tolist() == expected


def draw(function, n, seed=5, stream=0):
    drawn = np.empty((n, 2))
    memory = pointer(drawn)
    for i in range(n):
        function(seed, stream, i, memory + 2 * i)
    return drawn


def test_uniform_takes_the_upper_53_bits_of_the_block():
    seed, stream, counter = 0x0123456789ABCDEF, 0xFEDCBA9876543210, 0x1122334455667788
    low = 0xFFFFFFFF
    words = philox_reference(
        (counter & low, counter >> 32, stream & low, stream >> 32), (seed & low, seed >> 32)
    )
    out = ffi.new("double[2]")
    lib.tl_random_uniform2(seed, stream, counter, out)
    assert out[0] == ((words[1] << 32 | words[0]) >> 11) / 2**53
    assert out[1] == ((words[3] << 32 | words[2]) >> 11) / 2**53


SEEDS = range(1, 25)


def assert_like_chance(p_values):
    """p-values of independent samples are uniform themselves, and none is beyond what so many give."""
    p_values = np.asarray(p_values)
    assert stats.kstest(p_values, "uniform").pvalue > 1e-4
    assert p_values.min() > 1e-4 / len(p_values)


def correlation_p_value(a, b):
    return stats.pearsonr(a, b).pvalue


def test_uniform_distribution():
    samples = [draw(lib.tl_random_uniform2, 2_000, seed) for seed in SEEDS]
    assert min(u.min() for u in samples) >= 0.0 and max(u.max() for u in samples) < 1.0
    for column in (0, 1):
        assert_like_chance([stats.kstest(u[:, column], "uniform").pvalue for u in samples])
        assert_like_chance([correlation_p_value(u[:-1, column], u[1:, column]) for u in samples])
    assert_like_chance([correlation_p_value(u[:, 0], u[:, 1]) for u in samples])


def test_normal_distribution():
    samples = [draw(lib.tl_random_normal2, 2_000, seed) for seed in SEEDS]
    for column in (0, 1):
        assert_like_chance([stats.kstest(z[:, column], "norm").pvalue for z in samples])
    # the pair is independent: its angle is uniform, its squared radius exponential
    assert_like_chance([correlation_p_value(z[:, 0], z[:, 1]) for z in samples])
    turns = [np.arctan2(z[:, 1], z[:, 0]) / (2 * np.pi) + 0.5 for z in samples]
    assert_like_chance([stats.kstest(turn, "uniform").pvalue for turn in turns])
    assert_like_chance([stats.kstest((z**2).sum(axis=1) / 2, "expon").pvalue for z in samples])
    # moments of all of them: n = 96,000, each within four of its standard deviations
    pooled = np.concatenate(samples).ravel()
    n = len(pooled)
    assert abs(pooled.mean()) < 4 / np.sqrt(n)
    assert abs(pooled.var() - 1) < 4 * np.sqrt(2 / n)
    assert abs(stats.skew(pooled)) < 4 * np.sqrt(6 / n)
    assert abs(stats.kurtosis(pooled)) < 4 * np.sqrt(24 / n)


def test_normal_is_box_and_muller_of_the_uniform_pair():
    u = draw(lib.tl_random_uniform2, 500)
    radius, angle = np.sqrt(-2 * np.log1p(-u[:, 0])), 2 * np.pi * u[:, 1]
    expected = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    np.testing.assert_allclose(draw(lib.tl_random_normal2, 500), expected, rtol=1e-12, atol=1e-14)


def test_seed_stream_and_counter_each_change_the_numbers():
    def first(seed, stream, counter):
        out = ffi.new("double[2]")
        lib.tl_random_uniform2(seed, stream, counter, out)
        return out[0]

    base = (1, 2, 3)
    values = {first(*base)}
    for place in range(3):
        for bit in (0, 31, 32, 63):
            changed = list(base)
            changed[place] ^= 1 << bit
            values.add(first(*changed))
    assert len(values) == 13
    assert first(*base) == first(*base)
