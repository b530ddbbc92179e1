"""A recording as columns: from a file by the programs' own reader, or from arrays.

    recording = talus.Recording.read("train.csv.gz")
    recording.columns["knee_current_A"]
    talus.Recording({"time_s": t, "joint_rad": q, "joint_current_A": i})
"""

from __future__ import annotations

import gzip
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy
from numpy.typing import ArrayLike

from . import _drawing, outputs
from ._arrays import Array, pointer
from ._library import InputError, check, check_file, ffi, files, lib
from .importing import headers
from .model import Model, plants, score_settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

ROWS_AT_ONCE = 20_000  # that are turned into text


def channels() -> dict[str, int]:
    """Column name -> channel number.

    >>> "knee_current_A" in talus.channels()
    True
    """
    return {ffi.string(lib.tl_channel_name(c)).decode(): c for c in range(lib.TL_CHANNEL_COUNT)}


def channel_set(model: Model) -> Any:
    """What a model's recordings hold: a `tl_channel_set` of masks of channels.

    >>> held = talus.channel_set(talus.read("models/pendulum.yaml"))
    >>> bool(held.known >> talus.channels()["joint_rad"] & 1)
    True
    """
    held = ffi.new("tl_channel_set *")
    check(lib.tl_channel_set_of(model.struct.plant, held))
    return held


def score_of(model: Model, recording: Recording) -> Any:
    """The scoring rule: the recording's own where one was given, else that of the model's file."""
    return recording.score if recording.has_score else model.score


@dataclass(frozen=True)
class Origin:
    """The file that a recording is a stretch of: its name, when it begins and how long it is. None's is the recording itself."""

    path: str | None
    begin_s: float
    length_s: float


def _fields(struct: Any) -> dict[str, Any]:
    """A C struct's numbers by name."""
    return {name: getattr(struct, name) for name in dir(struct)}


class Recording:
    """Columns of one recording, by the contract's names, as float arrays of one length. `score` is a mapping with keys of
    a model file's `score:`, and goes before that of the model. ValueError names the column that has another length, values that
    are not finite, times that do not rise, or a known column in another unit ("joint_deg"). Other columns are not read, as in
    a file: a UserWarning names them.

    >>> t = numpy.arange(500) / 250
    >>> talus.Recording({"time_s": t, "joint_rad": numpy.sin(t), "joint_current_A": numpy.cos(t)})
    <talus.Recording: 500 samples in 1.996 s, time_s, joint_rad, joint_current_A>
    """

    def __init__(self, columns: Mapping[str, ArrayLike] | DataFrame, score: Mapping[str, float] | None = None) -> None:
        known = channels()
        self._check_names([str(name) for name in columns if name not in known], [name for name in known if name in columns])
        self.columns: dict[str, Array] = {str(n): numpy.ascontiguousarray(x, dtype=float) for n, x in columns.items() if n in known}
        self._check_columns()
        self.t = self.columns["time_s"]
        self.valid = self.columns.get("valid")
        self.has_score, self._score = score is not None, score_settings(score)
        self.origin = Origin(None, float(self.t[0]), float(self.t[-1] - self.t[0]))
        self.recorded = sum(1 << known[name] for name in self.columns)
        self.step_s = lib.tl_median_step(pointer(self.t), len(self.t), pointer(numpy.empty(len(self.t) - 1)))

    def __reduce__(self) -> tuple[Any, ...]:
        return Recording, (self.columns, _fields(self._score) if self.has_score else None)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Recording):
            return NotImplemented
        same = list(self.columns) == list(other.columns) and self.has_score == other.has_score
        return same and _fields(self._score) == _fields(other._score) and all(  # not by bytes: a struct has gaps
            numpy.array_equal(x, other.columns[name]) for name, x in self.columns.items())  # fmt: skip

    __hash__ = None  # type: ignore[assignment]  # its arrays can be changed

    def __repr__(self) -> str:
        return f"<talus.Recording: {len(self.t)} samples in {self.t[-1] - self.t[0]:.3f} s, {', '.join(self.columns)}>"

    @staticmethod
    def _check_names(unknown: list[str], there: list[str]) -> None:
        """What is not known is told, and refused where it stands in the place of a column that is."""
        wanted = {headers.split(name)[0]: name for name in channels() if name not in there}
        for name in unknown:
            quantity, unit = headers.split(name)
            if unit is not None and quantity in wanted:
                raise ValueError(f"{name}: is not known, expected {wanted[quantity]}; known columns are {', '.join(channels())}")
        if unknown:
            warnings.warn(f"columns not known and not read: {', '.join(unknown)}; known are {', '.join(channels())}", stacklevel=3)

    def _check_columns(self) -> None:
        if "time_s" not in self.columns:
            raise ValueError(f"time_s: expected this column, found {', '.join(self.columns) or 'none that is known'}")
        n = self.columns["time_s"].shape
        for name, values in self.columns.items():
            if values.ndim != 1 or values.shape != n or len(values) < 2:
                raise ValueError(f"{name}: expected shape {n} as time_s, one number a sample and two samples at the least, "
                                 f"found {values.shape}")  # fmt: skip
            if not numpy.isfinite(values).all():
                raise ValueError(f"{name}: expected finite numbers, found {values[~numpy.isfinite(values)][0]} at row "
                                 f"{numpy.flatnonzero(~numpy.isfinite(values))[0]}")  # fmt: skip
        late = numpy.flatnonzero(numpy.diff(self.columns["time_s"]) <= 0)
        if len(late):
            raise ValueError(f"time_s: expected times that rise, found none at row {late[0] + 1}")
        if not numpy.isin(self.columns.get("valid", 1.0), (0.0, 1.0)).all():
            raise ValueError("valid: expected 0 or 1")

    @classmethod
    def read(cls, path: str | Path, score: Mapping[str, float] | None = None, model: Model | None = None) -> Recording:
        """From a CSV file (also .gz), by the programs' reader: InputError names file and line of what is wrong. Without a
        model the columns tell whose recording it is.

        >>> talus.Recording.read("arm.csv").columns["joint_rad"].shape
        (5000,)
        """
        with RecordingFile(path, model) as file:
            return cls(file.columns(), score)

    @property
    def score(self) -> Any:
        """A `tl_score_settings`."""
        return self._score

    @score.setter
    def score(self, settings: Any) -> None:
        self._score, self.has_score = settings, True

    def head(self, rows: int) -> Recording:
        """The first rows, with the same scoring.

        >>> len(talus.Recording.read("arm.csv").head(1000).t)
        1000
        """
        if len(self.t) <= rows:
            return self
        return self.with_columns({name: x[:rows] for name, x in self.columns.items()})

    def with_columns(self, columns: Mapping[str, ArrayLike]) -> Recording:
        """Other columns, or other rows of these, with the same scoring.

        >>> arm = talus.Recording.read("arm.csv")
        >>> turned = arm.with_columns({**arm.columns, "joint_rad": -arm.columns["joint_rad"]})
        >>> turned.step_s == arm.step_s
        True
        """
        out = Recording(columns)
        out._score, out.has_score = self._score, self.has_score
        return out

    def check_channels(self, model: Model) -> None:
        """ValueError names the columns that the model's recordings need and this one lacks.

        >>> arm = talus.Recording.read("arm.csv")
        >>> arm.check_channels(talus.Model.read("models/pendulum.yaml"))
        >>> arm.check_channels(talus.Model.read("models/slider.yaml"))
        Traceback (most recent call last):
        ValueError: the recording lacks slider_m, slider_force_N (a slider's needs it)
        """
        held, names = channel_set(model), {number: name for name, number in channels().items()}
        sets = [1 << c for c in names if held.required >> c & 1] + [x for x in held.any_of if x]
        lacking = [" or ".join(names[c] for c in names if x >> c & 1) for x in sets if not x & self.recorded]
        if lacking:
            raise ValueError(f"the recording lacks {', '.join(lacking)} (a {model.plant}'s needs it)")

    def text(self) -> Iterator[bytes]:
        """The recording as the programs read it, in pieces of bytes: each number in the fewest digits that give it back.

        >>> next(talus.Recording.read("arm.csv").text())
        b'time_s,joint_rad,joint_current_A\\n'
        """
        yield (",".join(self.columns) + "\n").encode()
        for first in range(0, len(self.t), ROWS_AT_ONCE):
            rows = zip(*(values[first : first + ROWS_AT_ONCE].tolist() for values in self.columns.values()), strict=True)
            yield "".join(",".join(map(repr, row)) + "\n" for row in rows).encode()

    def write(self, path: str | Path) -> None:
        """To a CSV file (compressed where the name ends in .gz), whole or not at all; read back it is the same, bit by bit.

        >>> arm = talus.Recording.read("arm.csv")
        >>> arm.write("again.csv.gz")
        >>> talus.Recording.read("again.csv.gz") == arm
        True
        """
        outputs.write(path, self.text())

    def to_pandas(self) -> DataFrame:
        """The columns as a data frame; talus.Recording(frame) is the recording again. ImportError where pandas is missing.

        >>> arm = talus.Recording.read("arm.csv")
        >>> arm.to_pandas().shape, talus.Recording(arm.to_pandas()) == arm
        ((5000, 3), True)
        """
        return _drawing.frame(self.columns)

    def plot(self) -> Figure:
        """A figure with one plot a column over time. ImportError where matplotlib is missing.

        >>> arm = talus.Recording.read("arm.csv")
        >>> [plot.get_ylabel() for plot in arm.plot().axes]
        ['joint_rad', 'joint_current_A']
        """
        names = [name for name in self.columns if name != "time_s"]
        figure, plots = _drawing.axes(len(names), sharex=True)
        for name, plot in zip(names, plots[:, 0], strict=True):
            _drawing.lines(plot, self.t, {name: self.columns[name]}, name)
        plots[-1, 0].set_xlabel("time [s]")
        return figure

    def segments(self) -> Iterator[tuple[int, int]]:
        """Row ranges [begin, end) without gap or change of `valid`.

        >>> t = numpy.arange(500) / 250
        >>> t[200:] += 3.0
        >>> list(talus.Recording({"time_s": t, "joint_rad": numpy.sin(t)}).segments())
        [(0, 200), (200, 500)]
        """
        mask = ffi.NULL if self.valid is None else pointer((self.valid != 0).astype(numpy.uint8))
        cursor, part = ffi.new("size_t *"), ffi.new("tl_segment *")
        while lib.tl_segment_next(pointer(self.t), mask, len(self.t), self.step_s, cursor, part):
            yield part.begin, part.end

    def block(self, begin: int, end: int) -> Any:
        """A `tl_block` of rows [begin, end); keep the recording alive while it is used.

        >>> arm = talus.Recording.read("arm.csv")
        >>> block = arm.block(1000, 1200)
        >>> block.n, block.t_s[0] == float(arm.t[1000])
        (200, True)
        """
        block = ffi.new("tl_block *")
        block.n, block.t_s = end - begin, pointer(self.t) + begin
        for name, number in channels().items():
            if name in self.columns:
                block.channel[number] = pointer(self.columns[name]) + begin
        return block


def _plant_of(path: str | Path) -> str:
    """The plant whose columns stand in a file's header."""
    opener = gzip.open if str(path).endswith(".gz") else open
    try:
        with opener(path, "rt", encoding="utf-8", errors="replace") as file:
            header = next((line for line in file if line.strip() and not line.startswith("#")), "")
    except (OSError, EOFError) as error:
        raise InputError(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    named = sum(1 << number for name, number in channels().items() if name in {x.strip() for x in header.split(",")})
    return max(plants(), key=lambda plant: bin(channel_set(Model(plant)).known & named).count("1"))


class RecordingFile:
    """A recording's file, checked and held open outside of memory, of which any rows can be had."""

    def __init__(self, path: str | Path, model: Model | None = None) -> None:
        model = model or Model(_plant_of(path))
        self.path, self._error = str(path), ffi.new("struct app_error *")
        self._held = files().recording_open(self.path.encode(), model.struct.plant, self._error)
        check_file(0 if self._held else -1, self._error)
        self.rows = files().recording_rows(self._held)

    def __enter__(self) -> RecordingFile:
        return self

    def __exit__(self, *raised: object) -> None:
        files().recording_close(self._held)

    def columns(self, first: int = 0, rows: int | None = None) -> dict[str, Array]:
        """{name: values} of some rows, or all."""
        n = self.rows - first if rows is None else rows
        held = {name for name, c in channels().items() if files().recording_has(self._held, c)}
        out = {name: numpy.empty(n) for name in channels() if name in held and name != "valid"}
        column, valid = ffi.new("double *[]", lib.TL_CHANNEL_COUNT), numpy.empty(n, dtype=numpy.uint8)
        for name, values in out.items():
            column[channels()[name]] = pointer(values)
        check_file(files().recording_read(self._held, first, n, column, pointer(valid), self._error), self._error)
        return {**out, "valid": valid.astype(float)} if "valid" in held else out

    def origin(self) -> Origin:
        """The Origin of its stretches."""
        first, last = (self.columns(row, 1)["time_s"][0] for row in (0, self.rows - 1))
        return Origin(self.path, float(first), float(last - first))
