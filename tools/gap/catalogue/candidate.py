"""A candidate: one effect at one joint with one shape, as columns that are linear in its strengths."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Candidate:
    """`columns` are functions of a scene that return {channel kind: column on the grid}; `low` and `high` the
    physical range of each strength; `parameters(strengths)` the figures that a reader understands. Where `saved`
    is true those are the parameters of the model file's effect of that name."""

    effect: str
    joint: str
    shape: str
    columns: tuple
    parameters: Callable
    low: tuple | None = None
    high: tuple | None = None
    saved: bool = False

    def within_range(self, strengths):
        low = self.low is None or all(x >= limit for x, limit in zip(strengths, self.low))
        return low and (self.high is None or all(x <= limit for x, limit in zip(strengths, self.high)))

    @property
    def key(self):
        return self.effect, self.joint


@dataclass(frozen=True)
class Place:
    """A joint that effects are tried at."""

    number: int
    name: str
    evidence: object
    extent: object
    scenes: list

    @property
    def kinds(self):
        return self.evidence.kinds

    @property
    def coulomb_Nm(self):
        return max(abs(self.scenes[0].coulomb_Nm[self.number]), 1e-12)

    def joint_column(self, function):
        """A column from a torque at the joint."""
        j = self.number
        return lambda scene: {f"T{j}": scene.track.operate(function(scene) / scene.ratio[j], j)}

    def motor_column(self, function):
        """A column from a torque at the motor, or of the reading itself."""
        j = self.number
        return lambda scene: {f"T{j}": scene.track.operate(function(scene), j)}


def named(*names, **constants):
    """Parameters by name: the strengths under `names`, then constants (shapes)."""
    return lambda strengths: {**dict(zip(names, map(float, strengths))), **constants}


def differentiate(x, step_s):
    return np.gradient(x, step_s)


def differentiate_twice(x, step_s):
    out = np.zeros_like(x)
    out[1:-1] = (x[2:] - 2 * x[1:-1] + x[:-2]) / step_s**2
    return out


def link_displaced(scene, j, shift):
    """What shows when the link of joint j stands `shift` (grid, rad) ahead of where the motor's angle says."""
    track, step_s = scene.track, scene.step_s
    rates = differentiate(shift, step_s), differentiate_twice(shift, step_s)
    if not scene.evidence.leg:
        return {"T0": track.lowpass(scene.inertia[0, 0, 0] * rates[1])}
    q, v = ([scene.grid(name, k) for k in range(2)] for name in ("q", "v"))
    a = scene.once("bridged a", lambda: [track.resample(track.bridge(scene.a[k], k)) for k in range(2)])
    small = 1e-3
    moved = [np.array([x[k] + small * d * (k == j) for k in range(2)]) for x, d in zip((q, v, a), (shift, *rates))]
    still = scene.once("links on grid", lambda: scene.links(np.array(q), np.array(v), np.array(a)))
    change = (scene.links(*moved) - still) / small
    shown = {f"T{k}": track.lowpass(change[k] / scene.grid("ratio", k)) for k in range(2)}
    for kind in ("E", "F") if j == 1 else ("K",):
        if kind in scene.evidence.kinds:
            shown[kind] = track.lowpass(shift)
    return shown
