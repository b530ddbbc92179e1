"""Times without loss: whole numbers of the smallest step that is written, sorted, and what was wrong with them."""

import datetime
import re
from decimal import Decimal, InvalidOperation
from fractions import Fraction

import numpy as np

from talus.refused import Refused

from .table import MISSING

SECONDS = {"second": Fraction(1), "millisecond": Fraction(1, 1000), "microsecond": Fraction(1, 10**6),
           "nanosecond": Fraction(1, 10**9), "minute": Fraction(60)}  # fmt: skip
STAMP = re.compile(r"^(?:(\d{4})-(\d\d?)-(\d\d?)|(\d\d?)[./](\d\d?)[./](\d{4}))?[T ]?(\d\d?):(\d\d):(\d\d)(?:[.,](\d{1,9}))?"
                   r"(Z|[+-]\d\d:?\d\d)?$")  # fmt: skip
UNIX_S = 1e6  # times beyond are of a clock that did not start with the recording
MOST_DECIMALS = 12
LARGEST = 10**21  # in any unit
COARSE = 20  # a step of so few of the clock's is rounded
MOST_USUAL = 0.9  # of the steps are the same: then others are lost samples, and no rounding
LONG_RUN = 100  # rows; a clock that runs back behind so many started anew


class Times:
    """`ticks` whole numbers (int64) of `unit` seconds, at the kept rows `rows` in order of time."""

    def __init__(self, ticks, unit, rows):
        self.ticks, self.unit, self.rows = ticks, unit, rows

    def seconds(self, origin=0):
        """Correctly rounded, from `origin` [s, a Fraction] on."""
        ticks = self.ticks - round(origin / self.unit)
        return ticks * float(self.unit.numerator) / float(self.unit.denominator)

    def first(self):
        return int(self.ticks[0]) * self.unit


def _calendar(text):
    """Nanoseconds of a date and time of day, or None."""
    match = STAMP.match(text)
    if not match:
        return None
    y, m, d, d2, m2, y2, hour, minute, second, fraction, zone = match.groups()
    try:
        day = datetime.date(*map(int, (y, m, d) if y else (y2, m2, d2))).toordinal() if y or y2 else 719163
    except ValueError:
        return None
    seconds = ((day - 719163) * 24 + int(hour)) * 3600 + int(minute) * 60 + int(second)
    if zone and zone != "Z":
        sign, digits = (-1 if zone[0] == "-" else 1), zone[1:].replace(":", "")
        seconds -= sign * (int(digits[:2]) * 3600 + int(digits[2:]) * 60)
    return seconds * 10**9 + int((fraction or "0").ljust(9, "0"))


def is_calendar(column):
    return isinstance(column.raw, list) and any(STAMP.match(x) and ":" in x for x in column.raw[:20])


def exact(column, unit, path):
    """(ticks as a list or array, seconds a tick, which rows have one)."""
    plain = column.raw if is_calendar(column) else column.plain()
    if isinstance(plain, np.ndarray):
        return _of_array(plain, unit)
    if is_calendar(column):
        ticks = [_calendar(x) for x in plain]
        return np.array([t or 0 for t in ticks], dtype=object), Fraction(1, 10**9), np.array([t is not None for t in ticks])
    values = []
    for i, text in enumerate(plain):
        try:
            value = None if text.lower() in MISSING else Decimal(text)
        except InvalidOperation:
            raise Refused(2, f"{path}:{column.lines[i]}: {column.name}: '{text[:40]}' is not a time") from None
        if value is not None and not (value.is_finite() and abs(value) < LARGEST):
            raise Refused(2, f"{path}:{column.lines[i]}: {column.name}: '{text[:40]}' is no time")
        values.append(value)
    decimals = min(max((-v.as_tuple().exponent for v in values if v is not None), default=0), MOST_DECIMALS)
    ticks = np.array([0 if v is None else int(round(v.scaleb(max(decimals, 0)))) for v in values], dtype=object)
    return ticks, SECONDS[unit] / 10 ** max(decimals, 0), np.array([v is not None for v in values])


def _of_array(values, unit):
    if values.dtype.kind == "M":
        return values.astype("datetime64[ns]").astype(np.int64).astype(object), Fraction(1, 10**9), ~np.isnat(values)
    if values.dtype.kind in "iu":
        return values.astype(object), SECONDS[unit], np.ones(len(values), bool)
    good = np.isfinite(values) & (np.abs(values) < LARGEST)
    start = float(values[good][0]) if good.any() else 0.0
    decimals = 6 if abs(start) * float(SECONDS[unit]) > UNIX_S else MOST_DECIMALS
    scaled = [int(round(Decimal(repr(v)).scaleb(decimals))) if g else 0 for v, g in zip(values.tolist(), good, strict=True)]
    return np.array(scaled, dtype=object), SECONDS[unit] / 10**decimals, good


def read(column, unit, path, notes):
    """Times of a table; what was out of order, repeated or rounded is noted."""
    ticks, size, good = exact(column, unit, path)
    if not good.any():
        raise Refused(2, f"{path}: {column.name} holds no time")
    if not good.all():
        notes.append(f"{column.name}: {int((~good).sum())} rows without a time are left out")
    rows = np.flatnonzero(good)
    ticks = ticks[rows]
    base = int(min(ticks))
    if max(abs(int(t) - base) for t in ticks) >= 2**62:
        raise Refused(2, f"{path}: {column.name}: times from {min(ticks)} to {max(ticks)} are of no one recording")
    small = np.array([int(t) - base for t in ticks], dtype=np.int64)
    small, rows = _sorted(small, rows, column, path, notes)
    even = _unrounded(small)
    if even is not None:
        notes.append(f"{column.name}: rounded to {_text(_grid(small) * size)}; the samples are even within that, and their times too")
        size, small, base = size / 1000, even, base * 1000
    small, rows = _once(small, rows, column, notes)
    if abs(base) * size < UNIX_S and abs(base + int(small[-1])) < 2**62:
        return Times(small + base, size, rows)
    times = Times(small, size, rows)
    times.before = base * size  # a Fraction: nothing is lost
    return times


def _sorted(ticks, rows, column, path, notes):
    back = np.flatnonzero(np.diff(ticks) < 0)
    if not len(back):
        return ticks, rows
    typical = np.median(np.abs(np.diff(ticks)))
    runs = np.diff(np.concatenate([[0], back + 1, [len(ticks)]]))
    far = np.diff(ticks)[back] < -10 * typical
    if (far & (runs[:-1] >= LONG_RUN) & (runs[1:] >= LONG_RUN)).any() and len(back) < 20:
        at = rows[back[far][0] + 1]
        where = f":{column.lines[at]}" if column.lines else ""
        raise Refused(2, f"{path}{where}: {column.name} starts anew: two recordings in one file, or a clock that was set; cut it there")
    order = np.argsort(ticks, kind="stable")
    notes.append(f"{column.name}: time runs back {len(back)} times; rows are sorted by it")
    return ticks[order], rows[order]


def _once(ticks, rows, column, notes):
    again = np.concatenate([[False], np.diff(ticks) == 0])
    if again.any():
        notes.append(f"{column.name}: {int(again.sum())} rows repeat a time; the first of each is kept")
    return ticks[~again], rows[~again]


def _grid(ticks):
    steps = np.diff(ticks)
    return int(np.gcd.reduce(steps)) if len(steps) else 0


def _unrounded(ticks):
    """Thousandths of ticks of an even motion of the clock where rounding alone explains its unevenness; else None."""
    steps, grid = np.diff(ticks), _grid(ticks)
    if len(steps) < LONG_RUN or grid == 0 or abs(int(ticks[-1] - ticks[0])) >= 2**52:
        return None
    typical = steps[steps <= 5 * max(np.median(steps), grid)].mean()
    usual = np.mean(steps == np.bincount(np.minimum(steps // grid, 6 * COARSE)).argmax() * grid)
    if typical > COARSE * grid or usual > MOST_USUAL:
        return None
    out = ticks * 1000
    for part in np.split(np.arange(len(ticks)), np.flatnonzero(steps > 5 * typical + grid) + 1):
        if len(part) < COARSE:
            return None
        fit = np.polyval(np.polyfit(part - part[0], (ticks[part] - ticks[part[0]]).astype(float), 1), part - part[0]) + ticks[part[0]]
        if np.abs(fit - ticks[part]).max() > 0.6 * grid:
            return None
        out[part] = np.rint(fit * 1000).astype(np.int64)
    return out if (np.diff(out) > 0).all() else None


def _text(seconds):
    value = float(seconds)
    return next(f"{value * f:g} {u}" for f, u in ((1, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")) if value * f >= 1 or u == "ns")
