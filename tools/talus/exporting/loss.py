"""Each effect's torque along a motion, by the library's own prediction with and without it, and what a target leaves of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import lsq_linear

import talus
from talus import Model, Recording
from talus._arrays import Array
from talus._library import TalusError

from . import chain, terms

SECONDS = 20.0  # of the motion where none is given
LINEAR = ("coulomb_Nm", "viscous_Nms_rad")  # may not fall below 0 with the model's own


@dataclass(frozen=True)
class Motion:
    """Moving rows of a recording: (joints, n) arrays of position, velocity, direction of slip, and the ratio to the joint."""

    recording: Recording
    rows: list[Array]
    q: Array
    v: Array
    slip: Array
    ratio: Array


def default_recording(model: Model) -> Recording:
    """Twenty seconds of the plain model on the simulated bench, with exact sensors."""
    plain = model.copy()
    plain.effects = []
    return talus.simulate(plain, duration_s=SECONDS, ideal=True)


def along(model: Model, recording: Recording) -> Motion:
    plain = model.copy()
    plain.effects = []
    moved = talus.Regression(plain, recording).motion()
    speed = np.nan_to_num(moved["speed"])
    rows = [np.flatnonzero(abs(x) > model.score.standstill) for x in speed]
    ratio = np.array([chain.ratios(model, j, np.nan_to_num(q)) for j, q in enumerate(moved["q"])])
    return Motion(recording, rows, np.nan_to_num(moved["q"]), np.nan_to_num(moved["v"]), np.sign(np.nan_to_num(moved["v"])), ratio)


def torque_of(model: Model, number: int, motion: Motion) -> Array | str:
    """What effect `number` adds to the torque at each joint, (joints, n); or why this motion cannot say."""
    without = model.copy()
    without.effects = [e for k, e in enumerate(model.effects) if k != number]
    try:
        added = talus.predict(model, motion.recording) - talus.predict(without, motion.recording)
    except TalusError as error:
        return f"this motion's columns do not tell it: {error}"
    return np.asarray(added * motion.ratio)


def of_plain(model: Model, held: Model, motion: Motion) -> Array:
    """What a plain model's torque is off when it is computed with another, at each joint."""
    return np.asarray((talus.predict(_bare(model), motion.recording) - talus.predict(_bare(held), motion.recording)) * motion.ratio)


def _bare(model: Model) -> Model:
    out = model.copy()
    out.effects = []
    return out


def rms(torque: Array, rows: list[Array]) -> list[float]:
    """Of each joint's moving rows."""
    return [float(np.sqrt(np.mean(x[r] ** 2))) if len(r) else 0.0 for x, r in zip(torque, rows, strict=True)]


def fitted(torque: Array, joint: int, motion: Motion, names: tuple[str, ...], low: dict[str, float]) -> dict[str, float]:
    """The terms that come nearest to a torque along the moving rows; `low` is the least that each may be."""
    rows = motion.rows[joint]
    if not len(rows) or not np.any(torque[rows]) or not names:
        return {}
    q, v, slip = (x[joint][rows] for x in (motion.q, motion.v, motion.slip))
    columns = np.column_stack([terms.COLUMNS[name](q, v, slip) for name in names])
    found = lsq_linear(columns, torque[rows], (np.array([low.get(name, -np.inf) for name in names]) - 1e-15, np.inf)).x
    return dict(zip(names, map(float, found), strict=True))


def sum_of(found: dict[str, float], joint: int, motion: Motion) -> Array:
    """The torque of terms at a joint, along all rows."""
    q, v, slip = motion.q[joint], motion.v[joint], motion.slip[joint]
    return np.asarray(sum((number * terms.COLUMNS[name](q, v, slip) for name, number in found.items()), np.zeros_like(q)))


def entry(effect: str, joint: str, how: str, **more: Any) -> dict[str, Any]:
    return {"effect": effect, "joint": joint, "how": how, **more}
