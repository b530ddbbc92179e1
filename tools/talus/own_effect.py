"""An effect of one's own: a Python function that a diagnosis tries beside its catalogue.

    detent = talus.Effect("detent", "a magnetic detent", ("sine_Nm", "cosine_Nm"),
                          lambda segment, joint: numpy.array([numpy.sin(7 * segment.q[joint]), numpy.cos(7 * segment.q[joint])]).T)
    talus.diagnose(model, recordings, effects=[detent])
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real

import numpy
from numpy.typing import ArrayLike

from ._arrays import Array
from ._library import InputError, ffi, lib

ID = r"[a-z][a-z0-9]*(_[a-z0-9]+)*"
NO_EFFECTS = ("none", "unknown")  # what a verdict says instead of an effect


@dataclass(frozen=True, eq=False)
class Segment:
    """A run of samples without a gap, as an Effect's function sees it: the motion, and what the identified model makes of it, never
    the measured torque. `t_s` is (n,), all else (joints, n), read-only; `joints` are their names. For a slider read m for rad and
    N for Nm.

    >>> t = numpy.linspace(0, 1, 5)
    >>> zero = numpy.zeros((1, 5))
    >>> segment = talus.Segment(("joint",), t, t[None], zero + 1, zero, zero + 1, zero, zero, 9 * t[None], zero)
    >>> segment.q[segment.joints.index("joint")].tolist()
    [0.0, 0.25, 0.5, 0.75, 1.0]
    """

    joints: tuple[str, ...]
    t_s: Array
    """Time since the recording's begin [s]."""
    q: Array
    """Angle of each joint [rad]; NaN where only speeds were recorded."""
    v: Array
    """Speed [rad/s]."""
    a: Array
    """Acceleration [rad/s^2]."""
    slip: Array
    """Direction of friction, from -1 to 1; between them where the joint stands or turns round."""
    load_Nm: Array
    """What the identified model delivers to inertia and gravity."""
    friction_Nm: Array
    """The identified model's friction."""
    motor_rad: Array
    """Angle of each motor [rad]; NaN where only speeds were recorded."""
    temp_C: Array
    """Temperature of each drive, smoothed [C]; NaN where it was not recorded."""


@dataclass(frozen=True, eq=False)
class Effect:
    """An effect of one's own for `diagnose(..., effects=[...])`. It is tried at every joint, in every shape, beside those of the
    catalogue and judged as they are.

    `id` stands in reports as the catalogue's ids do: lower case, with underscores, and not one of those. `title` is what it is, as
    it stands after "The gap comes from". `parameters` name its strengths, which a fit finds, each ending in its unit. `torque` is
    the law: `torque(segment, joint, **shape)`, with a Segment and the number of the joint, returns an array (n, parameters), or
    (n,) of a single parameter: the joint torque [Nm] (of a slider force [N]) that the actuator must supply beyond the model's per
    unit of each parameter. It is called for each segment by itself, for whatever motion, often; what it sees it must leave
    as it is. `shapes` are the values of its further arguments that are tried. InputError where one of these is wrong, and where
    the function fails, returns another shape, or NaN or infinity.

    >>> def detent(segment, joint, per_turn):
    ...     angle = per_turn * segment.q[joint]
    ...     return numpy.stack([numpy.sin(angle), numpy.cos(angle)], axis=1)
    >>> talus.Effect("detent", "a magnetic detent", ("sine_Nm", "cosine_Nm"), detent, [{"per_turn": k} for k in (5, 7, 9)])
    <talus.Effect: detent, 2 parameters, 3 shapes>
    """

    id: str
    title: str
    parameters: Sequence[str]
    torque: Callable[..., ArrayLike]
    shapes: Sequence[Mapping[str, float]] = ({},)

    def __post_init__(self) -> None:
        self._check_names()
        if not callable(self.torque):
            raise self._wrong(f"torque: expected a function, found {self.torque!r}")
        if not self.shapes or isinstance(self.shapes, Mapping):
            raise self._wrong("shapes: expected one dict or more in a list, [{}] where there is nothing to try")
        for shape in self.shapes:
            self._check_shape(shape)

    def __repr__(self) -> str:
        return f"<talus.Effect: {self.id}, {len(self.parameters)} parameters, {len(self.shapes)} shapes>"

    def columns(self, segment: Segment, joint: int, shape: Mapping[str, float]) -> Array:
        """What the function returns, (n, parameters), checked: a trial of it before a diagnosis.

        >>> t = numpy.linspace(0, 1, 5)
        >>> zero = numpy.zeros((1, 5))
        >>> segment = talus.Segment(("joint",), t, t[None], zero + 1, zero, zero + 1, zero, zero, 9 * t[None], zero)
        >>> drag = talus.Effect("drag", "drag of the air", ("drag_Nms2",), lambda segment, joint: segment.v[joint] * abs(segment.v[joint]))
        >>> drag.columns(segment, 0, {}).ravel().tolist()
        [1.0, 1.0, 1.0, 1.0, 1.0]
        """
        try:
            returned = self.torque(segment, joint, **shape)
        except Exception as error:
            raise self._wrong(f"its function raised {type(error).__name__}: {error}") from error
        try:
            values = numpy.asarray(returned, dtype=float)
        except (TypeError, ValueError):
            raise self._wrong(f"its function returned no array of numbers: {type(returned).__name__}") from None
        wanted = (len(segment.t_s), len(self.parameters))
        if values.shape == wanted[:1] and wanted[1] == 1:
            values = values[:, None]
        if values.shape != wanted:
            raise self._wrong(f"its function returned an array of shape {values.shape}, expected {wanted}: samples, parameters")
        self._check_finite(values, segment, joint)
        return values

    # ---- checks --------------------------------------------------------------------

    def _wrong(self, text: str) -> InputError:
        return InputError(f"effect {self.id!r}: {text}")

    def _check_names(self) -> None:
        if not isinstance(self.id, str) or not re.fullmatch(ID, self.id) or self.id in NO_EFFECTS:
            raise self._wrong("id: expected lower-case words with underscores between them, other than none and unknown")
        if lib.tl_effect_find(self.id.encode()) != ffi.NULL:
            raise self._wrong("id: the catalogue has an effect of that name")
        if not isinstance(self.title, str) or not self.title.strip():
            raise self._wrong("title: expected what it is in words")
        if isinstance(self.parameters, str) or not self.parameters:
            raise self._wrong('parameters: expected one name or more in a tuple, such as ("moment_Nm",)')
        for name in self.parameters:
            if not isinstance(name, str) or not name.isidentifier():
                raise self._wrong(f"parameters: expected names with units, such as moment_Nm, found {name!r}")
        if len(set(self.parameters)) < len(self.parameters):
            raise self._wrong("parameters: a name stands there twice")

    def _check_shape(self, shape: Mapping[str, float]) -> None:
        if not isinstance(shape, Mapping) or set(shape) != set(self.shapes[0]) or set(shape) & set(self.parameters):
            raise self._wrong(f"shapes: expected dicts with the same names, none of them a parameter's, found {shape!r}")
        for name, value in shape.items():
            if not isinstance(value, Real) or not numpy.isfinite(float(value)):
                raise self._wrong(f"shapes: {name}: expected a finite number, found {value!r}")

    def _check_finite(self, values: Array, segment: Segment, joint: int) -> None:
        bad = numpy.argwhere(~numpy.isfinite(values))
        if not len(bad):
            return
        row, column = bad[0]
        lacking = [name for name in ("q", "motor_rad", "temp_C") if numpy.isnan(getattr(segment, name)[joint]).all()]
        why = f"; not recorded of the {segment.joints[joint]}: {', '.join(lacking)}" if lacking else ""
        raise self._wrong(f"its function returned {values[row, column]} for {self.parameters[column]} at "
                          f"{segment.t_s[row]:.6g} s, expected finite numbers{why}")  # fmt: skip
