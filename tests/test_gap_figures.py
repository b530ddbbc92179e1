"""tools/talus/diagnosis/figures.py: the intervals of what will be closed, on blocks of known make, and of an effect's size, on errors of known
make."""

from types import SimpleNamespace

import numpy as np
import pytest
import talus
from gap_in_process import recorded
from support import REPOSITORY
from talus.diagnosis import figures
from talus.diagnosis.search import Search, plain_base

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


def test_of_what_is_left_below_an_overrated_noise_any_share_may_be_noise():
    """A fifth of the gap stays, and ten times less noise. The estimate of the noise is half of the gap."""
    random = np.random.default_rng(2)
    gap, rest, noise = (size * random.standard_normal(BLOCKS * ROWS) for size in (1.0, 0.2, 0.02))
    known = dataset(BLOCKS), residuals(gap + rest + noise), residuals(rest + noise), 0
    true = 1 - 0.2**2 / (1 + 0.2**2)
    low, high = figures.closed_interval(*known, 0.5, 1)
    assert low < true < high
    near = figures.closed_interval(*known, 1.1 * np.hypot(0.2, 0.02), 1)  # as much as is left, within a tenth: it may be the noise
    assert true < near[0]


def test_effects_that_do_harm_may_do_it_again():
    before, after = blocks(np.random.default_rng(1), BLOCKS)
    low, _high = figures.closed_interval(dataset(BLOCKS), residuals(after), residuals(before), 0, 0.5 * NOISE, 1)
    assert -1 <= low < 0


@pytest.mark.parametrize("seed", range(5))
def test_what_reconstruction_leaves_too_is_nothing_to_be_closed(seed):
    """Effects close all that they can: what is left beside the noise is as much as without any effect. Where that is known, the interval
    holds all; and it still holds what is closed of what stands above the noise alone."""
    random = np.random.default_rng(seed)
    gap, noise, rest = (size * random.standard_normal(BLOCKS * ROWS) for size in (3.0, NOISE, 2.0))
    found = residuals(gap + noise + rest), residuals(noise + rest)
    alone, whole = (figures.closed_interval(dataset(BLOCKS), *found, 0, NOISE, 1, rough) for rough in (0.0, 2.0**2))
    above_noise = 1 - 2.0**2 / (3.0**2 + 2.0**2)
    assert alone[1] < 0.9 < 0.99 < whole[1]
    assert all(low < above_noise < high for low, high in (alone, whole))


def test_no_rows_tell_nothing():
    assert figures.closed_interval(dataset(0), residuals(np.zeros(0)), residuals(np.zeros(0)), 0, NOISE, 1) == [0.0, 1.0]


# ---- sizes -----------------------------------------------------------------------------------


def fitted(random, stretches, lasting):
    """(strength, its error by stretches, by noise alone) of one column whose true strength is 1, beside a constant: the errors of 50 rows of
    each stretch are `lasting` in part, one for all of them."""
    number = np.repeat(np.arange(stretches), 50)
    x = np.array([np.ones(len(number)), np.repeat(random.standard_normal(stretches), 50) + 0.5 * random.standard_normal(len(number))])
    y = x[1] + lasting * np.repeat(random.standard_normal(stretches), 50) + random.standard_normal(len(number))
    found = np.linalg.lstsq(x.T, y, rcond=None)[0]
    left = y - found @ x
    sums = np.array([np.bincount(number, column * left) for column in x]).T
    rows = np.vstack([x, y])
    gram = SimpleNamespace(gathered=lambda columns: None, products=lambda own: rows @ rows.T, by_stretch=lambda columns: sums)
    search = SimpleNamespace(columns=lambda chosen: None, gram=gram)
    fit = SimpleNamespace(chosen=[SimpleNamespace(columns=[None])])
    return found[1], figures.errors_by_stretch(search, fit)[0][0], np.sqrt(np.linalg.inv(x @ x.T)[1, 1] * np.mean(left**2))


@pytest.mark.parametrize("lasting", [0.0, 1.0])
def test_errors_that_last_over_a_stretch_are_counted_once_a_stretch(lasting):
    """By 40 stretches, as by noise alone where nothing lasts; where as much lasts as does not, noise alone would hold two of three."""
    draws = [fitted(np.random.default_rng(seed), 40, lasting) for seed in range(600)]
    held = [np.mean([abs(strength - 1) < 1.96 * error for strength, *errors in draws if (error := errors[k])]) for k in (0, 1)]
    assert 0.90 < held[0] < 0.97
    assert held[1] < 0.5 if lasting else held[1] == pytest.approx(0.95, abs=0.03)


def test_few_stretches_tell_nothing():
    assert fitted(np.random.default_rng(1), figures.FEWEST_STRETCHES - 1, 1.0)[1] == 0.0


def test_stretches_of_a_motion_that_repeats_are_parts_of_its_period(tmp_path):
    """Sums over them are those of the rows themselves: together the normal equations, and the same instants of each period in one."""
    model = REPOSITORY / "models/pendulum.yaml"
    talus.simulate(talus.read(model), duration_s=30, seed=3, excitation="paper", fit=True).write(tmp_path / "run.csv")
    dataset, _ = recorded(model, tmp_path, tmp_path / "run.csv")
    search = Search(dataset, plain_base(dataset), lambda every: [c for c in every if c.effect == "stribeck"])
    columns = search.columns(search.gram.candidates[:1])
    (period_s,), (number,) = dataset.periods_s, dataset.stretch_of
    t = dataset.processed_recordings[0].grid_t_s
    assert period_s < 0.5 * (t[-1] - t[0]) and dataset.stretches <= 40 and set(number) == set(range(dataset.stretches))
    again = int(round(period_s / (t[1] - t[0])))
    assert np.mean(number[again:] == number[:-again]) > 0.95
    sums = search.gram.by_stretch(columns)
    (plain,), (own,), base = search.gram.plain, search.gram.gathered(columns), search.gram.base
    every = np.concatenate([plain[base], own])
    strengths = search.gram.fold_strengths(columns)[-1]
    left = plain[-1] - np.concatenate([strengths[base], strengths[search.gram.first:]]) @ every
    assert sums.sum(0) == pytest.approx(every @ left, abs=1e-6 * np.abs(every).max())
    assert np.abs(sums).max() > 100 * np.abs(sums.sum(0)).max()  # the fit leaves no product with its own columns, each stretch does


# ---- recordings by the fits to the others ----------------------------------------------------


def test_each_recording_by_the_fit_to_the_others_is_least_squares_of_these(tmp_path):
    """By NumPy on the rows themselves; and what is then left of a recording is more than its own fit leaves."""
    model, paths = REPOSITORY / "models/pendulum.yaml", [tmp_path / f"{seed}.csv" for seed in (3, 4, 5)]
    for path, excitation in zip(paths, ("paper", "multisine", "multisine"), strict=True):
        talus.simulate(talus.read(model), duration_s=12, seed=int(path.stem), excitation=excitation, fit=True).write(path)
    dataset, _ = recorded(model, tmp_path, *paths)
    search = Search(dataset, plain_base(dataset), lambda every: [c for c in every if c.effect == "stribeck"])
    gram, columns = search.gram, search.columns(search.gram.candidates[:1])
    found = gram.by_other_recordings(columns)["T0"]
    (plain,), (own,), (layout,), weight = gram.plain, gram.gathered(columns), gram.layouts, gram.settled_weights(columns)[0]
    rows, record = np.concatenate([plain[gram.base], own]), dataset.block_record[layout.block]
    prior, reading = gram.prior_rows()
    prior = np.concatenate([prior[gram.base], np.zeros((len(own), len(reading)))])
    for r in range(3):
        others = record != r
        held = np.concatenate([weight * rows[:, others], prior], axis=1), np.concatenate([weight * plain[-1, others], reading])
        strengths = np.linalg.lstsq(held[0].T, held[1], rcond=None)[0]
        assert found[r] == pytest.approx(np.sum((plain[-1] - strengths @ rows)[record == r] ** 2), rel=1e-6)
        mine = np.linalg.lstsq(rows[:, record == r].T, plain[-1, record == r], rcond=None)[1][0]
        assert found[r] > mine
    pairs = figures.by_other_recordings(search, search, search.gram.candidates[:1])["T0"]
    assert [b**2 * len(c.thinned) for (_, b), c in zip(pairs, dataset.channels, strict=True)] == pytest.approx(
        found / dataset.thin * dataset.sigma["T0"] ** 2)  # fmt: skip


def test_the_interval_holds_what_each_recording_closes_by_the_fits_to_the_others():
    before, after = blocks(np.random.default_rng(1), BLOCKS)
    known = [dataset(BLOCKS), residuals(before), residuals(after), 0, NOISE, 1]
    low, high = figures.closed_interval(*known)
    for rms, closes in (((3.0, 2.0), 5 / 8), ((2.0, 2.5), -0.75)):
        wider = figures.closed_interval(*known, elsewhere=[rms])
        assert wider == pytest.approx([min(low, closes), high])
    assert figures.closed_interval(*known, elsewhere=[(0.9 * NOISE, 5.0)]) == [low, high]  # nothing was to be closed there
