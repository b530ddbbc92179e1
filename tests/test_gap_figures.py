"""tools/talus/diagnosis/figures.py: the interval of what will be closed, on blocks of known make."""

from types import SimpleNamespace

import numpy as np
import pytest
from talus.diagnosis import figures

ROWS, BLOCKS, NOISE = 200, 40, 1.0


def blocks(random, count):
    """Residuals before and after of so many blocks: noise, a gap of a strength of its own in each, and what is left of it."""
    gap = np.repeat(3.0 * np.exp(0.5 * random.standard_normal(count)), ROWS) * random.standard_normal(count * ROWS)
    left = np.repeat(0.3 * np.exp(0.5 * random.standard_normal(count)), ROWS) * random.standard_normal(count * ROWS)
    noise = NOISE * random.standard_normal(count * ROWS)
    return gap + noise, left + noise


def dataset(count):
    channel = SimpleNamespace(kind="T0", record=0, rows=np.arange(count * ROWS))
    return SimpleNamespace(channels=[channel], blocks=count, block_of=[np.repeat(np.arange(count), ROWS)], block_record=np.zeros(count, int))


def residuals(values):
    return SimpleNamespace(of={(0, "T0"): values})


def closed(before, after):
    return figures.closed_fraction(np.sqrt(np.mean(before**2)), np.sqrt(np.mean(after**2)), NOISE)


def test_an_unseen_block_closes_within_the_interval():
    """By its binomial deviation, 95 of 100 unseen blocks; the known noise of the interval makes it a little wider."""
    held, tried = 0, 400
    for seed in range(tried):
        random = np.random.default_rng(seed)
        interval = figures.closed_interval(dataset(BLOCKS), *map(residuals, blocks(random, BLOCKS)), 0, NOISE, seed)
        held += interval[0] <= closed(*blocks(random, 1)) <= interval[1]
    assert 0.92 * tried <= held < tried


@pytest.mark.parametrize("floor", [0.5, 1.0, 2.0])
def test_the_interval_holds_the_closed_fraction_itself(floor):
    before, after = blocks(np.random.default_rng(1), BLOCKS)
    whole = figures.closed_fraction(np.sqrt(np.mean(before**2)), np.sqrt(np.mean(after**2)), floor)
    low, high = figures.closed_interval(dataset(BLOCKS), residuals(before), residuals(after), 0, floor, 1)
    assert -1 <= low <= whole <= high <= 1


def test_a_noise_that_is_overrated_does_not_make_the_interval_sure():
    """Of a large gap 0.1 % is left, below a noise that is taken for twice what it is: all seems closed, and less than all may be."""
    before, after = blocks(np.random.default_rng(1), BLOCKS)
    left = np.sqrt(np.mean(after**2))
    true = 1 - (left**2 - NOISE**2) / np.mean((30 * before) ** 2)
    low, high = figures.closed_interval(dataset(BLOCKS), residuals(30 * before), residuals(after), 0, 2 * left, 1)
    assert low < true < 1 and high == 1 and low > 0.99


def test_effects_that_do_harm_may_do_it_again():
    before, after = blocks(np.random.default_rng(1), BLOCKS)
    low, _high = figures.closed_interval(dataset(BLOCKS), residuals(after), residuals(before), 0, 0.5 * NOISE, 1)
    assert -1 <= low < 0


def test_no_rows_tell_nothing():
    assert figures.closed_interval(dataset(0), residuals(np.zeros(0)), residuals(np.zeros(0)), 0, NOISE, 1) == [0.0, 1.0]
