"""Identification from Python: recordings as arrays in, parameters out, by the library's own code.

    recording = talus.Recording.read("train.csv.gz")
    fit = talus.identify(model, [recording], seed=1)
    fit.parameters["foot_com_m"], fit.sigma["foot_com_m"]
    torque = talus.predict(fit.model, recording)         # (joints, n)
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy
from numpy.typing import ArrayLike

from . import _drawing
from ._arrays import Array, pointer, vector
from ._library import TalusError, check, constants, ffi, lib
from .model import Model
from .recording import Recording, channels, score_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

Window = tuple[int, float]  # order, length [s]
SAMPLE_ROWS = 8192  # rows of a recording that its sensing is measured on
LEAST_ROWS = 30  # of a place that tells how the angles are read


@dataclass
class Rows:
    """Scored rows of one joint: time, regressor (n, columns), target, measured, kind, base indices."""

    t: Array
    x: Array
    target: Array
    measured: Array
    kind: Array
    index: list[int]


class Regression:
    """The rows of one recording under one model. `window` (order, length in s) reaches across stops; `window_hz` is the
    low-pass frequency that the windows of the motion suit, the score's where it is not given. How the angles are read is measured
    on the first rows; `liveliest`: where the joint moves most, as the programs do.

    >>> model = talus.read("models/pendulum.yaml")
    >>> regression = talus.Regression(model, talus.simulate(model, duration_s=20))
    >>> rows = regression.rows()[0][0]  # of the first joint, the first segment
    >>> rows.x.shape == (len(rows.t), len(model.base)), regression.motion()["v"].shape
    (True, (1, 5000))
    """

    def __init__(self, model: Model, recording: Recording, window: Window | None = None, window_hz: float | None = None,
                 liveliest: bool = False) -> None:
        recording.check_channels(model)
        self.model, self.recording, self.score = model, recording, score_of(model, recording)
        self.struct = ffi.new("tl_regression *")
        check(lib.tl_regression_init(self.struct, model.struct, recording.recorded, self.score, recording.step_s))
        for joint in range(len(model.joints)):
            self._sense(joint, self._liveliest(joint) if liveliest else self._first(), window, window_hz)
        self._effects = ffi.new("tl_effect[]", model.effects)  # kept: the regression refers to them
        if model.effects:
            check(lib.tl_regression_set_effects(self.struct, self._effects, len(model.effects), recording.t[0]))

    def _first(self) -> tuple[int, int]:
        begin, end = next(iter(self.recording.segments()), (0, len(self.recording.t)))
        return begin, min(end, begin + SAMPLE_ROWS)

    def _liveliest(self, joint: int) -> tuple[int, int]:
        """The place where the joint moves most: a joint at rest shows neither noise nor resolution."""
        segments = list(self.recording.segments())
        held = ffi.new("tl_segment[]", segments)
        places = [lib.tl_sample_place(held, len(segments), k) for k in range(constants.TL_SAMPLE_PLACES) if segments]
        angle = self.recording.columns[_angle_columns(self)[joint]]
        rows = [(place.begin, place.end) for place in places if place.end - place.begin >= LEAST_ROWS]
        if not rows:
            raise ValueError(f"no run of at least {LEAST_ROWS} valid rows without a gap")
        return max(rows, key=lambda place: numpy.ptp(angle[slice(*place)]))

    def _sense(self, joint: int, place: tuple[int, int], window: Window | None, window_hz: float | None) -> None:
        score = ffi.new("tl_score_settings *", self.score[0])
        score.lowpass_hz = window_hz or score.lowpass_hz
        begin, end = place
        work = numpy.empty(lib.tl_kinematics_window_workspace(end - begin))
        sensing = self.struct.sensing + joint
        check(lib.tl_kinematics_window(self.model.struct, ffi.addressof(self.struct, "layout"), joint, score,
                                       self.recording.step_s, self.recording.block(begin, end), pointer(work), len(work),
                                       sensing))  # fmt: skip
        given = self.model.window
        if window or given:
            sensing.window.order, sensing.window.length_s = window or (given.order, given.length_s)
            sensing.across = 1

    def sensing(self, joint: int = 0) -> dict[str, Any]:
        """How the joint's angle is read: dict of order, window_s, quick_s, noise, step, standstill.

        >>> regression = talus.Regression(talus.Model.read("models/pendulum.yaml"), talus.Recording.read("arm.csv"))
        >>> 0 < regression.sensing()["noise"] < 1e-3  # [rad]
        True
        """
        s = self.struct.sensing[joint]
        return {"order": s.window.order, "window_s": s.window.length_s, "quick_s": s.quick.length_s,
                "noise": s.noise, "step": s.step, "standstill": s.standstill}

    def _space(self, rows: int, span_s: float) -> tuple[Any, Any]:
        joints, grid = len(self.model.joints), int(span_s / self.recording.step_s) + 3
        memory = numpy.empty(lib.tl_regression_memory(self.struct, rows, grid))
        mask = numpy.empty(joints * grid, dtype=numpy.uint8)
        stops = ffi.new("tl_stop[]", joints * rows)
        space = ffi.new("tl_regression_space *")
        lib.tl_regression_space_init(space, self.struct, rows, grid, pointer(memory), stops, pointer(mask))
        return space, (memory, mask, stops)

    def _segment(self, begin: int, end: int, with_rows: bool = True) -> tuple[Any, Any]:
        t = self.recording.t
        space, alive = self._space(end - begin, t[end - 1] - t[begin])
        block = self.recording.block(begin, end)
        if with_rows:
            span = ffi.new("tl_span *", [t[begin], t[end - 1], t[begin], float("inf")])
            check(lib.tl_regression_block(self.struct, block, span, space))
        else:
            check(lib.tl_regression_motion(self.struct, block, space))
        return space, (alive, block)

    def rows(self) -> list[list[Rows]]:
        """For each joint, for each segment: Rows.

        >>> model = talus.Model.read("models/pendulum.yaml")
        >>> rows = talus.Regression(model, talus.Recording.read("arm.csv")).rows()[0][0]  # of the first joint, the first segment
        >>> left = rows.target - rows.x @ numpy.array(list(model.base.values()))[rows.index]
        >>> bool(numpy.std(left) < 0.05 * numpy.std(rows.measured))
        True
        """
        out: list[list[Rows]] = [[] for _ in self.model.joints]
        for begin, end in self.recording.segments():
            space, _alive = self._segment(begin, end)
            for joint, parts in enumerate(out):
                parts.append(self._copy_rows(space.rows[joint]))
        return out

    def _copy_rows(self, rows: Any) -> Rows:
        columns, n = rows.columns, rows.n
        x = numpy.array([numpy.frombuffer(ffi.buffer(rows.x + c * rows.stride, 8 * n)) for c in range(columns + 2)])
        kind = numpy.frombuffer(ffi.buffer(rows.kind, n), dtype=numpy.uint8).copy()
        t = rows.begin_s + numpy.arange(n) * self.recording.step_s
        return Rows(t, x[:columns].T, x[columns], x[columns + 1], kind, [rows.index[c] for c in range(columns)])

    def motion(self) -> dict[str, Array]:
        """Joint motion at the recording's rows: dict of (joints, n) arrays q, v, a, slip, speed (NaN outside
        segments).

        >>> arm = talus.Recording.read("arm.csv")
        >>> motion = talus.Regression(talus.Model.read("models/pendulum.yaml"), arm).motion()
        >>> bool(numpy.abs(motion["q"][0] - arm.columns["joint_rad"]).max() < 1e-2)
        True
        """
        names, joints, n = ("q", "v", "a", "slip", "speed"), len(self.model.joints), len(self.recording.t)
        out: dict[str, Array] = {name: numpy.full((joints, n), numpy.nan) for name in names}
        for begin, end in self.recording.segments():
            space, _alive = self._segment(begin, end, with_rows=False)
            for name in names:
                for joint in range(joints):
                    values = ffi.buffer(getattr(space.track, name)[joint], 8 * (end - begin))
                    out[name][joint, begin:end] = numpy.frombuffer(values)
        return out

    def predict(self, base: Mapping[str, float] | ArrayLike) -> Array:
        """What the base parameters predict at the recording's rows, (joints, n); the nearest estimate is
        held where there is none.

        >>> model, arm = talus.Model.read("models/pendulum.yaml"), talus.Recording.read("arm.csv")
        >>> talus.Regression(model, arm).predict(model.base).shape
        (1, 5000)
        """
        t, joints = self.recording.t, len(self.model.joints)
        given = list(base.values()) if isinstance(base, Mapping) else base
        base = vector("base", given, len(self.model.base))
        out, known = numpy.empty((joints, len(t))), numpy.zeros(len(t), dtype=bool)
        for begin, end in self.recording.segments():
            space, _alive = self._segment(begin, end, with_rows=False)
            known[begin:end] = True
            for joint in range(joints):
                out[joint, begin:end] = [
                    lib.tl_regression_predict(space, joint, pointer(base), i) for i in range(end - begin)
                ]
        return out[:, _nearest(t, numpy.flatnonzero(known))]


def _nearest(t: Array, known: Array) -> Array:
    """For each instant the known row that is nearest in time, the earlier of two."""
    after = numpy.clip(numpy.searchsorted(known, numpy.arange(len(t))), 0, len(known) - 1)
    before = numpy.clip(numpy.searchsorted(known, numpy.arange(len(t)), "right") - 1, 0, None)
    last, coming = known[before], known[after]
    return numpy.where((numpy.abs(t - t[last]) <= numpy.abs(t[coming] - t)), last, coming)


def predict(model: Model, recording: Recording, window: Window | None = None) -> Array:
    """What `model` predicts for a recording's rows, (joints, n) in Nm (N on a slider), as talus-predict. `window` as in
    Regression. ValueError names columns that the recording lacks. With what was measured beside it: `compare`.

    >>> model = talus.read("models/leg.yaml")
    >>> talus.predict(model, talus.simulate(model, duration_s=20)).shape
    (2, 5000)
    """
    return Regression(model, recording, window).predict(model.base)


@dataclass
class Fit:
    """What `identify` answers: `model` with the fitted values; by name each of `parameters`, its standard deviation `sigma` and
    whether the data fix it (`identifiable`); `base` and `base_sigma` of what enters linearly; `null_space`, directions in which
    parameters move without a change of torque. tl_identify_result has the meaning of each figure. Fits print themselves,
    compare and pickle.

    >>> model = talus.read("models/pendulum.yaml")
    >>> fit = talus.identify(model, [talus.simulate(model, duration_s=20)])
    >>> fit.sigma["inertia_kg_m2"] < 0.01 * fit.parameters["inertia_kg_m2"], fit.null_space
    (True, [])
    """

    model: Model
    parameters: dict[str, float]
    sigma: dict[str, float]
    identifiable: dict[str, bool]
    base: dict[str, float]
    base_sigma: dict[str, float]
    null_space: list[dict[str, float]]
    cost: float
    least_squares_cost: float
    condition_number: float
    evaluations: int
    noise: list[float] = field(default_factory=list)

    def __str__(self) -> str:
        """A line for each parameter; what the data cannot fix is said."""
        lines = [f"{name:24} {value:12.6g} +- {self.sigma[name]:.2g}" + ("" if self.identifiable[name] else "  (not identifiable)")
                 for name, value in self.parameters.items()]  # fmt: skip
        return "\n".join(lines)

    def to_pandas(self) -> DataFrame:
        """A row for each parameter: value, sigma, identifiable. ImportError where pandas is missing.

        >>> fit = talus.identify(talus.Model.read("models/pendulum.yaml"), [talus.Recording.read("arm.csv")])
        >>> bool(fit.to_pandas().loc["inertia_kg_m2", "identifiable"])
        True
        """
        columns = {name: list(getattr(self, field).values())
                   for name, field in (("value", "parameters"), ("sigma", "sigma"), ("identifiable", "identifiable"))}  # fmt: skip
        return _drawing.frame(columns, list(self.parameters))

    def plot(self) -> Figure:
        """A figure that says how sure each parameter is: three standard deviations in percent of the value, on a logarithmic
        scale. What the data cannot fix has no bar. ImportError where matplotlib is missing.

        >>> fit = talus.identify(talus.Model.read("models/pendulum.yaml"), [talus.Recording.read("arm.csv")])
        >>> len(fit.plot().axes[0].patches) == sum(fit.identifiable.values())
        True
        """
        names = [name for name, known in self.identifiable.items() if known and self.parameters[name] != 0.0]
        figure, plots = _drawing.axes(1)
        plots[0, 0].barh(names, [300.0 * self.sigma[name] / abs(self.parameters[name]) for name in names])
        plots[0, 0].set_xscale("log")
        plots[0, 0].invert_yaxis()
        plots[0, 0].set_xlabel("three standard deviations [% of the value]")
        return figure


def factors(model: Model, recordings: Iterable[Recording], window: Window | None = None) -> tuple[Any, list[list[list[Rows]]]]:
    """One `tl_factor` a joint over all recordings, and the rows themselves."""
    return folded(model, [Regression(model, recording, window, liveliest=True) for recording in recordings])


def folded(model: Model, regressions: Iterable[Regression]) -> tuple[Any, list[list[list[Rows]]]]:
    """The same of regressions that are there already."""
    out = ffi.new("tl_factor[]", len(model.joints))
    every: list[list[list[Rows]]] = []
    for joint in range(len(model.joints)):
        index = ffi.new("int[]", constants.TL_MAX_ROW)
        check(lib.tl_factor_init(out + joint, lib.tl_row_index(model.struct, joint, index)))
    for regression in regressions:
        rows = regression.rows()
        every.append(rows)
        for joint, parts in enumerate(rows):
            for part in parts:
                keep = part.kind == lib.TL_ROW_SCORED
                block = numpy.ascontiguousarray(numpy.column_stack([part.x, part.target])[keep].T)
                if keep.any():
                    lib.tl_factor_add(out + joint, pointer(block), block.shape[1], block.shape[1])
    return out, every


def identify(model: Model, recordings: Iterable[Recording], seed: int = 1, equal_weights: bool = False,
             window: Window | None = None, **swarm: float) -> Fit:
    """Fits the model's parameters to recordings, as talus-identify; the given ones are the first guess. `seed` is the swarm's and
    changes nothing that matters; `equal_weights` takes joints alike instead of by their noise; `window` as in Regression; `swarm`
    sets fields of tl_pso_settings. TalusError where there is too little motion.

    >>> model = talus.read("models/pendulum.yaml")
    >>> guess = model.copy()
    >>> guess.set_parameters(inertia_kg_m2=0.03)
    >>> fit = talus.identify(guess, [talus.simulate(model, duration_s=20)])
    >>> abs(fit.parameters["inertia_kg_m2"] - model.parameters["inertia_kg_m2"]) < 5 * fit.sigma["inertia_kg_m2"]
    True
    """
    recordings = list(recordings)
    factor, every = factors(model, recordings, window)
    settings = ffi.new("tl_identify_settings *", lib.tl_identify_defaults())
    settings.swarm.seed = seed
    settings.weighting = lib.TL_WEIGHT_EQUAL if equal_weights else lib.TL_WEIGHT_NOISE
    for name, value in swarm.items():
        setattr(settings.swarm, name, value)
    problem, result = ffi.new("tl_problem *"), ffi.new("tl_identify_result *")
    check(lib.tl_problem_init(problem, model.struct, settings, factor))
    best, evaluations, spent = numpy.empty(problem.parameters), 0, ffi.new("uint64_t *")
    for _ in range(4):
        memory = numpy.empty(lib.tl_identify_memory(problem))
        check(lib.tl_identify_swarm(problem, pointer(memory), len(memory), pointer(best), spent))
        evaluations += spent[0]
        if not lib.tl_problem_widen(problem, pointer(best)):
            break
    check(lib.tl_identify_conclude(problem, pointer(best), result))
    if _sigmas(problem, result, every):
        check(lib.tl_identify_readings(problem, _Rereading(problem, model, recordings, window).read(), result))
    return _fit(model, problem, result, evaluations)


def _sigmas(problem: Any, result: Any, every: list[list[list[Rows]]], block_s: float = 0.5) -> bool:
    """False where there is too little data for standard deviations."""
    sandwich = ffi.new("tl_sandwich *")
    check(lib.tl_sandwich_init(sandwich, problem.bases, block_s))
    base = numpy.array([result.base[i] for i in range(problem.bases)])
    for rows in every:
        for parts in zip(*rows):
            for k in range(len(parts[0].t)):
                for joint, part in enumerate(parts):
                    if part.kind[k] != lib.TL_ROW_SCORED:
                        continue
                    x = numpy.ascontiguousarray(part.x[k])
                    residual = part.target[k] - x @ base[part.index]
                    lib.tl_sandwich_add(sandwich, part.t[k], pointer(x), 1, part.index, len(part.index),
                                        problem.weight[joint], residual)
            lib.tl_sandwich_close(sandwich)
    try:
        check(lib.tl_identify_sigma(problem, sandwich, result))
    except TalusError as error:
        if error.status != lib.TL_ERR_TOO_SHORT:
            raise
        return False
    return True


# ---- what residuals do not show ---------------------------------------------


def _angle_columns(regression: Regression) -> list[str]:
    """The column that tells each joint's motion."""
    layout, names = regression.struct.layout, {number: name for name, number in channels().items()}
    pairs = [(layout.position[j], layout.velocity[j]) for j in range(len(regression.model.joints))]
    return [names[position if position in names else velocity] for position, velocity in pairs]


def _rounded(regression: Regression, number: int) -> Regression:
    """The same recording with its angles rounded (tl_round_angles), read as before."""
    columns = dict(regression.recording.columns)
    for joint, name in enumerate(_angle_columns(regression)):
        columns[name] = numpy.array(columns[name])
        noise = regression.struct.sensing[joint].noise
        lib.tl_round_angles(pointer(columns[name]), len(columns[name]), noise, number, joint)
    return _as_before(regression, Recording(columns), 1.0)


def _as_before(regression: Regression, recording: Recording, window_factor: float) -> Regression:
    """A recording read as another was, with windows so many times as long."""
    other = copy.copy(regression)
    recording.step_s = regression.recording.step_s
    other.recording, other.struct = recording, ffi.new("tl_regression *", regression.struct[0])
    for joint in range(len(regression.model.joints)):
        other.struct.sensing[joint].window.length_s *= window_factor
    return other


def _excerpt(recording: Recording, place_rows: int, every: int) -> Recording:
    """Every so-manieth sample of the places that long recordings are read again in, as the programs' recording_excerpt."""
    n = len(recording.t)
    begins = [lib.tl_reading_place(n, place_rows, k) for k in range(constants.TL_READING_PLACES)]
    if place_rows * len(begins) >= n:
        begins, place_rows = [0], n
    rows = numpy.concatenate([numpy.arange(begin, begin + place_rows, every) for begin in begins])
    return recording.with_columns({name: values[rows] for name, values in recording.columns.items()})


class _Rereading:
    """The recordings read once more in every way that tl_identify_readings asks for."""

    def __init__(self, problem: Any, model: Model, recordings: list[Recording], window: Window | None) -> None:
        self.problem, self.model, self.recordings, self.window = problem, model, recordings, window
        self.rows = sum(len(recording.t) for recording in recordings)
        self.readings = ffi.new("tl_readings *")

    def fold(self, regressions: list[Regression], out: Any) -> None:
        check(lib.tl_problem_merge(self.problem, folded(self.model, regressions)[0], out))

    def excerpts(self, whole: bool, every: int) -> list[Recording]:
        short = whole or self.rows <= constants.TL_READING_ROWS
        return [_excerpt(one, len(one.t) if short else lib.tl_reading_place_rows(len(one.t), self.rows), every)
                for one in self.recordings]  # fmt: skip

    def plain(self, whole: bool) -> list[Regression]:
        """The excerpts, read as the whole recordings are."""
        every = [Regression(self.model, one, self.window, liveliest=True) for one in self.recordings]
        return [_as_before(one, excerpt, 1.0) for one, excerpt in zip(every, self.excerpts(whole, 1), strict=True)]

    def is_fair(self, plain: list[Regression]) -> bool:
        """Are the excerpts a fair picture of the recordings? Folds them as they were recorded."""
        if not all(any(True for _ in one.recording.segments()) for one in plain):
            return False
        share = ffi.new("double *")
        self.fold(plain, ffi.addressof(self.readings, "as_recorded"))
        check(lib.tl_reading_share(self.problem, ffi.addressof(self.readings, "as_recorded"), share))
        return bool(share[0] >= constants.TL_READING_SHARE)

    def read(self) -> Any:
        """The `tl_readings`."""
        whole = self.rows <= constants.TL_READING_ROWS
        plain = self.plain(whole)
        if not self.is_fair(plain) and not whole:
            whole = True
            plain = self.plain(whole)
            self.fold(plain, ffi.addressof(self.readings, "as_recorded"))
        for number in range(constants.TL_ROUNDINGS):
            self.fold([_rounded(one, number) for one in plain], self.readings.rounded + number)
        longer = [_as_before(one, one.recording, constants.TL_LONGER_WINDOW) for one in plain]
        self.fold(longer, ffi.addressof(self.readings, "longer"))
        self._read_thinned(whole)
        return self.readings

    def _read_thinned(self, whole: bool) -> None:
        try:
            thinned = [Regression(self.model, one, self.window, liveliest=True)
                       for one in self.excerpts(whole, constants.TL_THINNED)]  # fmt: skip
        except (TalusError, ValueError, StopIteration):
            return  # too short or too slow for it
        self.fold(thinned, ffi.addressof(self.readings, "thinned"))


def _fit(model: Model, problem: Any, result: Any, evaluations: int) -> Fit:
    names, bases = list(model.parameters), list(model.base)
    fitted = model.copy()
    fitted.set_parameters(**{name: result.value[i] for i, name in enumerate(names)})
    null_space = [
        {name: result.null_direction[k][i] for i, name in enumerate(names) if abs(result.null_direction[k][i]) > 1e-9}
        for k in range(result.null_count)
    ]
    return Fit(
        fitted,
        fitted.parameters,
        {name: result.sigma[i] for i, name in enumerate(names)},
        {name: bool(result.identifiable[i]) for i, name in enumerate(names)},
        {name: result.base[i] for i, name in enumerate(bases)},
        {name: result.base_sigma[i] for i, name in enumerate(bases)},
        null_space,
        result.cost,
        result.least_squares_cost,
        result.condition_number,
        evaluations,
        [problem.noise[j] for j in range(problem.joints)],
    )
