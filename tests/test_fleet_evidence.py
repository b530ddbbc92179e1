"""What talus-fleet calls more than chance: against SciPy, and how often it errs where there is nothing."""

import numpy as np
import pytest
from scipy import stats

from talus.fleet import evidence


def test_holm_against_the_definition():
    """The k-th smallest of m is rejected at a level if each of the first k stays below level / (m - its place)."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        p = rng.uniform(size=6) ** 3
        corrected = evidence.holm(p)
        for level in (0.01, 0.05, 0.3):
            rejected = set()
            for place, k in enumerate(np.argsort(p)):
                if p[k] > level / (6 - place):
                    break
                rejected.add(int(k))
            assert set(np.flatnonzero(corrected <= level)) == rejected


def test_kendall_against_scipy_with_and_without_ties():
    rng = np.random.default_rng(2)
    for n, steps in ((8, None), (25, None), (25, 6)):
        x, y = rng.standard_normal((2, n)) if steps is None else rng.integers(0, steps, (2, n)).astype(float)
        score, variance, pairs = evidence.kendall(x, y)
        brute = sum(np.sign(x[j] - x[i]) * np.sign(y[j] - y[i]) for i in range(n) for j in range(i + 1, n))
        assert score == brute and pairs == sum(x[i] != x[j] for i in range(n) for j in range(i + 1, n))
        if steps is None:
            assert 2 * stats.norm.sf(abs(score) / np.sqrt(variance)) == pytest.approx(stats.kendalltau(x, y, method="asymptotic").pvalue, rel=1e-9)


@pytest.mark.parametrize("noise", ["standard_normal", "standard_cauchy"])
def test_a_family_of_slopes_seldom_errs_and_its_intervals_hold(noise):
    """Twenty figures over nine sessions that hold nothing: no more than LEVEL of such fleets have a drift, and in no
    more does any interval miss the true slope. 150 fleets: the bound is three standard errors above the level."""
    rng, count = np.random.default_rng(3), 150
    alarms = missed = 0
    for _ in range(count):
        x, family = np.sort(rng.uniform(0, 60, 9)), getattr(rng, noise)((20, 9))
        alarms += evidence.holm([evidence.trend(x, y) for y in family]).min() < evidence.LEVEL
        intervals = [evidence.slope(x, y + 0.3 * x, evidence.LEVEL / 20)[1] for y in family]
        missed += any(one is not None and not one[0] <= 0.3 <= one[1] for one in intervals)
    bound = evidence.LEVEL + 3 * np.sqrt(evidence.LEVEL * (1 - evidence.LEVEL) / count)
    assert alarms / count <= bound and missed / count <= bound


def test_an_interval_needs_enough_sessions():
    """Five sessions in order come by chance in two of 120 ways: no interval holds at one in a thousand."""
    x = np.arange(5.0)
    assert evidence.slope(x, 2 * x, 1e-3) == (2.0, None)
    assert evidence.slope(np.arange(20.0), 2 * np.arange(20.0), 1e-3)[1] == [2.0, 2.0]


def test_a_common_trend_is_found_where_no_robot_alone_shows_it_and_one_robot_is_no_fleet():
    rng, x = np.random.default_rng(4), np.arange(10.0)
    weak = [(x, 0.25 * x + rng.standard_normal(10)) for _ in range(20)]
    assert evidence.common_trend(weak) < 1e-4 and max(evidence.trend(*one) for one in weak) > 0.05
    others = [rng.permutation(10) for _ in range(10)]
    alone = [(x, x), *((x, y) for y in others), *((x, -y) for y in others)]  # whose own trends add up to nothing
    assert evidence.trend(*alone[0]) < 1e-6 and evidence.common_trend(alone) > 0.05


@pytest.mark.parametrize("robots", [6, 12, 40])
def test_robots_seldom_stand_out_where_all_are_alike(robots):
    """Families of eight figures; the level holds within three standard errors, and one that is ten deviations off is found."""
    rng, count = np.random.default_rng(5), 500
    alarms = sum(evidence.holm(np.concatenate([evidence.apart(v)[1] for v in rng.standard_normal((8, robots))])).min() < evidence.LEVEL for _ in range(count))
    assert alarms / count <= evidence.LEVEL + 3 * np.sqrt(evidence.LEVEL * (1 - evidence.LEVEL) / count)
    values = np.append(stats.norm.ppf((np.arange(robots) + 0.5) / robots), 40.0)
    assert np.argmin(evidence.apart(values)[1]) == robots


def test_what_never_changes_stands_nowhere():
    assert evidence.apart([1.0] * 8)[1].tolist() == [1.0] * 8
    assert evidence.trend([1, 2, 3, 4, 5], [0.0] * 5) == 1.0


def test_what_is_usual_for_a_robot_is_no_news():
    """One robot of ten moves ten times as much as the others; only a jump that is large for it, too, stands out."""
    rng = np.random.default_rng(6)
    robots = [k for k in range(10) for _ in range(9)]
    values = rng.standard_normal(90) * np.where(np.array(robots) == 4, 10, 1)
    values[40], values[5] = 200, 12
    for given, expected in ((robots, {5, 40}), (None, {5, *range(36, 45)})):
        stands = set(np.flatnonzero(evidence.holm(evidence.apart(values, given)[1]) < evidence.LEVEL))
        assert {5, 40} <= stands <= expected
    assert len(stands) > 2
