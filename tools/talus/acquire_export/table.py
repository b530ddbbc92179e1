"""From streams to the recording's columns on one time base."""

import math

import numpy as np

from .encoders import check_spread, joint_angle, motor_angle, unrolled_angle
from .refused import Refused

UNITS = {  # of a column's name: what a signal's unit is worth in it
    "rad": {"rad": 1.0, "deg": math.pi / 180, "rev": 2 * math.pi, "turn": 2 * math.pi},
    "rad_s": {"rad/s": 1.0, "deg/s": math.pi / 180, "rpm": math.pi / 30, "rev/s": 2 * math.pi},
    "A": {"A": 1.0, "mA": 1e-3},
    "Nm": {"Nm": 1.0, "mNm": 1e-3},
    "C": {"degC": 1.0, "C": 1.0, "°C": 1.0},
    "V": {"V": 1.0, "mV": 1e-3},
    "m": {"m": 1.0, "mm": 1e-3},
    "N": {"N": 1.0, "kN": 1e3},
}
MOST_COUNT_BITS = 48  # of an encoder
MOST_FINER = 16  # samples of an even grid for each that there is
GAP_PERIODS = 2.5  # neighbours further apart than this are not joined by a straight line


class Column:
    """One channel of the recording: where it comes from, its instants and values."""

    def __init__(self, name, stream, field):
        self.name, self.stream, self.field = name, stream, field
        self.index = stream.usable(field.name)
        self.time_ns = self.value = None
        self.step = 0.0  # the smallest difference between two values


def joint_of(name):
    return next((joint for joint in ("knee", "ankle") if name.startswith(joint)), None)


def unit_of(name):
    return next(unit for unit in sorted(UNITS, key=len, reverse=True) if name.endswith(f"_{unit}"))


def find_columns(streams, database, mapping, path):
    """{channel: Column} by the DBC's attribute Channel, or by `mapping` {channel: (message, signal)}."""
    wanted = {}
    for message in database.messages.values():
        for field in message.fields.values():
            if field.channel:
                wanted[field.channel] = (message, field)
    for channel, (message_name, signal) in mapping.items():
        message = database.by_name(message_name)
        if message is None or signal not in message.fields:
            raise Refused(2, f"--channel {channel}: {path} has no signal {message_name}.{signal}")
        wanted[channel] = (message, message.fields[signal])
    if not wanted:
        raise Refused(2, f"{path}: no signal has the attribute Channel, and no --channel was given: nothing says "
                         "which signal is which column (docs/bus.md)")  # fmt: skip
    columns = {}
    for channel, (message, field) in wanted.items():
        of_message = [s for s in streams if s.message is message and len(s.usable(field.name))]
        if len(of_message) > 1:
            names = " and ".join(s.source for s in of_message)
            raise Refused(2, f"{message.name} is on {names}: --interface says which one is the bench's")
        if of_message:
            columns[channel] = Column(channel, of_message[0], field)
    return columns, {channel: message for channel, (message, _) in wanted.items() if channel not in columns}


# ---- values ------------------------------------------------------------------------


def plain(column, model):
    """A signal whose unit the DBC says."""
    units = UNITS[unit_of(column.name)]
    if column.field.unit not in units:
        raise Refused(2, f"{column.stream.message.name}.{column.field.name}: the unit '{column.field.unit}' is none for "
                         f"{column.name}; expected {' or '.join(units)}, or count for an encoder")  # fmt: skip
    factor = units[column.field.unit]
    if column.name.endswith("_current_A") and "bus" in model.tree:
        factor *= model.bus(joint_of(column.name), "current")["sign"]
    column.value = factor * column.stream.values(column.field.name, column.index)
    column.step = abs(factor * column.field.scale)


def check_count(column):
    if column.field.bits > MOST_COUNT_BITS or column.field.float:
        raise Refused(2, f"{column.stream.message.name}.{column.field.name}: a count of {column.field.bits} bits; expected a whole "
                         f"number of at most {MOST_COUNT_BITS}")  # fmt: skip


def counted_joint(column, model):
    bus = model.bus(joint_of(column.name), "joint")
    column.value = joint_angle(column.stream.counts(column.field.name, column.index), bus)
    column.step = 2 * math.pi / bus["counts_per_turn"]


def counted_motor(column, columns, model):
    """The relative encoder, zeroed from the joint's; answers its zero, or None where there is nothing to zero by."""
    joint = joint_of(column.name)
    bus = model.bus(joint, "motor")
    counts = column.stream.counts(column.field.name, column.index)
    span = 1 << column.field.bits
    column.step = 2 * math.pi / bus["counts_per_turn"]
    absolute = columns.get(f"{joint}_joint_rad")
    if absolute is None or absolute.field.unit != "count" and absolute.field.unit not in UNITS["rad"]:
        column.value = unrolled_angle(counts, span, bus)
        return None
    at = np.interp(column.time_ns, absolute.time_ns, absolute.value)
    angles, which = np.unique(at, return_inverse=True)
    expected = np.array([model.motor_angle(joint, angle) for angle in angles.tolist()])[which]
    if not np.isfinite(expected).all():
        raise Refused(2, f"{joint}_joint_rad: the transmission cannot follow to {at.min():.3f} .. {at.max():.3f} rad; is "
                         f"{model.path}: bus.{joint}.joint this bench's?")  # fmt: skip
    column.value, zero, spread = motor_angle(counts, span, expected, bus)
    check_spread(column.name, spread, span)
    return {"zero_count": zero, "spread_counts": spread, "samples": len(counts)}


def fill(columns, groups, model, origin_ns):
    """Times, from an origin on, and values of all columns; {joint: how its relative encoder was zeroed}."""
    zeros = {}
    for column in columns.values():
        group = next((g for g in groups if column.stream in g.streams and column.stream.message.sample_tick), None)
        column.group = group
        if group:
            column.time_ns = group.time_of(column.stream.number[column.index]) + float(group.zero_ns - origin_ns)
        else:
            column.time_ns = (column.stream.stamp_ns[column.index] - origin_ns).astype(float)
    for column in columns.values():
        if column.field.unit == "count":
            check_count(column)
        if column.field.unit != "count":
            plain(column, model)
        elif not column.name.endswith("_motor_rad"):
            counted_joint(column, model)
    for column in columns.values():
        if column.field.unit == "count" and column.name.endswith("_motor_rad"):
            zeros[joint_of(column.name)] = counted_motor(column, columns, model)
    return zeros


# ---- one time base -------------------------------------------------------------------


def typical_step(time_ns):
    return float(np.median(np.diff(time_ns))) if len(time_ns) > 1 else 0.0


def sample(column, time_ns, holds):
    """(values at these instants, which of them are supported): straight between neighbours that are near enough."""
    value = np.interp(time_ns, column.time_ns, column.value)
    if holds:
        return value, np.ones(len(time_ns), bool)
    right = np.clip(np.searchsorted(column.time_ns, time_ns), 1, len(column.time_ns) - 1)
    width = column.time_ns[right] - column.time_ns[right - 1]
    near = width <= GAP_PERIODS * typical_step(column.time_ns)
    inside = (time_ns >= column.time_ns[0]) & (time_ns <= column.time_ns[-1])
    exact = np.isin(time_ns, column.time_ns)
    return value, exact | inside & near


def assemble(columns, names, required):
    """(instants [ns], {name: values}, ticks left out): the rows at which every required column has a value."""
    base = columns[required[0]]
    time_ns = base.time_ns
    good = np.ones(len(time_ns), bool)
    values = {}
    for name in names:
        column = columns[name]
        if column.group and column.group is base.group and not column.field.multiplexer:
            ticks, own = base.stream.number[base.index], column.stream.number[column.index]
            place = np.minimum(np.searchsorted(own, ticks), len(own) - 1)
            there = own[place] == ticks
            values[name] = column.value[place]
            good &= there | (name not in required)
            if name not in required:
                values[name] = np.interp(time_ns, column.time_ns, column.value)
        else:
            values[name], supported = sample(column, time_ns, name not in required)
            good &= supported
    good[1:] &= np.diff(time_ns) > 0
    return time_ns[good], {name: value[good] for name, value in values.items()}, possible_rows(base, time_ns) - int(good.sum())


def possible_rows(base, time_ns):
    """How many rows there would be had nothing been lost between the first and the last."""
    if base.group:
        ticks = base.stream.number[base.index]
        apart = int(np.median(np.diff(ticks))) if base.field.multiplexer and len(ticks) > 1 else 1
        return int(ticks[-1] - ticks[0]) // max(apart, 1) + 1
    step = typical_step(time_ns)
    return 1 + round((time_ns[-1] - time_ns[0]) / step) if step else len(time_ns)


def even(time_ns, values, rate_hz):
    """The same on an even grid; instants in gaps are left out."""
    step = 1e9 / rate_hz
    wanted = (time_ns[-1] - time_ns[0]) / step
    if wanted > MOST_FINER * len(time_ns):
        raise Refused(2, f"--rate: {wanted:.0f} samples from {len(time_ns)}; expected at most {MOST_FINER} for each")
    grid = time_ns[0] + step * np.arange(int((time_ns[-1] - time_ns[0]) / step * (1 + 1e-12)) + 1)
    right = np.clip(np.searchsorted(time_ns, grid), 1, len(time_ns) - 1)
    near = time_ns[right] - time_ns[right - 1] <= GAP_PERIODS * typical_step(time_ns)
    grid = grid[near]
    return grid, {name: np.interp(grid, time_ns, value) for name, value in values.items()}
