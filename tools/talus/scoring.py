"""How far a prediction is off, by the library's one scoring rule, and what there is to draw of it.

    unseen = talus.Recording.read("unseen.csv")
    talus.score(model, unseen, talus.predict(model, unseen))["knee"]["relative_percent"]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy
from numpy.typing import ArrayLike

from . import _drawing
from ._arrays import Array, joint_arrays, pointer, same
from ._library import check, ffi, lib
from .identification import Regression, Rows, predict
from .model import Model
from .recording import Recording, channels, score_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


def measured(model: Model, recording: Recording) -> Array:
    """What the recording shows of each joint, (joints, n): torque constant x current [Nm], torque [Nm], force
    [N], or the load sensor's torque [Nm] where there is one.

    >>> model = talus.read("models/leg.yaml")
    >>> talus.measured(model, talus.simulate(model, duration_s=20)).shape
    (2, 5000)
    """
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
    measured_rms, relative_percent, reversal_rms (near standstill), samples and samples_left_out. ValueError where the shape is
    another.

    >>> model = talus.read("models/pendulum.yaml")
    >>> recording = talus.simulate(model, duration_s=20)
    >>> talus.score(model, recording, talus.predict(model, recording))["joint"]["relative_percent"] < 5
    True
    """
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


@dataclass(eq=False)
class Prediction:
    """What `compare` answers: `t` [s] of the recording's rows; `measured` and `predicted`, both (joints, n), in `unit`, as
    talus-predict has them, not filtered; `error` by joint, as `score` gives it. As an array it is `predicted`. Predictions
    compare and pickle.

    >>> model = talus.read("models/pendulum.yaml")
    >>> found = talus.compare(model, talus.simulate(model, duration_s=20))
    >>> numpy.array_equal(found.residual, found.measured - found.predicted)
    True
    """

    joints: list[str]
    unit: str
    t: Array
    measured: Array
    predicted: Array
    error: dict[str, dict[str, float]]

    @property
    def residual(self) -> Array:
        """Measured - predicted, (joints, n)."""
        return self.measured - self.predicted

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return numpy.array(self.predicted, dtype=dtype, copy=copy)

    def __eq__(self, other: object) -> bool:
        return same(vars(self), vars(other)) if isinstance(other, Prediction) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # its arrays can be changed

    def __repr__(self) -> str:
        errors = ", ".join(f"{joint} {error['relative_percent']:.2f} %" for joint, error in self.error.items())
        return f"<talus.Prediction: {len(self.t)} samples, error {errors}>"

    def to_pandas(self) -> DataFrame:
        """A column `time_s`, and for each joint its measured, predicted and residual. ImportError where pandas is missing.

        >>> found = talus.compare(talus.Model.read("models/pendulum.yaml"), talus.Recording.read("arm.csv"))
        >>> list(found.to_pandas())
        ['time_s', 'joint_measured_Nm', 'joint_predicted_Nm', 'joint_residual_Nm']
        """
        columns = {"time_s": self.t}
        for j, joint in enumerate(self.joints):
            columns |= {f"{joint}_{name}_{self.unit}": getattr(self, name)[j] for name in ("measured", "predicted", "residual")}
        return _drawing.frame(columns)

    def plot(self) -> Figure:
        """A figure with two plots a joint: measured and predicted, and below them the residual. ImportError where matplotlib
        is missing.

        >>> found = talus.compare(talus.Model.read("models/pendulum.yaml"), talus.Recording.read("arm.csv"))
        >>> found.plot().savefig("arm.png")
        """
        figure, plots = _drawing.axes(2 * len(self.joints), sharex=True)
        for j, joint in enumerate(self.joints):
            series = {"measured": self.measured[j], "predicted": self.predicted[j]}
            _drawing.over_residuals(plots[2 * j : 2 * j + 2, 0], self.t, series, {"residual": self.residual[j]}, joint, self.unit)
        return figure


def compare(model: Model, recording: Recording) -> Prediction:
    """What the model predicts for a recording beside what was measured, and how far it is off.

    >>> model = talus.read("models/pendulum.yaml")
    >>> found = talus.compare(model, talus.simulate(model, duration_s=20))
    >>> found.residual.shape, found.error["joint"]["relative_percent"] < 5
    ((1, 5000), True)
    """
    predicted = predict(model, recording)
    shown, error = measured(model, recording), score(model, recording, predicted)
    return Prediction(model.joints, model.torque_unit, recording.t, shown, predicted, error)


@dataclass(eq=False)
class Panel:
    """One joint over time as the score sees it (even grid, low-pass): what was measured, what each model
    predicts (by name), and which instants are scored. NaN parts segments. Panels compare, pickle, become data frames and
    pictures.

    >>> model = talus.read("models/pendulum.yaml")
    >>> panel = talus.panels({"as given": model}, talus.simulate(model, duration_s=20))[0]
    >>> bool(numpy.nanstd(panel.residual("as given")) < 0.05 * numpy.nanstd(panel.measured))
    True
    """

    joint: str
    t: Array
    measured: Array
    predicted: dict[str, Array]
    scored: Array
    unit: str = "Nm"
    recording: str = ""

    def residual(self, name: str) -> Array:
        """Measured - predicted where it is scored, NaN elsewhere.

        >>> panel = talus.panels({"as given": talus.read("models/pendulum.yaml")}, talus.read("arm.csv"))[0]
        >>> numpy.array_equal(numpy.isfinite(panel.residual("as given")), panel.scored)
        True
        """
        return numpy.where(self.scored, self.measured - self.predicted[name], numpy.nan)

    def __eq__(self, other: object) -> bool:
        return same(vars(self), vars(other)) if isinstance(other, Panel) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # its arrays can be changed

    def __repr__(self) -> str:
        return f"<talus.Panel: {self.joint}, {self.scored.sum()} instants scored, {', '.join(self.predicted)}>"

    def to_pandas(self) -> DataFrame:
        """Columns recording, joint, time_s, measured, scored, and each model's prediction by its name. ImportError where pandas
        is missing.

        >>> panel = talus.panels({"as given": talus.read("models/pendulum.yaml")}, talus.read("arm.csv"))[0]
        >>> list(panel.to_pandas())
        ['recording', 'joint', 'time_s', 'measured', 'as given', 'scored']
        """
        return _drawing.frame({"recording": self.recording, "joint": self.joint, "time_s": self.t, "measured": self.measured,
                               **self.predicted, "scored": self.scored})  # fmt: skip

    def plot(self) -> Figure:
        """A figure of measured and predicted, and below them the residuals. ImportError where matplotlib is missing.

        >>> panel = talus.panels({"as given": talus.read("models/pendulum.yaml")}, talus.read("arm.csv"))[0]
        >>> [plot.get_ylabel() for plot in panel.plot().axes]
        ['joint [Nm]', 'residual [Nm]']
        """
        figure, plots = _drawing.axes(2, sharex=True)
        residuals = {name: self.residual(name) for name in self.predicted}
        _drawing.over_residuals(plots[:, 0], self.t, {"measured": self.measured, **self.predicted}, residuals, self.joint, self.unit)
        return figure


def panels(models: Mapping[str, Model], recording: Recording) -> list[Panel]:
    """A Panel for each joint; `models` maps names to models that differ in what is identified only.

    >>> model = talus.read("models/leg.yaml")
    >>> [panel.joint for panel in talus.panels({"as given": model}, talus.simulate(model, duration_s=20))]
    ['knee', 'ankle']
    """
    first = next(iter(models.values()))
    rows = Regression(first, recording).rows()
    base = {name: numpy.array(list(model.base.values())) for name, model in models.items()}
    out = []
    for joint, parts in zip(first.joints, rows, strict=True):
        pieces = [_piece(part, base) for part in parts]
        t, shown, scored = (numpy.concatenate([piece[k] for piece in pieces]) for k in range(3))
        predicted = {name: numpy.concatenate([piece[3][name] for piece in pieces]) for name in models}
        out.append(Panel(joint, t, shown, predicted, scored.astype(bool), first.torque_unit))
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
