"""A map drafted from names, units and ranges. `doubts` say what was guessed, `Refused` what cannot be."""

from dataclasses import replace

import numpy as np

import talus
from talus.refused import Refused

from . import assemble, clock, guess, headers, vocabulary
from .mapping import Entry, Map

DIMENSION = {"radian": "angle", "radian/second": "velocity", "ampere": "current", "newton*meter": "torque", "degC": "temperature",
             "volt": "voltage", "meter": "length", "newton": "force", "second": "time"}  # fmt: skip
BY_UNIT = {"angle": "rad", "velocity": "rad_s", "current": "A", "torque": "Nm", "temperature": "C", "voltage": "V",
           "length": "m", "force": "N", "time": "s"}  # fmt: skip
MOVED_BY = {"joint_rad": ("joint_velocity_rad_s", "joint_current_A", "joint_torque_Nm"), "knee_motor_rad": ("knee_current_A",),
            "ankle_motor_rad": ("ankle_current_A",), "slider_m": ("slider_force_N",)}  # fmt: skip
PASSIVE = -0.3  # of the largest power that drive and speed could have together


def kind_by_unit(unit):
    """Which quantity a unit is of, or None."""
    if unit is None or headers.parse(unit) is None:
        return None
    return next((kind for kind, end in BY_UNIT.items() if headers.fits(unit, f"x_{end}")), None)


class Candidate:
    """A column of a file that may be a column of the recording."""

    def __init__(self, table, number, column):
        self.table, self.number, self.column = table, number, column
        self.full = column.name if column.unit is None else f"{column.name}_{column.unit}"
        by_name, self.sure = vocabulary.quantity(column.name)
        by_unit = kind_by_unit(column.unit)
        if by_unit in ("angle", "velocity", "current", "force", "length", "temperature", "voltage", "time") and by_name != by_unit:
            # the unit decides, except where the name narrows it
            by_name, self.sure = (by_name, self.sure) if (by_name, by_unit) == ("angle", "length") else (by_unit, 1)
        if by_unit == "torque" and by_name != "load":
            by_name, self.sure = "torque", 2
        self.kind = "time" if clock.is_calendar(column) and by_unit is None else by_name

    def target(self, plant):
        exact = self.full if self.full in talus.channels() else self.column.name
        if exact in talus.channels():
            return exact
        if self.kind is None or vocabulary.is_no_measurement(self.column.name):
            return None
        if vocabulary.is_ordered(self.column.name):
            return vocabulary.ordered_column(plant, self.kind)
        return vocabulary.column_of(plant, self.kind, self.column.name)

    def why(self):
        return "its unit" if vocabulary.quantity(self.column.name)[0] != self.kind else "a part of its name"

    def caution(self, plant):
        return None if self.full in talus.channels() else vocabulary.caution(plant, self.kind, self.column.name)

    def score(self, plant=None):
        known = (self.full in talus.channels()) * 4 + self.sure + 2 * (kind_by_unit(self.column.unit) is not None)
        return known - (self.caution(plant) is not None)


def plant_of(candidates):
    said = [c for c in candidates if not vocabulary.is_ordered(c.column.name)]
    if any(vocabulary.joint_of(c.full) for c in said):
        return "leg"
    lengths = any(kind_by_unit(c.column.unit) == "length" or "slider" in c.full for c in said)
    return "slider" if lengths or any(c.kind == "force" for c in said) else "pendulum"


class Suggestion:
    """`map` and the `doubts` about it."""

    def __init__(self, tables, plant=None):
        self.tables, self.doubts = tables, []
        self.candidates = [Candidate(t, n, c) for n, t in enumerate(tables, 1) for c in t.columns]
        plant = plant or plant_of(self.candidates)
        self.map, self.times = Map(plant), {}
        self._choose_times()
        for target in sorted({c.target(plant) for c in self.candidates} - {None, "time_s"}):
            self._choose(target, [c for c in self.candidates if c.target(plant) == target])
        self._check_complete()
        self._check_motion()

    def _choose_times(self):
        for number, table in enumerate(self.tables, 1):
            mine = [c for c in self.candidates if c.number == number and _is_clock(c)]
            if not mine:
                raise Refused(2, f"{table.path}: no column looks like a time; found {assemble.names(table.columns)}; --map time_s=COLUMN:UNIT says which")
            best = min(mine, key=lambda c: (-c.score() // 3, _unevenness(c.column)))
            if len(mine) > 1:
                others = ", ".join(c.column.name for c in mine if c is not best)
                self.doubts.append(f"time_s: {best.column.name} is taken, the most even clock; there is also {others}")
            self._set_time(best)

    def _set_time(self, chosen):
        unit, doubt = chosen.column.unit, None
        if unit is None or not headers.fits(unit, "time_s"):
            unit, doubt = guess.time_unit(chosen.column)
        if doubt:
            self.doubts.append(f"time_s: {doubt}")
        entry = Entry(chosen.column.name, unit, file=chosen.number if len(self.tables) > 1 else None)
        self.times[chosen.number] = entry
        self.map.columns.setdefault("time_s", entry)

    def _choose(self, target, found):
        found = [c for c in found if c.column.is_numeric()]
        if not found:
            return
        plant = self.map.plant
        best = max(found, key=lambda c: c.score(plant))
        if best.caution(plant):
            self.doubts.append(f"{target}: {best.column.name} {best.caution(plant)}")
        if sum(c.score(plant) == best.score(plant) for c in found) > 1:
            others = ", ".join(c.column.name for c in found if c is not best)
            self.doubts.append(f"{target}: {best.column.name} is taken, the first that fits; it may be {others}")
        elif best.sure < 2 and best.full != target:
            self.doubts.append(f"{target}: {best.column.name} is taken by {best.why()} alone")
        self.map.columns[target] = self._entry(target, best)

    def _entry(self, target, chosen):
        column, values = chosen.column, chosen.column.numbers(chosen.table.path)
        entry = Entry(column.name, column.unit, file=chosen.number if len(self.tables) > 1 else None)
        if target == "valid" or not np.isfinite(values).any():
            return entry
        if column.unit is not None and not headers.fits(column.unit, target):
            self.doubts.append(f"{target}: '{column.unit}' in the header of {column.name} is no unit for it")
        if column.unit is None or not headers.fits(column.unit, target):
            entry.unit, doubt = guess.value_unit(column, values, target)
            self.doubts.append(f"{target}: {doubt}")
        self._note_unit(target, entry, values)
        is_angle = headers.target_of(target) == "radian"
        entry.wrap = guess.wrap(values, entry.unit, is_angle)
        if entry.wrap:
            self.doubts.append(f"{target}: {column.name} starts again every {entry.wrap:.6g} {entry.unit}; it is unwrapped")
            if not is_angle and column.unit is None:
                entry.unit, doubt = guess.value_unit(column, guess.unwrap(values, entry.wrap, False), target)
                self.doubts.append(f"{target}: {doubt}")
        elif headers.target_of(target) in ("ampere", "newton*meter", "newton") and guess.unsigned(values):
            self.doubts.append(f"{target}: {column.name} is never below zero: its sign is missing, and nothing here can give it back")
        return entry

    def _note_unit(self, target, entry, values):
        """A header's own unit that the values speak against."""
        if str(entry.unit).lower() in ("rad", "radians") and headers.target_of(target) == "radian" and "motor" not in target:
            if np.nanmax(np.abs(values)) > 50:
                self.doubts.append(f"{target}: {entry.source} says rad and holds {guess.span(values)}: degrees?")
        if str(entry.unit).lower() == "grad":
            self.doubts.append(f"{target}: {entry.source}: 'Grad' is taken for degrees, not for gon")

    def _check_complete(self):
        held = talus.channel_set(talus.Model(self.map.plant))
        names = talus.channels()
        have = sum(1 << names[name] for name in self.map.columns)
        lacking = [name for name, c in names.items() if held.required >> c & 1 and not have >> c & 1]
        lacking += [" or ".join(n for n, c in names.items() if s >> c & 1) for s in held.any_of if s and not s & have]
        if lacking:
            found = "; ".join(f"{t.path}: {assemble.names(t.columns)}" for t in self.tables)
            raise Refused(2, f"nothing looks like {lacking[0]} (a {self.map.plant}'s recording needs it); found {found}; "
                             f"--map '{lacking[0].split(' or ')[0]}=COLUMN:UNIT' says which")  # fmt: skip

    def _check_motion(self):
        """Speed against angle, and the sign of what drives a joint: said, where they do not agree."""
        pairs = [(angle, other) for angle, others in MOVED_BY.items() for other in others if {angle, other} <= set(self.map.columns)]
        if not pairs:
            return
        part = Map(self.map.plant)
        part.columns = {target: self.map.columns[target] for pair in pairs for target in pair} | {"time_s": self.map.columns["time_s"]}
        series, _ = assemble.series_of([replace(table, notes=[]) for table in self.tables], part, self.times)
        for angle, other in pairs:
            together = _at_the_angles(series[angle], series[other])
            if other == "joint_velocity_rad_s":
                self._check_speed(*together)
            elif "joint_load_Nm" not in self.map.columns and guess.power_sign(*together) < PASSIVE:
                self.doubts.append(f"{other}: it works against the motion of {angle} on the whole: is its sign turned? (sign: -1)")

    def _check_speed(self, angle, speed, seconds):
        slope, likeness = guess.agreement(angle, speed, seconds)
        if abs(likeness) > 0.7 and not 0.8 < slope < 1.25:
            self.doubts.append(f"joint_velocity_rad_s: it is {slope:.4g} times the derivative of joint_rad: one of their units or signs is wrong")


def _at_the_angles(angle, other):
    """(angle, other, instants [s]); NaN where the other's clock has no sample near."""
    values, good = (other.values, True) if other.number == angle.number else other.at(angle.seconds)
    return angle.values, np.where(good, values, np.nan), angle.seconds


def _is_clock(candidate):
    column, known = candidate.column, candidate.table.clock
    return column is known if known else candidate.kind == "time" and _holds_times(column)


def _holds_times(column):
    return column.is_numeric() or clock.is_calendar(column) or _is_date(column)


def _is_date(column):
    return isinstance(column.raw, np.ndarray) and column.raw.dtype.kind == "M"


def _unevenness(column):
    """Of a clock: how far its steps lie from their median, in medians."""
    if clock.is_calendar(column) or _is_date(column):
        return 1.0
    steps = np.diff(column.numbers(""))
    typical = np.nanmedian(np.abs(steps)) if np.isfinite(steps).any() else 0.0
    return float(np.nanmean(np.abs(steps - typical)) / typical) if typical > 0 else np.inf
