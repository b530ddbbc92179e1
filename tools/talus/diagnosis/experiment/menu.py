"""The menu of experiments: the trajectory of each and what it is good for, and what needs more than a trajectory."""

import numpy as np

from ..effects import known
from .path import after, back_and_forth, multisine

SLOW_SPEEDS = (0.03, 0.08, 0.2)  # rad/s, or m/s of a slider; half the largest recorded at the most
SLOW_TRAVEL_S = 4.0  # from the middle to one side
SPEED_SHARES = (0.15, 0.3, 0.55, 0.9)  # of the largest recorded
LONGEST_S = 120.0  # of a proposal, repeats and all
MARGIN = 1.5  # factor on the chi-square that is needed: a prediction that is just met may miss
GENTLY = 0.85  # factor on speed, its square on acceleration, where fast motion is hard to reconstruct


def slow_ramps(limits):
    parts = []
    for speed in SLOW_SPEEDS:
        speeds = np.minimum(speed * np.array([1.0, 0.7])[:limits.joints], 0.5 * limits.speed)
        parts.append(back_and_forth(limits, speeds, np.minimum(limits.half, speeds * SLOW_TRAVEL_S)))
    return after(*parts)


def speeds(limits):
    parts = []
    for own, other in zip(SPEED_SHARES, np.roll(SPEED_SHARES, 2)):
        chosen = limits.speed * np.array([own, other])[:limits.joints]
        round_s = 4 * limits.half / np.maximum(chosen, 1e-9)
        parts.append(back_and_forth(limits, chosen, 0.95 * limits.half, np.maximum(1, np.round(5.0 / round_s))))
    return after(*parts)


def wide_multisine(limits):
    return multisine(limits, 20.0, 0.1, 1.5, seed=1)


def fast_multisine(limits):
    return multisine(limits.slowed(GENTLY), 20.0, 1.0, 6.0, seed=2)


def one_by_one(limits):
    return after(*(multisine(limits, 10.0, 0.2, 2.0, seed=3 + j, moving=[j]) for j in range(limits.joints)))


TRAJECTORIES = {
    "slow_ramps": (slow_ramps, "slow ramps in both directions at three speeds, where friction near standstill and over "
                               "position shows without inertia"),
    "speeds": (speeds, "straight moves over the whole range at four constant speeds, where friction shows over speed and "
                       "position without inertia"),
    "wide_multisine": (wide_multisine, "a multisine from 0.1 to 1.5 Hz over the whole range, with other phases"),
    "fast_multisine": (fast_multisine, "a faster multisine from 1 to 6 Hz at small amplitude, where compliance, delay and a "
                                       "mount that sways part in their phase"),
    "one_by_one": (one_by_one, "a multisine of one joint after the other, where what one does to the other shows"),
}  # fmt: skip

# what a trajectory alone may not settle: what it needs (`needs` of an effect), and words for the bench
BEYOND = (
    ("camera", "record the camera's angles too: the link's own angle parts encoder from linkage"),
    ("warmth", "repeat it warm, after ten minutes of motion: what changes with warmth shows"),
    ("rest", "record 10 s at rest with the drives unpowered: the current's zero then shows by itself"),
    ("turned base",
     "repeat a motion with the base turned by 90 degrees: gravity's part changes, a spring's does not"),
    ("known mass",
     "repeat a motion with a known mass at the far end: what grows with load parts from what does not"),
)  # fmt: skip
ANY_MOTION = ("rest", "turned base", "known mass")  # another trajectory would add nothing to them


def by_effect(effects):
    """The entry that suits a cause by the look of it, where nothing can be planned."""
    wanted = {effect.trajectory for effect in known(effects)}
    return next((name for name in reversed(TRAJECTORIES) if name in wanted), "slow_ramps")


def beyond(effects):
    """(what it needs, words) of what else would part these effects, or (None, None)."""
    wanted = {effect.needs for effect in known(effects)}
    return next(((needs, words) for needs, words in BEYOND if needs in wanted), (None, None))
