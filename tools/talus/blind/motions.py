"""Kinds of motion of the wide protocol, each a draw for joints of any range: what the twin is told, as its names.

`half` is each joint's half range, `pace` the frequency [1/s] about which a machine of this size moves."""

import numpy as np

from .plants import log_uniform

LEAD_IN_S, FADE_S = 3.0, 1.5  # before the recording begins; in which a motion comes up from rest
MOST_POINTS, SHORTEST_S = 20000, 0.01
TWIN_JOINTS = ("knee", "ankle")


def fade(t):
    x = np.clip((t + LEAD_IN_S) / FADE_S, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x**2)


def instants(length):
    """Of the points of a smooth motion."""
    n = int(min(MOST_POINTS, (length + LEAD_IN_S + 0.2) / SHORTEST_S))
    return np.linspace(-LEAD_IN_S, length + 0.2, n)


def through(t, angles, corner):
    """The twin's job for points {joint: angles}; its reference filter rounds their corners at `corner` rad/s."""
    job = {"points": len(t), "smooth": 1.0, "settle_s": LEAD_IN_S, "ref_filter": corner}
    for i, at in enumerate(t):
        job[f"point_s[{i}]"] = at
        for joint, q in angles.items():
            job[f"point_{joint}[{i}]"] = q[i]
    return job


def multisine(rng, half, pace, length):
    """Periodic, with random phases; the flattest of three draws."""
    count, fall = int(rng.integers(5, 11)), rng.uniform(0.3, 0.9)
    base, k = pace * rng.uniform(0.15, 0.3), np.arange(1, count + 1)
    job, t = {"base_hz": base, "harmonics": count, "settle_s": LEAD_IN_S + FADE_S}, np.linspace(0, 1 / base, 512, endpoint=False)
    for joint, reach in half.items():
        phases = rng.uniform(0, 2 * np.pi, (3, count))
        shapes = [np.sin(2 * np.pi * base * np.outer(t, k) + phase) @ k**-fall for phase in phases]
        best = int(np.argmin([np.abs(shape).max() for shape in shapes]))
        size = reach * rng.uniform(0.8, 1.0) / np.abs(shapes[best]).max() * k**-fall
        for i in range(count):
            job |= {f"{joint}_a[{i}]": size[i], f"{joint}_p[{i}]": phases[best][i]}
    return job


def series(rng, half, pace, length):
    """Sines of frequencies that have no common period."""
    t, angles = instants(length), {}
    for joint, reach in half.items():
        f = pace * np.exp(rng.uniform(np.log(0.12), np.log(1.6), int(rng.integers(4, 8))))
        q = np.sin(2 * np.pi * np.outer(t, f) + rng.uniform(0, 2 * np.pi, len(f))) @ (rng.uniform(0.5, 1.0, len(f)) * f**-0.5)
        angles[joint] = fade(t) * q * reach * rng.uniform(0.8, 1.0) / np.abs(q).max()
    return through(t, angles, 60.0)


def chirp(rng, half, pace, length):
    """A sine whose frequency rises and falls again, smaller where it is fast."""
    t, angles = instants(length), {}
    for joint, reach in half.items():
        low, high = pace * rng.uniform(0.05, 0.15), pace * rng.uniform(1.0, 1.8)
        sweep = length / rng.integers(1, 3)
        f = low * (high / low) ** np.abs(2 * ((t / sweep + rng.uniform()) % 1.0) - 1)
        q = np.sin(2 * np.pi * np.cumsum(f) * (t[1] - t[0])) * np.minimum(1.0, (0.6 * pace / f) ** 0.8)
        angles[joint] = fade(t) * q * reach * rng.uniform(0.8, 1.0)
    return through(t, angles, 60.0)


def gait(rng, half, pace, length):
    """Steps like a walker's, whose cadence and length vary slowly."""
    t, angles, cadence = instants(length), {}, pace * rng.uniform(0.5, 0.9)
    wander = 1 + 0.08 * np.sin(2 * np.pi * t * log_uniform(rng, 0.02, 0.1) + rng.uniform(0, 6))
    phase = 2 * np.pi * cadence * np.cumsum(wander) * (t[1] - t[0])
    stride = 1 - 0.25 * rng.uniform() * (1 + np.sin(2 * np.pi * t * log_uniform(rng, 0.02, 0.1) + rng.uniform(0, 6))) / 2
    for joint, reach in half.items():
        harmonics = np.array([1.0, rng.uniform(0.4, 0.9), rng.uniform(0.1, 0.35), rng.uniform(0.02, 0.12)])
        k = np.arange(1, 5)
        q = np.sin(np.outer(phase, k) + rng.uniform(0, 2 * np.pi, 4)) @ harmonics * stride
        angles[joint] = fade(t) * q * reach * rng.uniform(0.75, 1.0) / np.abs(q).max()
    return through(t, angles, 60.0)


def _moves(rng, half, length, duration, pause, profile):
    """From target to target, the joints together; `duration` of a way and `pause` behind it draw seconds."""
    t, angles = instants(length), {joint: np.zeros(0) for joint in half}
    knots, at, where = [(-LEAD_IN_S, dict.fromkeys(half, 0.0))], -LEAD_IN_S + 0.3, dict.fromkeys(half, 0.0)
    while at < length + 1:
        knots.append((at, where))
        goal = {joint: reach * rng.uniform(-1, 1) for joint, reach in half.items()}
        at += duration(max(abs(goal[j] - where[j]) / half[j] for j in half))
        where = goal
        knots.append((at, where))
        at += pause()
    times = np.array([k[0] for k in knots])
    row = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
    part = profile(np.clip((t - times[row]) / np.maximum(times[row + 1] - times[row], 1e-9), 0, 1))
    for joint in half:
        value = np.array([k[1][joint] for k in knots])
        angles[joint] = value[row] + (value[row + 1] - value[row]) * part
    return t, angles


def ramps(rng, half, pace, length):
    """Slow lines with holds, at several speeds."""
    speeds = pace * np.exp(rng.uniform(np.log(0.15), np.log(0.8), 3))  # half ranges a second
    drawn = _moves(rng, half, length, lambda way: way / rng.choice(speeds) + 0.05, lambda: rng.uniform(0.2, 0.7), lambda x: x)
    return through(*drawn, 40.0)


def moves(rng, half, pace, length):
    """From point to point by the smoothest way, with holds."""
    brisk, rest = rng.uniform(0.35, 0.8) / pace, rng.uniform(0.2, 1.0)
    smooth = lambda x: x**3 * (10 - 15 * x + 6 * x**2)  # noqa: E731
    drawn = _moves(rng, half, length, lambda way: brisk * (0.4 + way), lambda: rest * rng.uniform(0.3, 1.5), smooth)
    return through(*drawn, 60.0)


KINDS = {"multisine": multisine, "series": series, "chirp": chirp, "gait": gait, "ramps": ramps, "moves": moves}
