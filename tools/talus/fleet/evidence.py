"""What many comparisons at once may call more than chance."""

import numpy as np
from scipy import stats

LEVEL = 0.05  # probability that a whole family of tests raises one false alarm
MAD_TO_SIGMA = 1.4826  # of a normal distribution
MAD_EFFICIENCY = 0.37  # of the median absolute deviation: so many samples in a hundred would tell as much by their deviation
FEWEST_OWN = 4  # of which it is known what is usual for one robot


def holm(p):
    """p values of a family as what each is worth within it (Holm 1979): below LEVEL, at most LEVEL of all families err anywhere.

    >>> holm([0.01, 0.04, 0.03]).tolist()
    [0.03, 0.06, 0.06]
    """
    p = np.asarray(p, float)
    order = np.argsort(p)
    steps = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    out = np.empty(len(p))
    out[order] = np.minimum(steps, 1.0)
    return out


def trend(x, y):
    """p of Kendall's test that y goes neither up nor down with x: of ranks, so of any noise whose samples are independent; exact for
    few samples without ties."""
    p = stats.kendalltau(x, y).pvalue
    return 1.0 if np.isnan(p) else float(p)


def kendall(x, y):
    """(S, its variance without a trend, pairs that x tells apart): concordant less discordant pairs."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    first, second = np.triu_indices(len(x), 1)
    score = np.sign(x[second] - x[first]) * np.sign(y[second] - y[first])
    n, ties = len(x), [np.unique(values, return_counts=True)[1] for values in (x, y)]
    variance = (n * (n - 1) * (2 * n + 5) - sum((k * (k - 1) * (2 * k + 5)).sum() for k in ties)) / 18
    return float(score.sum()), max(float(variance), 0.0), int((x[second] != x[first]).sum())


def common_trend(samples):
    """p of the regional Kendall test (Helsel and Frans 2006) that no y of [(x, y)] goes the way of the others: their S and its
    variance summed, since each robot is held against itself alone."""
    found = [kendall(x, y) for x, y in samples]
    variance = sum(one[1] for one in found)
    return float(2 * stats.norm.sf(abs(sum(one[0] for one in found)) / np.sqrt(variance))) if variance > 0 else 1.0


def slope(x, y, level=LEVEL):
    """(Theil and Sen's slope, its interval at 1 - level or None): the interval is None where so few samples cannot give one, for
    even the smallest and the largest slope of two sessions would lie within it."""
    found = stats.theilslopes(y, x, alpha=1 - level)
    _, variance, pairs = kendall(x, y)
    reach = stats.norm.isf(level / 2) * np.sqrt(variance)
    interval = None if not variance > 0 or reach > pairs - 2 else [float(found.low_slope), float(found.high_slope)]
    return float(found.slope), interval


def apart(values, robots=None):
    """(deviations of each value from the median, p of each): in robust standard deviations. Because those are estimated from the
    values themselves, the tails are Student's, with the degrees of freedom that the median absolute deviation is worth. Given each
    value's robot, what is usual for a robot of FEWEST_OWN values or more does not count, however unusual it is for the others."""
    values = np.asarray(values, float)
    off = np.abs(values - np.median(values))
    spread = np.full(len(values), np.median(off))
    for robot in set(robots or ()):
        own = np.array([one == robot for one in robots])
        if own.sum() >= FEWEST_OWN:
            spread[own] = max(np.median(off), np.median(off[own]))
    if not np.median(off) > 0:
        return np.zeros(len(values)), np.ones(len(values))
    deviations = (values - np.median(values)) / (MAD_TO_SIGMA * spread)
    return deviations, 2 * stats.t.sf(np.abs(deviations), MAD_EFFICIENCY * (len(values) - 1))


def more_often(here, of, elsewhere, of_others):
    """p of Fisher's exact test that `here` of `of` is more often than `elsewhere` of `of_others`."""
    return float(stats.fisher_exact([[here, of - here], [elsewhere, of_others - elsewhere]], alternative="greater").pvalue)
