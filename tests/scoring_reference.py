"""The scoring rule in SciPy, written from its definition, to compare lib/score.c with.

Rule: error = measured - predicted; both series on an even grid of the median step,
segment by segment (cut at gaps over 5 steps and where `valid` changes), through the
same zero-phase Butterworth; left out are trim_s at the ends of a segment and guard_s
around each sample with |speed| below standstill.
"""

import numpy as np
from scipy.signal import butter, filtfilt


def segments(t, valid, step):
    edges = np.flatnonzero((np.diff(t) > 5 * step) | (np.diff(valid.astype(int)) != 0)) + 1
    bounds = np.concatenate(([0], edges, [len(t)]))
    return [(a, b) for a, b in zip(bounds[:-1], bounds[1:]) if valid[a] and b - a > 20]


def score(t, y, yhat, speed, valid=None, lowpass_hz=30.0, order=4, standstill=0.008, guard_s=0.016, trim_s=0.25):
    valid = np.ones(len(t), bool) if valid is None else np.asarray(valid, bool)
    step = np.median(np.diff(t))
    kept_error, kept_measured, left_out = [], [], []
    for a, b in segments(t, valid, step):
        grid = np.arange(t[a], t[b - 1], step)
        if len(grid) * step < 3 * trim_s:
            continue
        measured, error, v = (np.interp(grid, t[a:b], x[a:b]) for x in (y, y - yhat, np.abs(speed)))
        if 2 * lowpass_hz * step < 0.95:
            numerator, denominator = butter(order, 2 * lowpass_hz * step)
            padding = min(len(grid) - 1, 60)
            measured = filtfilt(numerator, denominator, measured, padlen=padding)
            error = filtfilt(numerator, denominator, error, padlen=padding)
        reach = int(np.ceil(guard_s / step))
        still = np.flatnonzero(v < standstill)
        keep = np.ones(len(grid), bool)
        for k in range(-reach, reach + 1):
            near = still + k
            keep[near[(near >= 0) & (near < len(grid))]] = False
        inside = np.zeros(len(grid), bool)
        trim = int(trim_s / step)
        inside[trim : len(grid) - trim] = True
        kept_error.append(error[keep & inside])
        kept_measured.append(measured[keep & inside])
        left_out.append(error[~keep & inside])
    e, m, r = (np.concatenate(x) for x in (kept_error, kept_measured, left_out))
    rms = lambda x: float(np.sqrt(np.mean(x**2))) if len(x) else 0.0
    return rms(e), rms(m), 100 * np.linalg.norm(e) / np.linalg.norm(m), rms(r)
