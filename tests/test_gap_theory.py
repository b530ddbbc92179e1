"""talus-gap's own search, probabilities and intervals on linear-Gaussian toys (theory/toy.py), against what theory has for them:
Imhof's integral, SciPy, closed forms. Each with a few trials here, and with 2,000 or more where `long`; those with replicates
with TALUS_SHARE of these.

Tolerances are Monte-Carlo errors: what has a chance of one in a thousand, if theory is right, fails.
"""


import numpy as np
import pytest
from scipy.stats import binom, chi2, kstwo, multivariate_normal, norm
from theory import exact, studies, trials
from theory.toy import BASE_NM, PRIOR_WIDTH, SIGMA_NM

pytestmark = pytest.mark.longest

RARE = 1e-3
BELOW = 0.05  # that a probability of `none` may at the most be less than what comes true


@pytest.fixture(params=["fast", pytest.param("whole", marks=pytest.mark.long)])
def sizes(request):
    return request.param


def is_likely_at_most(count, number, share):
    """May so many of a number have come about if each has this chance at the most?"""
    return binom.sf(count - 1, number, share) > RARE


def is_likely_at_least(count, number, share):
    return binom.cdf(count, number, share) > RARE


# ---- the closed forms themselves ---------------------------------------------------------


def test_imhofs_integral_is_chi_square_where_weights_are_equal():
    for x in (2.0, 8.0, 20.0):
        assert exact.exceeds(np.ones(8), x) == pytest.approx(chi2.sf(x, 8), rel=1e-5)
        assert chi2.sf(x, 8) <= exact.exceeds_at_most(np.ones(8), x) * (1 + 1e-9)


def test_the_evidence_is_the_normal_density():
    random = np.random.default_rng(1)
    toy = trials.problem(random, rough=False)
    sizes_Nm, band = 30 * toy.unit_Nm, exact.band()
    reading = toy.recording(2 * toy.unit_Nm)
    density = []
    for size, row in zip(sizes_Nm, toy.effects):
        drawn = np.vstack([(PRIOR_WIDTH * BASE_NM)[:, None] * toy.base, size * row]) @ band.T
        wide = SIGMA_NM**2 * np.eye(len(band)) + drawn.T @ drawn
        density.append(multivariate_normal.logpdf(band @ (reading - BASE_NM @ toy.base), np.zeros(len(band)), wide))
    assert np.diff(exact.log_evidence(toy, reading, sizes_Nm)) == pytest.approx(np.diff(density), abs=1e-6)


# ---- what noise alone gains --------------------------------------------------------------


def test_a_useless_column_gains_what_imhof_says(sizes):
    """Held-out blocks, prior of the base parameters, low-pass and thinning included."""
    weights, found = studies.useless(sizes)
    assert abs(found.mean() - weights.sum()) < norm.isf(RARE / 2) * np.sqrt(2 * np.sum(weights**2) / len(found))
    at = np.quantile(found, np.linspace(0.02, 0.98, 40))
    off = [np.mean(found > x) - exact.exceeds(weights, x) for x in at]
    assert np.abs(off).max() < kstwo.isf(RARE, len(found))


def test_noise_alone_is_seldom_worth_an_effect(sizes):
    """Of six columns one gains a least step more often than of a thousand."""
    weights, _ = studies.useless(sizes)
    found = studies.family(studies.study("white", sizes))
    by_chance = trials.EFFECTS * exact.exceeds(weights, trials.LEAST_STEP)
    assert by_chance < 0.02 and is_likely_at_most(found.taken, found.number, by_chance) and found.named <= found.taken


def test_what_reconstruction_leaves_is_taken_as_seldom_as_the_formula_promises(sizes):
    found = studies.family(studies.study("rough", sizes))
    assert 0.01 < found.promise < 0.1
    assert is_likely_at_most(found.taken, found.number, found.promise) and found.named <= found.taken


def test_where_replicates_differ_much_it_is_taken_at_most_three_times_as_often(sizes):
    """A departure from theory: the logarithms of their gains differ by 2, seven times as much as on benches, and so few do not know that well."""
    found = studies.family(studies.study("wide", sizes))
    assert is_likely_at_most(found.taken, found.number, 3 * found.promise) and found.named <= found.taken


# ---- P(none) -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["rough", "white", "outside", "both"])
def test_none_comes_true_at_most_a_little_more_often_than_claimed(name, sizes):
    """It is claimed rather too often: what is too small to be seen counts as nothing."""
    for one in studies.none_bins(studies.study(name, sizes)):
        assert is_likely_at_most(one.true, one.number, min(one.claimed + BELOW, 1.0)), one


@pytest.mark.parametrize("name", ["rough", "white", "outside"])
def test_no_effect_comes_true_at_most_a_little_more_often_than_none_and_unknown_together_claim(name, sizes):
    for one in studies.no_cause_bins(studies.study(name, sizes)):
        assert is_likely_at_most(one.true, one.number, min(one.claimed + BELOW, 1.0)), one


def test_where_nothing_is_hidden_none_is_all_but_sure(sizes):
    """`unknown` keeps little for causes outside the catalogue."""
    quiet = [one for one in studies.study("rough", sizes) if one.truth is None and not one.taken]
    assert all(one.none + one.unknown == pytest.approx(1.0, abs=1e-3) for one in quiet)
    none = np.array([one.none for one in quiet])
    assert none.mean() + norm.isf(RARE) * none.std() / np.sqrt(len(none)) > 1 - BELOW


# ---- intervals ---------------------------------------------------------------------------


def test_intervals_hold_the_truth_as_often_as_they_say(sizes):
    """Without selection; by their own half-widths, which stretch where more is left than the noise."""
    found = studies.study("measured", sizes)
    expected = np.array([exact.covered(one.half_width) for one in found])
    error = np.sqrt(np.sum(expected * (1 - expected))) / len(found)
    assert abs(np.mean([one.covered for one in found]) - expected.mean()) < norm.isf(RARE / 2) * error
    assert 0.95 < expected.mean() < 0.96
    assert min(one.half_width for one in found) > 1.96 * (1 - 1e-3)


def test_what_hardly_stands_out_is_too_large_where_it_is_taken(sizes):
    """Coverage falls where only the largest estimates are taken, not below theory's; and not where all are."""
    for one in studies.coverages(studies.study("measured", sizes)):
        if one.taken:
            assert is_likely_at_least(round(one.covered_if_taken * one.taken), one.taken, min(one.by_theory, 0.95)), one
    clear = [one for one in studies.study("measured", sizes) if one.taken and one.deviations > 8]
    assert is_likely_at_least(sum(one.covered for one in clear), len(clear), 0.95)


@pytest.mark.parametrize("name", ["white", "rough"])
def test_intervals_hold_the_truth_of_effects_that_are_taken(name, sizes):
    """And where reconstruction adds to the strength as it does in replicates."""
    held = [one.covered for one in studies.study(name, sizes) if one.covered is not None]
    assert is_likely_at_least(sum(held), len(held), 0.95)


# ---- which effect it is ------------------------------------------------------------------


def test_shares_and_exact_evidence_have_the_same_likeliest_effect(sizes):
    found = studies.study("choices", sizes)
    decided, same = studies.agreement(found)
    assert decided > 0.3 * len(found) and same >= 0.99 * decided
    assert studies.rank_correlation(found) > 0.9


def test_shares_are_the_evidence_at_their_temperature(sizes):
    """Of the effect that is alike; held-out blocks count a difference some percent more than the whole fit does."""
    assert np.median(studies.cooling(studies.study("choices", sizes))) == pytest.approx(1.0, abs=0.1)


def test_the_likeliest_effect_is_right_more_often_than_its_share_says(sizes):
    found = studies.study("choices", sizes)
    for one in studies.likeliest_bins(found):
        assert is_likely_at_least(one.true, one.number, one.claimed), one
    for one in studies.likeliest_bins(found, "exact"):
        assert is_likely_at_least(one.true, one.number, one.claimed) and is_likely_at_most(one.true, one.number, one.claimed), one
