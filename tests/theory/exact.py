"""What theory has for the toys, computed without talus-gap's code: closed forms, SciPy, Imhof's integral."""

from math import exp, pi, sqrt

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar
from scipy.special import logsumexp, ndtr
from scipy.stats import norm

from .toy import BASE_NM, KEPT, PRIOR_WIDTH, SAMPLES, SIGMA_NM

NEGLIGIBLE = 1e-6  # of a weight of the order of 1, or of an integrand


def band():
    """Orthonormal rows that span what the low-pass leaves."""
    angle = 2 * np.pi * np.outer(np.arange(1, KEPT), np.arange(SAMPLES)) / SAMPLES
    waves = np.sqrt(2 / SAMPLES) * np.concatenate([np.cos(angle), np.sin(angle)])
    return np.concatenate([np.full((1, SAMPLES), SAMPLES**-0.5), waves])


# ---- the gain of a column that means nothing ---------------------------------------------


def left_out(rows, fold, width):
    """Matrix that makes of a reading's deviation from what is expected the residual of every fold by the fit to the others. `rows`:
    (unknowns, n); `width` of each unknown before the data, infinite where nothing is known."""
    out = np.eye(rows.shape[1])
    for f in np.unique(fold):
        inside, others = fold == f, rows[:, fold != f]
        fit = np.linalg.solve(others @ others.T + np.diag(width**-2.0), others)
        out[np.ix_(inside, fold != f)] -= rows[:, inside].T @ fit
    return out


def weights_of_gain(problem, dataset, k):
    """Held-out gain of one effect where nothing is hidden, as a sum of squares of independent unit normals with these weights."""
    rows = dataset.channels[0].thinned
    fold = dataset.folds[dataset.block_of[0][rows]]
    scale, width = np.sqrt(dataset.thin) / SIGMA_NM, PRIOR_WIDTH * BASE_NM
    base, effect = scale * problem.base[:, rows], scale * problem.effects[k : k + 1, rows]
    drawn = np.concatenate([base.T * width, np.sqrt(dataset.thin) * band()[:, rows].T], axis=1)
    without = left_out(base, fold, width) @ drawn
    beside = left_out(np.concatenate([base, effect]), fold, np.append(width, np.inf)) @ drawn
    return np.linalg.eigvalsh(without.T @ without - beside.T @ beside)


def exceeds(weights, gain):
    """P(sum of weighted squares of unit normals > gain), by Imhof's integral (Biometrika 48, 1961)."""
    weights = weights[np.abs(weights) > NEGLIGIBLE]

    def integrand(u):
        turned = 0.5 * np.sum(np.arctan(weights * u)) - 0.5 * gain * u
        return np.sin(turned) / u * damping(u)

    def damping(u):
        return np.exp(-0.25 * np.sum(np.log1p((weights * u) ** 2)))

    end = 1.0
    while damping(end) > NEGLIGIBLE:
        end *= 2
    return 0.5 + quad(integrand, 1e-9, end, limit=500)[0] / np.pi


def exceeds_at_most(weights, gain):
    """An upper bound of the same, far out where the integral has no digits left (Chernoff)."""

    def bound(t):
        return -t * gain - 0.5 * np.sum(np.log1p(-2 * t * weights))

    return float(np.exp(minimize_scalar(bound, bounds=(0, 0.5 / weights.max() * (1 - 1e-9)), method="bounded").fun))


# ---- how often something is taken where nothing is hidden --------------------------------


def taken_by_chance(widths, deviations, span):
    """Upper bound of the chance that any of the effects, whose nulls' logarithms have these widths, is likelier something than nothing."""
    return sum(_taken_by_chance(width, deviations, span * len(widths)) for width in widths)


def _taken_by_chance(width, deviations, span):
    return norm.sf(brentq(lambda z: exp(-0.5 * z * z) / sqrt(2 * pi) / width - ndtr(z - deviations) / span, 0.0, 10.0))


# ---- which effect it is ------------------------------------------------------------------


def log_evidence(problem, reading, sizes_Nm):
    """Logarithm of the marginal likelihood of each effect alone, but for a constant: base parameters and strength from independent
    normal distributions, the strength's about 0 with the deviation `sizes_Nm`; white noise within the band."""
    off = reading - BASE_NM @ problem.base
    return np.array([_log_normal(off, np.vstack([(PRIOR_WIDTH * BASE_NM)[:, None] * problem.base, size * row]))
                     for size, row in zip(sizes_Nm, problem.effects, strict=True)])  # fmt: skip


def _log_normal(off, rows):
    """log N(off; 0, sigma^2 I + rows' rows) but for a constant, by the matrix determinant lemma and Woodbury's identity."""
    inner = np.eye(len(rows)) + rows @ rows.T / SIGMA_NM**2
    shown = rows @ off / SIGMA_NM**2
    return -0.5 * np.linalg.slogdet(inner)[1] + 0.5 * shown @ np.linalg.solve(inner, shown) - 0.5 * off @ off / SIGMA_NM**2


def posterior(problem, reading, sizes_Nm):
    """Probability of each effect, each as likely before; as logarithms."""
    found = log_evidence(problem, reading, sizes_Nm)
    return found - logsumexp(found)


# ---- intervals ---------------------------------------------------------------------------


def covered(half_width):
    """Chance that an interval of so many standard deviations on either side holds the truth."""
    return 2 * norm.cdf(half_width) - 1


def covered_if_taken(share, half_width=1.96):
    """The same where the largest `share` of the estimates is taken: what stands out does so by luck."""
    least = norm.isf(np.clip(share, 1e-9, 1 - 1e-9))
    return float(np.clip(norm.cdf(half_width) - norm.cdf(max(least, -half_width)), 0.0, 1.0) / share)

