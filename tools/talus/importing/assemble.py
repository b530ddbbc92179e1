"""The map's columns on one time base: rows that a column lacks become gaps, other clocks are read between their samples."""

import numpy as np

import talus
from talus.refused import Refused

from . import clock, guess, headers

SPARSE = 0.5  # of the rows without a value: a sensor with a rhythm of its own, and not dropouts
NEAR = 2.5  # of a sensor's own steps: neighbours further apart are not joined by a straight line
MOST_NAMES = 12  # in a message
FIRST = ("_motor_rad", "joint_rad", "slider_m", "_rad_s")  # whose instants are the recording's


class Series:
    """One column of the recording: its table's number, its instants [s] and values."""

    def __init__(self, target, number, seconds, values):
        self.target, self.number, self.seconds, self.values = target, number, seconds, values

    def own(self):
        """Without the rows where nothing stands."""
        good = np.isfinite(self.values)
        return self.seconds[good], self.values[good]

    def at(self, seconds):
        """(values, which are supported)."""
        t, x = self.own()
        if len(t) < 2:
            return np.full(len(seconds), np.nan), np.zeros(len(seconds), bool)
        right = np.clip(np.searchsorted(t, seconds), 1, len(t) - 1)
        near = t[right] - t[right - 1] <= NEAR * np.median(np.diff(t))
        inside = (seconds >= t[0]) & (seconds <= t[-1])
        return np.interp(seconds, t, x), np.isin(seconds, t) | inside & near


def find(tables, entry, target):
    """(number of the table, Column) of an entry; Refused where it is not there, or twice."""
    if entry.file is not None and not (isinstance(entry.file, int) and 1 <= entry.file <= len(tables)):
        raise Refused(2, f"{target}: file: expected a number from 1 to {len(tables)}, found '{entry.file}'")
    numbers = [entry.file] if entry.file else range(1, len(tables) + 1)
    found = [(n, one_column(tables[n - 1], entry.source, target)) for n in numbers if tables[n - 1].called(entry.source)]
    if not found:
        there = ", ".join(c.label for t in tables for c in t.columns)[:200]
        raise Refused(2, f"{target}: there is no column '{entry.source}'; found {there}")
    if len(found) > 1 and target != "time_s":
        raise Refused(2, f"{target}: '{entry.source}' stands in {len(found)} files; file: in the map says which")
    return found[0]


def one_column(table, source, target):
    """The table's column of that name, or None; Refused where several bear it."""
    found = table.called(source)
    if len(found) > 1:
        raise Refused(2, f"{target}: '{source}' is more than one column; expected one of {names(found)}")
    return found[0] if found else None


def names(columns):
    """What columns are called, for messages."""
    return ", ".join(c.label for c in columns[:MOST_NAMES]) + (", ..." if len(columns) > MOST_NAMES else "")


def time_entry(tables, mapped, number, times):
    """(Column, unit) of a table's time: the one that its format knows, else its own, else the one time_s that stands in each."""
    if tables[number - 1].clock is not None:
        return tables[number - 1].clock, "second"
    entry = times.get(number) or mapped.columns.get("time_s")
    if entry is None:
        raise Refused(2, "time_s: the map does not say where it comes from")
    column = one_column(tables[number - 1], entry.source, "time_s")
    if column is None:
        raise Refused(2, f"{tables[number - 1].path}: time_s: there is no column '{entry.source}'")
    unit = entry.unit or column.unit
    if unit is None:
        unit, _ = guess.time_unit(column)
    headers.conversion(unit, "time_s")
    return column, str(headers.parse(unit).units)


def values_of(table, column, entry, target):
    """The column's values in its unit."""
    values = column.numbers(table.path)
    if target == "valid":
        return np.nan_to_num((values != 0).astype(float))
    unit = entry.unit or column.unit
    if unit is None:
        raise Refused(2, f"{target}: the header of {column.name} has no unit; --map '{target}={column.name}:UNIT' says it")
    if entry.wrap:
        values = guess.unwrap(values, entry.wrap, headers.target_of(target) == "radian")
    factor, offset = headers.conversion(unit, target)
    return factor * (entry.sign * (values - entry.zero)) + offset


def clocks(tables, mapped, times, used):
    """{number: Times} of the tables in use, with what each clock is before."""
    out = {}
    for number in used:
        column, unit = time_entry(tables, mapped, number, times)
        if unit not in clock.SECONDS:
            raise Refused(2, f"time_s: '{unit}' is no unit for it; expected one such as ms")
        out[number] = clock.read(column, unit, tables[number - 1].path, tables[number - 1].notes)
    return out


def series_of(tables, mapped, times):
    """{target: Series} on the clock of the first table in use, and that clock's beginning [s]."""
    places = {target: find(tables, entry, target) for target, entry in mapped.columns.items() if target != "time_s"}
    if not places:
        raise Refused(2, "the map names no column besides time_s")
    read = clocks(tables, mapped, times, sorted({number for number, _ in places.values()}))
    start = min(getattr(t, "before", 0) for t in read.values())
    seconds = {}
    for number, t in read.items():
        shift = (mapped.clocks.get(number) or {}).get("offset_s", 0.0)
        seconds[number] = t.seconds(start - getattr(t, "before", 0)) + shift
    out = {}
    for target, (number, column) in places.items():
        values = values_of(tables[number - 1], column, mapped.columns[target], target)
        out[target] = Series(target, number, seconds[number], values[read[number].rows])
    return out, start


def base_of(series):
    """The series whose instants are the recording's."""
    for end in FIRST:
        for target, one in series.items():
            if target.endswith(end):
                return one
    return next(iter(series.values()))


def check_overlap(base, other, tables):
    t, u = base.own()[0], other.own()[0]
    if len(t) and len(u) and (u[-1] < t[0] or t[-1] < u[0]):
        raise Refused(2, f"{tables[other.number - 1].path}: its clock shows {u[0]:.3f} .. {u[-1]:.3f} s, that of "
                         f"{tables[base.number - 1].path} {t[0]:.3f} .. {t[-1]:.3f} s; offset_s under clocks: in the map "
                         "says how far they are apart")  # fmt: skip


def recording(tables, mapped, times, notes):
    """The talus.Recording."""
    series, start = series_of(tables, mapped, times)
    if start:
        notes.append(f"time 0 is {float(start):.6f} s on the file's clock")
    base, required = base_of(series), _required(mapped.plant, series)
    seconds = base.seconds
    keep, columns = np.isfinite(base.values), {"time_s": seconds}
    sparse_base = np.mean(~keep) > SPARSE
    for target, one in series.items():
        check_overlap(base, one, tables)
        apart = one.number != base.number or sparse_base or np.mean(~np.isfinite(one.values)) > SPARSE
        values, good = one.at(seconds) if apart else (one.values, np.isfinite(one.values))
        if target in required or target == "valid":
            keep &= good
        elif not good.all():
            t, x = one.own()
            if not len(t):
                notes.append(f"{target} holds nothing and is left out")
                continue
            values = np.where(good, values, np.interp(seconds, t, x))
        columns[target] = values
    return _kept(columns, keep, mapped.plant, notes)


def _required(plant, series):
    held, names = talus.channel_set(talus.Model(plant)), talus.channels()
    chosen = held.required
    for choice in held.any_of:
        chosen |= choice
    return {target for target in series if chosen >> names[target] & 1} | ({"joint_load_Nm"} & set(series))


def _kept(columns, keep, plant, notes):
    if not keep.all():
        runs = int((np.diff(np.concatenate([[1], keep.astype(int), [1]])) < 0).sum())
        notes.append(f"{int((~keep).sum())} rows lack a value that is needed: left out, {runs} gaps")
    if keep.sum() < 100:
        raise Refused(2, f"{int(keep.sum())} samples are whole, expected at least 100")
    try:
        ordered = sorted(columns, key=talus.channels().get)
        out = talus.Recording({name: columns[name][keep] for name in ordered})
        out.check_channels(talus.Model(plant))
    except ValueError as error:
        raise Refused(2, str(error)) from error
    return out
