"""How far a prediction is off, by the library's one scoring rule, and what there is to draw of it.

    unseen = talus.Recording.read("unseen.csv")
    talus.score(model, unseen, talus.predict(model, unseen))["knee"]["relative_percent"]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy
from numpy.typing import ArrayLike

from ._arrays import Array, joint_arrays, pointer
from ._library import check, ffi, lib
from .identification import Regression, Rows
from .model import Model
from .recording import Recording, channels, score_of


def measured(model: Model, recording: Recording) -> Array:
    """What the recording shows of each joint, (joints, n): torque constant x current [Nm], torque [Nm], force
    [N], or the load sensor's torque [Nm] where there is one."""
    regression = Regression(model, recording)  # keeps the memory that its layout lies in
    layout = regression.struct.layout
    name = {number: column for column, number in channels().items()}
    if layout.load != lib.TL_CHANNEL_COUNT:
        return recording.columns[name[layout.load]][None, :].copy()
    return numpy.array(
        [layout.effort_scale[j] * recording.columns[name[layout.effort[j]]] for j in range(len(model.joints))]
    )


def score(model: Model, recording: Recording, predicted: ArrayLike) -> dict[str, dict[str, float]]:
    """The error of `predicted`, (joints, n) at the recording's rows, for each joint: a dict with rms,
    measured_rms, relative_percent, reversal_rms (near standstill), samples and samples_left_out."""
    (predicted,) = map(numpy.atleast_2d, joint_arrays(len(model.joints), predicted=predicted))
    shown, speed = measured(model, recording), numpy.nan_to_num(Regression(model, recording).motion()["speed"])
    if predicted.shape != shown.shape:
        raise ValueError(f"predicted: expected shape {shown.shape} as the recording has rows, found {predicted.shape}")
    valid = None if recording.valid is None else (recording.valid != 0).astype(numpy.uint8)
    work, result = numpy.empty(lib.tl_score_workspace(len(recording.t))), ffi.new("tl_score_result *")
    out = {}
    for j, joint in enumerate(model.joints):
        rows = [numpy.ascontiguousarray(x[j], dtype=float) for x in (shown, predicted, speed)]
        check(lib.tl_score(score_of(model, recording), pointer(recording.t), pointer(valid), *map(pointer, rows),
                           len(recording.t), pointer(work), len(work), result))  # fmt: skip
        out[joint] = {"rms": result.residual_rms, "measured_rms": result.measured_rms,
                      "relative_percent": result.relative_percent, "reversal_rms": result.reversal_rms,
                      "samples": result.scored, "samples_left_out": result.left_out}  # fmt: skip
    return out


@dataclass
class Panel:
    """One joint over time as the score sees it (even grid, low-pass): what was measured, what each model
    predicts, and which instants are scored. NaN parts segments."""

    joint: str
    t: Array
    measured: Array
    predicted: dict[str, Array]
    scored: Array

    def residual(self, name: str) -> Array:
        """Measured - predicted where it is scored, NaN elsewhere."""
        return numpy.where(self.scored, self.measured - self.predicted[name], numpy.nan)


def panels(models: Mapping[str, Model], recording: Recording) -> list[Panel]:
    """A Panel for each joint; `models` maps names to models that differ in what is identified only."""
    first = next(iter(models.values()))
    rows = Regression(first, recording).rows()
    base = {name: numpy.array(list(model.base.values())) for name, model in models.items()}
    out = []
    for joint, parts in zip(first.joints, rows, strict=True):
        pieces = [_piece(part, base) for part in parts]
        t, shown, scored = (numpy.concatenate([piece[k] for piece in pieces]) for k in range(3))
        predicted = {name: numpy.concatenate([piece[3][name] for piece in pieces]) for name in models}
        out.append(Panel(joint, t, shown, predicted, scored.astype(bool)))
    return out


def _piece(part: Rows, base: Mapping[str, Array]) -> tuple[Array, Array, Array, dict[str, Array]]:
    """One segment, and a row of nothing behind it."""
    predicted = {
        name: _end(part.measured - part.target + part.x @ values[part.index]) for name, values in base.items()
    }
    scored = numpy.append(part.kind == lib.TL_ROW_SCORED, False)
    return numpy.append(part.t, part.t[-1] if len(part.t) else 0.0), _end(part.measured), scored, predicted


def _end(x: Array) -> Array:
    return numpy.append(x, numpy.nan)
