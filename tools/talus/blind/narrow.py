"""The narrow protocol: one kind of leg at 250 Hz, two multisines and ramps, and a slower or faster multisine held out."""

import numpy as np

from . import sensors
from .plants import Leg

NAME = "narrow"
RATE_HZ, JITTER_S, PERIOD_S, PERIODS = 250.0, 3e-4, 4.0, 6
SETTLE_S = 6.0
RECORDINGS = ("train1", "train2", "train3", "test")
CURRENT_LIMIT_A = {"knee": 8.0, "ankle": 1.5}


def draw_control(rng):
    return {
        "knee.bandwidth": rng.uniform(7, 11),
        "ankle.bandwidth": rng.uniform(8, 13),
        "knee.zeta": rng.uniform(0.7, 1.0),
        "ankle.zeta": rng.uniform(0.7, 1.0),
        **{f"{joint}.current_limit": limit for joint, limit in CURRENT_LIMIT_A.items()},
    }


def draw_multisine(rng, style, speed, periodic):
    """A realisation of the multisine: random phases, amplitudes scaled to the joints' ranges."""
    base = speed / PERIOD_S
    job = {"base_hz": base, "harmonics": style["harmonics"], "settle_s": SETTLE_S / speed if periodic else SETTLE_S}
    t = np.linspace(0, 1 / base, 512, endpoint=False)
    k = np.arange(1, style["harmonics"] + 1)
    for joint, reach in (("knee", style["knee_rad"]), ("ankle", style["ankle_rad"])):
        best = None
        for _ in range(3):  # of three draws the one with the flattest peak
            phase = rng.uniform(0, 2 * np.pi, len(k))
            shape = np.sin(2 * np.pi * base * np.outer(t, k) + phase) @ k ** -style["fall"]
            if best is None or np.abs(shape).max() < best[0]:
                best = np.abs(shape).max(), phase
        size = reach * rng.uniform(0.9, 1.1) / best[0] * k ** -style["fall"]
        job.update(
            {f"{joint}_a[{i}]": a for i, a in enumerate(size)} | {f"{joint}_p[{i}]": p for i, p in enumerate(best[1])}
        )
    return job, base


def draw_style(rng):
    return {"harmonics": 8, "fall": rng.uniform(0.4, 0.7), "knee_rad": rng.uniform(0.55, 0.68),
            "ankle_rad": rng.uniform(0.31, 0.36)}  # fmt: skip


def draw_ramps(rng):
    """Slow ramps with holds at three speeds: knee alone, ankle alone, both."""
    knee, ankle, begin = rng.uniform(0.37, 0.43), rng.uniform(0.29, 0.34), 1.0
    speeds = np.array([0.1, 0.19, 0.3]) * rng.uniform(0.9, 1.1)
    where, points = np.zeros(2), [(0.0, 0.0, 0.0), (begin, 0.0, 0.0)]
    for which in ((1, 0), (0, 1), (1, 1)):
        for speed in speeds[1:] if which != (1, 1) else speeds[[0, 2]]:
            for side in rng.permutation([1, -1]):
                aim = np.where(which, np.array([knee, ankle]) * side, where)
                begin += np.max(np.abs(aim - where) / speed / (1.0, 0.9)) + 1e-3
                points.append((begin, *aim))
                begin += rng.uniform(0.25, 0.6)
                points.append((begin, *aim))
                where = aim
        if which != (1, 1):
            begin += np.max(np.abs(where) / speeds[2])
            where = np.zeros(2)
            points.append((begin, 0.0, 0.0))
            begin += 0.3
            points.append((begin, 0.0, 0.0))
    job = {"points": len(points), "settle_s": 1.0, "ref_filter": 40.0}
    for i, (t, k, a) in enumerate(points):
        job.update({f"point_s[{i}]": t, f"point_knee[{i}]": k, f"point_ankle[{i}]": a})
    return job, begin


def draw_runs(rng):
    """Each recording's job, its length and when in the session it begins."""
    style, runs, session = draw_style(rng), {}, 0.0
    faster = rng.uniform(1.25, 1.36)
    unseen = rng.choice([rng.uniform(0.75, 0.85), rng.uniform(1.1, 1.18)])
    for name in RECORDINGS:
        if name == "train3":
            job, length = draw_ramps(rng)
        else:
            speed = {"train1": 1.0, "train2": faster, "test": unseen}[name]
            job, base = draw_multisine(rng, style, speed, True)
            length = 20.0 if name == "test" else PERIODS / base
        n = int(length * RATE_HZ)
        times = 0.002 + np.arange(n) / RATE_HZ + rng.uniform(-JITTER_S, JITTER_S, n)
        session += job["settle_s"]
        runs[name] = {
            "job": {**job, "session_s": session, "seed": int(rng.integers(1, 2**31))},
            "times": np.round(times, 6),
        }
        session += length + rng.uniform(3, 12)
    return runs


def draw_bench(case):
    """Plant, control, recordings, noise and optional columns, each from its own stream."""
    bench = case.streams["bench"]
    case.plant = Leg.draw(case.streams["plant"])
    case.control, case.runs = draw_control(bench), draw_runs(bench)
    case.noise, case.options = sensors.complete_noise(sensors.draw_noise(bench), case.plant), sensors.draw_options(bench)
    case.limits_A, case.protocol = CURRENT_LIMIT_A, None
