"""Smooth paths for a proposed trajectory, within what the recordings show that the joints can do."""

import copy

import numpy as np

STEP_S = 0.01  # between the file's rows
INSIDE = 0.95  # of the recorded range, speed and acceleration
HOLD_S = 0.1  # at rest, at both ends: sensors at rest show their own steps and nothing else
FADE_S = 0.8
BASE_PERIOD_S = 10.0  # of a multisine: its tones are multiples of the inverse


class Limits:
    """What the recordings show of each joint: middle and half of its range, speed, acceleration, motor torque."""

    def __init__(self, all_terms):
        joints = range(all_terms[0].dataset.joints)

        def over_all(name, j):
            return np.concatenate([getattr(terms, name)[j] for terms in all_terms])

        q = [over_all("q", j) for j in joints]
        self.middle = np.array([0.5 * (x.max() + x.min()) for x in q])
        self.half = INSIDE * np.array([0.5 * (x.max() - x.min()) for x in q])
        self.speed = INSIDE * np.array([np.quantile(np.abs(over_all("v", j)), 0.998) for j in joints])
        self.acceleration = INSIDE * np.array([np.quantile(np.abs(over_all("a", j)), 0.99) for j in joints])
        self.torque = np.array([max(np.quantile(np.abs(terms.dataset.effort(terms.record, j)), 0.999)
                                    for terms in all_terms) for j in joints])  # fmt: skip
        self.joints = len(self.middle)

    def slowed(self, factor):
        """The same with less speed and acceleration."""
        out = copy.copy(self)
        out.speed, out.acceleration = factor * self.speed, factor**2 * self.acceleration
        return out


def length_s(q):
    """Of a path."""
    return (q.shape[1] - 1) * STEP_S


def smoothed(q, width_s):
    """Corners rounded over `width_s`; straight stretches stay as they are."""
    n = max(3, 2 * int(0.5 * width_s / STEP_S) + 1)
    kernel = np.sin(np.pi * (np.arange(n) + 1) / (n + 1)) ** 2
    padded = np.pad(q, ((0, 0), (n // 2, n // 2)), mode="edge")
    return np.array([np.convolve(x, kernel / kernel.sum(), "valid") for x in padded])


def rounding_s(speeds, limits):
    """How long a turn from one speed to its reverse must take at the least to keep the acceleration."""
    return max(0.1, float(np.max(4 * np.asarray(speeds) / np.maximum(limits.acceleration, 1e-9))))


def straight(points, speed):
    """One joint from point to point at constant speed."""
    out = [np.array(points[:1], float)]
    for a, b in zip(points, points[1:]):
        n = max(1, round(abs(b - a) / max(speed, 1e-9) / STEP_S))
        out.append(a + (b - a) * np.arange(1, n + 1) / n)
    return np.concatenate(out)


def together(parts):
    """Joints of different length side by side; the shorter ones move slower, so that none rests."""
    n = max(len(x) for x in parts)
    return np.array([np.interp(np.linspace(0, len(x) - 1, n), np.arange(len(x)), x) for x in parts])


def after(*paths):
    """One path after another, each brought to where the last one ended by its own begin: all begin and end alike."""
    return np.concatenate(paths, axis=1)


def back_and_forth(limits, speeds, halves, turns=1):
    """All joints between both sides of their middle at constant speeds, `turns` times (or one number a joint); the
    middle at both ends."""
    turns = np.broadcast_to(turns, limits.joints)
    lines = [straight([m, *[m + h, m - h] * int(k), m], v) for m, h, v, k in zip(limits.middle, halves, speeds, turns)]
    width = rounding_s(speeds, limits)
    margin = int(np.ceil(width / STEP_S))
    return smoothed(np.pad(together(lines), ((0, 0), (margin, margin)), mode="edge"), width)


def multisine(limits, seconds, low_Hz, high_Hz, seed, moving=None, flatness=1.0):
    """Tones with random phases that fill range, speed and acceleration, whichever comes first; joints that are not
    `moving` swing slowly. Amplitudes fall as frequency to the power -flatness."""
    t = np.arange(0, seconds + STEP_S / 2, STEP_S)
    tones = np.arange(max(1, round(low_Hz * BASE_PERIOD_S)), round(high_Hz * BASE_PERIOD_S) + 1) / BASE_PERIOD_S
    random = np.random.Generator(np.random.Philox(seed))
    out = np.zeros((limits.joints, len(t)))
    for j in range(limits.joints):
        phase = random.random(len(tones)) * 2 * np.pi
        if moving is None or j in moving:
            x = faded((tones**-flatness) @ np.sin(2 * np.pi * tones[:, None] * t + phase[:, None]))
            v, a = np.gradient(x, STEP_S), np.gradient(np.gradient(x, STEP_S), STEP_S)
            most = [limits.half[j] / np.abs(x).max(), limits.speed[j] / np.abs(v).max(),
                    limits.acceleration[j] / np.abs(a).max()]  # fmt: skip
            out[j] = min(most) * x
        else:
            out[j] = 0.5 * limits.half[j] * faded(np.sin(2 * np.pi * t / seconds))
    return out + limits.middle[:, None]


def faded(x):
    """Begins and ends at 0 with speed and acceleration 0."""
    n = min(int(FADE_S / STEP_S), len(x) // 3)
    ramp = np.arange(n) / n
    window = np.ones(len(x))
    window[:n] = ramp**3 * (10 - 15 * ramp + 6 * ramp**2)
    window[-n:] = window[:n][::-1]
    return window * x


def held(q):
    """With a rest at both ends."""
    n = int(HOLD_S / STEP_S)
    return np.pad(q, ((0, 0), (n, n)), mode="edge")
