"""The noise floor from the data itself: what differs between repeated periods, else what lies above the motion."""

import numpy as np

from .calibration.thresholds import LASTS
from .numerics import interpolated, median_of_chi2

BLOCK_S = 4.0  # longer than the memory of friction, springs and mount
SHORTEST_BLOCK_S = 1.0
WANTED_BLOCKS = 20  # short recordings get shorter blocks: a gain is judged by its spread over blocks
# one joint is often driven through each speed or place once: long blocks would ask for what no other block has shown
SHORTEST_BLOCK_OF_ONE_JOINT_S = 0.5
WANTED_BLOCKS_OF_ONE_JOINT = 80
SHORTEST_PERIOD_S, LONGEST_PERIOD_S = 0.5, 120.0
REPEATS_BELOW = 1e-3  # mismatch of the angle, over twice its variance, of a motion that repeats
FEWEST_REPEATED_ROWS = 50
NEAR_REPEAT_AFTER_S = 1.0  # what comes back sooner is the same motion, not another
NEIGHBOURS = 60  # a state with so many of its own second nearer than another's is too far from that one
ROWS_AT_A_TIME = 64
NEAREST_SHARE = 0.25
FEWEST_PAIRS = 30
LASTING_S = (0.5, 1.0)  # what is still there after it is no noise of a sensor; what swings is not seen after each of them
TURNED_S, TURNED_PERIODS = 0.25, 2.0  # what turns with the motion within it is no noise of a sensor; periods of the low-pass, at least
FEWEST_INSTANTS = 6
LEAST_STEP = 1e-9  # of an angle's sensor: below it two values are the same but for rounding
STRAYS = 0.001  # of the differences of neighbouring values: the library's share for a step by changes
LINES = 3  # of a spectrum on either side of its strongest one, that belong to it


def robust_deviation(x):
    """Standard deviation by the median absolute deviation."""
    return 1.4826 * np.median(np.abs(x - np.median(x)))


def rough_part(raw):
    """What samples have that is not smooth over four of them, as large as white noise on one: third differences multiply that by sqrt(20)."""
    return np.diff(raw, 3) / np.sqrt(20.0)


def above_motion(raw):
    """Standard deviation of white noise on samples, whatever single jumps the motion makes."""
    return robust_deviation(rough_part(raw))


def roughness(raw):
    """The same with the jumps; 0 of fewer than four samples."""
    return float(np.sqrt(np.mean(rough_part(raw) ** 2))) if len(raw) > 3 else 0.0


def block_length_s(time_s, joints):
    """Length of a block for recordings of this total length."""
    wanted, shortest = (WANTED_BLOCKS, SHORTEST_BLOCK_S) if joints > 1 else (WANTED_BLOCKS_OF_ONE_JOINT,
                                                                          SHORTEST_BLOCK_OF_ONE_JOINT_S)  # fmt: skip
    return float(np.clip(time_s / wanted, shortest, BLOCK_S))


def mismatches(angles):
    """Mean square of what each angle differs from itself at every lag, over twice its variance; the largest of all."""
    out = []
    for angle in angles:
        x, n = angle - np.mean(angle), len(angle)
        turned = np.fft.rfft(x, 2 * n)
        common = np.fft.irfft(np.abs(turned) ** 2, 2 * n)[:n]
        energy = np.concatenate([[0.0], np.cumsum(x * x)])
        lags = np.arange(n)
        out.append((energy[n - lags] + energy[n] - energy[lags] - 2 * common) / (n - lags) / (2 * np.var(x) + 1e-30))
    return np.max(out, axis=0)


def find_period_s(processed):
    """Shortest lag at which all joint angles repeat, and beside a sensor at the output the drive's current, or None."""
    angles = [processed.resample(q) for q in processed.q]
    if "joint_load_Nm" in processed.columns:
        angles.append(processed.lowpass(processed.resample(processed.columns["joint_current_A"])))
    n, step_s = len(angles[0]), processed.step_s
    if len(processed.parts) != 1 or min(np.var(x) for x in angles) < 1e-12:
        return None

    every = mismatches(angles)
    stride = max(1, int(0.02 / step_s))
    lags = np.arange(int(SHORTEST_PERIOD_S / step_s), int(min(n / 2.5, LONGEST_PERIOD_S / step_s)), stride)
    found = every[lags]
    below = np.flatnonzero(found < REPEATS_BELOW)
    if not len(below):
        return None
    k = below[0]
    while k + 1 < len(found) and found[k + 1] < found[k]:
        k += 1
    near = np.arange(max(1, lags[k] - stride), lags[k] + stride + 1)
    fine = every[near]
    i = int(np.argmin(fine))
    shift = 0.0
    if 0 < i < len(fine) - 1:  # parabola through the three lowest
        shift = 0.5 * (fine[i - 1] - fine[i + 1]) / (fine[i - 1] - 2 * fine[i] + fine[i + 1])
    return (near[i] + shift) * step_s


def repeat_deviation(processed, values, mask, period_s):
    """Standard deviation of filtered noise by what differs between periods at the same phase, or None.

    Second differences from period to period let a level or a slope over time pass unseen; the median over phases,
    corrected for its distribution, lets pass the few phases at which a reversal falls a sample earlier or later."""
    t = processed.grid_t_s - processed.grid_t_s[0]
    periods = int((t[-1] + processed.step_s) / period_s)
    if periods < 3:
        return None
    phase = np.arange(int(period_s / processed.step_s)) * processed.step_s
    every = np.array([interpolated(values, np.minimum(phase + k * period_s, t[-1]) / processed.step_s) for k in range(periods)])
    known = np.array([np.interp(phase + k * period_s, t, mask.astype(float)) for k in range(periods)]) > 0.99
    full = known.all(0)
    if full.sum() < FEWEST_REPEATED_ROWS:
        return None
    change = np.diff(every[:, full], 2, axis=0)
    variance = (change**2).mean(0) / 6
    freedom = max(0.59 * (periods - 2) + 0.2, 1.0)  # of overlapping differences; a single one has 1
    return np.sqrt(np.median(variance) / (median_of_chi2(freedom) / freedom))


def concentration(processed, values, mask, period_s):
    """Share of what differs from period to period (second differences, as above) that lies about its strongest frequency: little for
    noise, whatever its colour; much for a vibration, or for what happens now and then."""
    n = round(period_s / processed.step_s)
    if len(values) <= 2 * n:
        return 0.0
    known = mask[2 * n:] & mask[n:-n] & mask[:-2 * n]
    if known.sum() < FEWEST_REPEATED_ROWS:
        return 0.0
    change = np.where(known, values[2 * n:] - 2 * values[n:-n] + values[:-2 * n], 0.0) * np.hanning(len(known))
    power = np.abs(np.fft.rfft(change)) ** 2
    peak = int(np.argmax(power))
    return float(power[max(0, peak - LINES):peak + LINES + 1].sum() / max(power.sum(), 1e-300))


def near_pairs(states, t_s):
    """(i, k): instants at which nearly the same state comes back a second or more later, the nearest such pairs; None where there
    are few. `states` is (n, m)."""
    unit = (states - states.mean(0)) / (states.std(0) + 1e-12)
    begins = np.searchsorted(t_s, t_s - NEAR_REPEAT_AFTER_S, side="left")
    ends = np.searchsorted(t_s, t_s + NEAR_REPEAT_AFTER_S, side="right")
    nearest, near = np.empty(len(t_s), int), np.full(len(t_s), np.inf)
    for first in range(0, len(t_s), ROWS_AT_A_TIME):
        square = _squares(unit[first:first + ROWS_AT_A_TIME], unit)
        for i, row in enumerate(square, first):
            own = row[begins[i]:ends[i]].copy()
            row[begins[i]:ends[i]] = np.inf
            nearest[i] = row.argmin()
            if (own < row[nearest[i]]).sum() < NEIGHBOURS:
                near[i] = row[nearest[i]]
    row = np.flatnonzero(np.isfinite(near))
    if len(row) < FEWEST_PAIRS:
        return None
    row = row[near[row] <= np.quantile(near[row], NEAREST_SHARE)]
    return row, nearest[row]


def _squares(some, states):
    """Squared distance of each of some states from each state."""
    return (some**2).sum(1)[:, None] + (states**2).sum(1) - 2 * some @ states.T


def pair_deviation(change):
    """Standard deviation of noise by what differs where nearly the same state comes back: the pure error of a lack-of-fit test,
    for motions that do not repeat. `change` is that of the residual of a model that knows most of the torque; the median, so
    that the few pairs that differ in something else do not count."""
    return float(np.sqrt(np.median(change**2) / 2 / median_of_chi2(1.0)))


def steady(change, instants, direction):
    """What differs at pairs, less a friction that goes straight or bent with the recording's time, where that is significant, by as many
    independent instants as in `lasting_share`: what drifts is no noise, as it is none where the motion repeats. `instants` [s] and
    `direction` of motion are (2, pairs)."""
    unit = (instants - np.min(instants)) / max(np.ptp(instants), 1e-9)
    trends = np.array([np.diff(direction * unit**power, axis=0)[0] for power in (1, 2)]).T
    drift = trends @ np.linalg.lstsq(trends, change, rcond=1e-9)[0]
    count, rest = len(np.unique(instants[0] // LASTING_S[0])), change - drift
    return rest if count * (drift @ drift) > LASTS**2 * (rest @ rest) else change


def differences(residual, mask, pairs, lag, sign, turned=False):
    """What differs at pairs of instants (grid rows) with the same state, and `lag` rows later at both, each in the direction `sign`
    of something that it may be a share of, where that is the same at both; (n, 2). `turned`: only where that has turned by then."""
    i, k = (np.asarray(p) for p in pairs)
    inside = np.flatnonzero(np.maximum(i, k) + lag < len(residual))
    i, k = i[inside], k[inside]
    known = mask[i] & mask[k] & mask[i + lag] & mask[k + lag] & (sign[i] == sign[k]) & (sign[i + lag] == sign[k + lag])
    if turned:
        known &= sign[i] * sign[i + lag] < 0
    i, k = i[known], k[known]
    now, later = sign[i] * (residual[i] - residual[k]), sign[i + lag] * (residual[i + lag] - residual[k + lag])
    return np.column_stack([now, later]), len(np.unique(i // lag))


def lasting_share(found):
    """Share of the variance of what differs between the same states that is still there later, of all recordings'
    `differences`: a sensor's noise is gone by then, a torque that wanders is not. 0 unless the correlation is significant, by
    Fisher's transformation with as many independent instants as there are such lags."""
    both, instants = np.concatenate([pairs for pairs, _ in found]), sum(n for _, n in found)
    if instants < FEWEST_INSTANTS:
        return 0.0
    power = np.mean(both**2, axis=0)
    correlation = min(np.mean(both[:, 0] * both[:, 1]) / np.sqrt(power[0] * power[1] + 1e-300), 1 - 1e-3)
    return float(correlation) if np.arctanh(correlation) * np.sqrt(instants - 3) > LASTS else 0.0


def quantisation_step(values):
    """The sensor's step: the smallest change that occurs."""
    change = np.abs(np.diff(values))
    change = change[change > LEAST_STEP]
    return change.min() if len(change) else 0.0


def finest_step(values):
    """The same where the motion passes over most steps from one sample to the next: the smallest difference of any two values, but
    for a few strays, such as values between steps in the place of lost ones."""
    gap = np.diff(np.unique(values))
    gap = gap[gap > LEAST_STEP]
    return float(np.quantile(gap, STRAYS, method="lower")) if len(gap) else 0.0
