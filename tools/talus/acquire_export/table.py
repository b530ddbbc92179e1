"""From streams to the recording's columns on one time base."""

import math

import numpy as np
from talus.refused import Refused

from .encoders import Unrolled, Zeroed, check_spread, joint_angle
from .ranks import median
from .spool import CHUNK, around, interpolate
from .streams import diffs

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
COLUMN = (("number", "i8"), ("time_ns", "f8"), ("value", "f8"))  # of a channel's spool
MOST_COUNT_BITS = 48  # of an encoder
MOST_FINER = 16  # samples of an even grid for each that there is
LARGEST_RAW = 2.0**64  # of a whole number in a frame
LARGEST = 1e9  # value that a recording may hold
GAP_PERIODS = 2.5  # neighbours further apart than this are not joined by a straight line


class Column:
    """One channel of the recording: where it comes from, its instants and values."""

    def __init__(self, name, stream, field):
        self.name, self.stream, self.field = name, stream, field
        self.group = self.rows = None  # spool of (number, time_ns, value)
        self.step = 0.0  # the smallest difference between two values

    def limits(self):
        """First and last row."""
        return self.rows.read(0, 1)[0], self.rows.read(len(self.rows) - 1, len(self.rows))[0]

    def parts(self, rows):
        """Where those of each life of the sender stand in `rows` (a spool with the column `number`): (first, end)."""
        begins = self.group.begins if self.group else self.stream.first_numbers()
        places = [*(rows.search("number", number) for number in begins), len(rows)]
        places[0] = 0
        return [(first, end) for first, end in zip(places, places[1:], strict=False) if end > first]

    def typical_step(self):
        return median(lambda: diffs(rows["time_ns"] for rows in self.rows.chunks())) or 0.0


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
        of_message = [s for s in streams if s.message is message and s.has(field)]
        if len(of_message) > 1:
            names = " and ".join(s.source for s in of_message)
            raise Refused(2, f"{message.name} is on {names}: --interface says which one is the bench's")
        if of_message:
            columns[channel] = Column(channel, of_message[0], field)
    return columns, {channel: message for channel, (message, _) in wanted.items() if channel not in columns}


# ---- values ------------------------------------------------------------------------


def plain(column, model):
    """A signal whose unit the DBC says: values of its frames' data."""
    units = UNITS[unit_of(column.name)]
    if column.field.unit not in units:
        raise Refused(2, f"{column.stream.message.name}.{column.field.name}: the unit '{column.field.unit}' is none for "
                         f"{column.name}; expected {' or '.join(units)}, or count for an encoder")  # fmt: skip
    if not (math.isfinite(column.field.scale * LARGEST_RAW) and math.isfinite(column.field.offset)):
        raise Refused(2, f"{column.stream.message.name}.{column.field.name}: factor {column.field.scale:g} and offset "
                         f"{column.field.offset:g} give no finite values")  # fmt: skip
    factor = units[column.field.unit]
    if column.name.endswith("_current_A") and "bus" in model.tree:
        factor *= model.bus(joint_of(column.name), "current")["sign"]
    column.step = abs(factor * column.field.scale)

    @np.errstate(over="ignore")
    def values(data):
        return factor * column.field.physical(data)

    return values


def check_count(column):
    if column.field.bits > MOST_COUNT_BITS or column.field.float:
        raise Refused(2, f"{column.stream.message.name}.{column.field.name}: a count of {column.field.bits} bits; expected a whole "
                         f"number of at most {MOST_COUNT_BITS}")  # fmt: skip


def counted_joint(column, model):
    bus = model.bus(joint_of(column.name), "joint")
    column.step = 2 * math.pi / bus["counts_per_turn"]
    return lambda data: joint_angle(column.field.raw(data).astype(np.int64), bus)


def is_counted_motor(column):
    return column.field.unit == "count" and column.name.endswith("_motor_rad")


def counted_motor(column, columns, model, store):
    """The relative encoder, zeroed from the joint's, in each life of its sender anew; answers its zero, or None where there is
    nothing to zero by: then only the longest life counts. The column holds counts before, and angles behind it."""
    joint = joint_of(column.name)
    bus = model.bus(joint, "motor")
    counts, parts = column.rows, column.parts(column.rows)
    column.step = 2 * math.pi / bus["counts_per_turn"]
    column.rows = store.spool(COLUMN)
    absolute = columns.get(f"{joint}_joint_rad")
    if absolute is None or absolute.field.unit != "count" and absolute.field.unit not in UNITS["rad"]:
        unroll = Unrolled(1 << column.field.bits, bus)
        for rows in counts.chunks(CHUNK, *max(parts, key=lambda part: part[1] - part[0])):
            column.rows.append_columns(rows["number"], rows["time_ns"], unroll(rows["value"].astype(np.int64)))
        return None
    first, *others = [zero_part(column, lambda part=part: counts.chunks(CHUNK, *part), absolute, model, store) for part in parts]
    return first | ({"behind_restarts": others} if others else {})


def zero_part(column, chunks, absolute, model, store):
    """The angles of one life; its zero."""
    span, bus = 1 << column.field.bits, model.bus(joint_of(column.name), "motor")
    zeroed, before = Zeroed(span, bus, store), len(column.rows)
    expect(column, chunks, absolute, model, zeroed)
    zero, spread = zeroed.find_zero()
    for rows, angle in zip(chunks(), zeroed.angles(), strict=True):
        column.rows.append_columns(rows["number"], rows["time_ns"], angle)
    check_spread(column.name, spread, span)
    return {"zero_count": zero, "spread_counts": spread, "samples": len(column.rows) - before}


def expect(column, chunks, absolute, model, zeroed):
    """Where the joint's encoder and the transmission say that the motor is."""
    joint, least, most, reached = joint_of(column.name), math.inf, -math.inf, True
    for rows in chunks():
        at = interpolate(absolute.rows, "time_ns", "value", rows["time_ns"])
        angles, which = np.unique(at, return_inverse=True)
        expected = model.motor_angles(joint, angles)
        reached &= bool(np.isfinite(expected).all())
        least, most = min(least, at.min()), max(most, at.max())
        zeroed.take(rows["value"].astype(np.int64), expected[which])
    if not reached:
        raise Refused(2, f"{joint}_joint_rad: the transmission cannot follow to {least:.3f} .. {most:.3f} rad; is "
                         f"{model.path}: bus.{joint}.joint this bench's?")  # fmt: skip


def fill_one(column, values, origin_ns, store):
    """Times, from an origin on, and values(data)."""
    column.rows, latest = store.spool(COLUMN), -math.inf
    for rows in column.stream.usable(column.field):
        if column.group:
            time_ns = column.group.time_of(rows["number"]) + float(column.group.zero_ns - origin_ns)
        else:  # a frame that came too late counts from then on
            time_ns = np.maximum.accumulate(np.append(latest, (rows["stamp_ns"] - origin_ns).astype(float)))[1:]
        values_of_rows = values(rows["data"])
        if column.group and len(rows):  # a life of the sender begins behind the one before
            good = time_ns > np.maximum.accumulate(np.append(latest, time_ns))[:-1]
            rows, time_ns, values_of_rows = rows[good], time_ns[good], values_of_rows[good]
        latest = time_ns[-1] if len(time_ns) else latest
        usable = usable_values(column, rows, values_of_rows)
        column.rows.append_columns(rows["number"][usable], time_ns[usable], values_of_rows[usable])


def usable_values(column, rows, values):
    """Which ones a recording may hold; the others are faults. Floating-point signals may be no number."""
    usable = np.isfinite(values)
    usable[usable] &= (np.abs(values[usable]) <= LARGEST) | (column.field.unit == "count")
    for row in rows[~usable]:
        column.stream.faults.add("unusable", int(row["index"]), int(row["number"]))
    return usable


def values_of(column, model):
    if column.field.unit != "count":
        return plain(column, model)
    check_count(column)
    return column.field.raw if is_counted_motor(column) else counted_joint(column, model)


def fill(columns, groups, model, origin_ns, store):
    """Times and values of all columns; {joint: how its relative encoder was zeroed}. Columns without a value go."""
    zeros = {}
    for column in columns.values():
        column.group = next((g for g in groups if column.stream in g.streams and column.stream.message.sample_tick), None)
        fill_one(column, values_of(column, model), origin_ns, store)
    for name in [name for name, column in columns.items() if not len(column.rows)]:
        del columns[name]
    for column in columns.values():
        if is_counted_motor(column):
            zeros[joint_of(column.name)] = counted_motor(column, columns, model, store)
    return zeros


# ---- one time base -------------------------------------------------------------------


class Sampled:
    """A column at any rising instants: straight between neighbours that are near enough."""

    def __init__(self, column, holds):
        self.rows, self.holds = column.rows, holds
        self.near_ns = 0.0 if holds else GAP_PERIODS * column.typical_step()
        self.first, self.last = (row["time_ns"] for row in column.limits())

    def at(self, time_ns):
        """(values, which of them are supported)."""
        value, supported = np.empty(len(time_ns)), np.ones(len(time_ns), bool)
        for part, rows, _ in around(self.rows, "time_ns", time_ns):
            value[part] = np.interp(time_ns[part], rows["time_ns"], rows["value"])
            if not self.holds:
                supported[part] = self.supported(time_ns[part], rows["time_ns"])
        return value, supported

    def supported(self, time_ns, own):
        exact = np.isin(time_ns, own)
        if len(own) < 2:
            return exact
        right = np.clip(np.searchsorted(own, time_ns), 1, len(own) - 1)
        near = own[right] - own[right - 1] <= self.near_ns
        return exact | (time_ns >= self.first) & (time_ns <= self.last) & near


class Joined:
    """A column that shares its ticks with the base."""

    def __init__(self, column, required):
        self.rows, self.sampled = column.rows, None if required else Sampled(column, True)

    def at(self, number, time_ns):
        if self.sampled:
            return self.sampled.at(time_ns)
        value, there = np.empty(len(number)), np.empty(len(number), bool)
        for part, rows, _ in around(self.rows, "number", number):
            place = np.minimum(np.searchsorted(rows["number"], number[part]), len(rows) - 1)
            value[part], there[part] = rows["value"][place], rows["number"][place] == number[part]
        return value, there


class Table:
    """The recording: instants [ns] and values, at the rows at which every required column has one."""

    def __init__(self, names, store):
        self.names, self.store = names, store
        self.rows = store.spool([("time_ns", "f8"), ("value", "f8", (len(names),))])
        self.left_out = 0  # ticks
        self.joints = []  # (last instant before, first behind) where the sender began anew

    def __len__(self):
        return len(self.rows)

    @property
    def first_ns(self):
        return float(self.rows.read(0, 1)["time_ns"][0])

    @property
    def last_ns(self):
        return float(self.rows.read(len(self) - 1, len(self))["time_ns"][0])


def assemble(columns, names, required, store):
    base, table = columns[required[0]], Table(names, store)
    sources = [source_of(columns[name], base, name in required) for name in names]
    last_ns = -math.inf
    for rows in base.rows.chunks():
        time_ns, good = rows["time_ns"], np.diff(rows["time_ns"], prepend=last_ns) > 0
        values = np.empty((len(rows), len(names)))
        for k, source in enumerate(sources):
            values[:, k], there = source.at(rows["number"], time_ns) if isinstance(source, Joined) else source.at(time_ns)
            good &= there
        table.rows.append_columns(time_ns[good], values[good])
        last_ns = time_ns[-1]
    table.left_out = possible_rows(base) - len(table)
    table.joints = [tuple(base.rows.read(first - 1, first + 1)["time_ns"].tolist()) for first, _ in base.parts(base.rows)[1:]]
    return table


def source_of(column, base, required):
    joins = column.group and column.group is base.group and not column.field.multiplexer
    return Joined(column, required) if joins else Sampled(column, not required)


def possible_rows(base):
    """How many rows there would be had nothing been lost between the first and the last of each life of the sender."""
    spans = [base.rows.read(end - 1, end)[0].tolist()[:2] + base.rows.read(first, first + 1)[0].tolist()[:2]
             for first, end in base.parts(base.rows)]  # fmt: skip
    if base.group:
        apart = int(median(lambda: diffs(rows["number"] for rows in base.rows.chunks())) or 1) if base.field.multiplexer else 1
        return sum((last - first) // max(apart, 1) + 1 for last, _, first, _ in spans)
    step = base.typical_step()
    return sum(1 + round((last_ns - first_ns) / step) for _, last_ns, _, first_ns in spans) if step else len(base.rows)


def even(table, rate_hz):
    """The same on an even grid; instants in gaps are left out."""
    step, span = 1e9 / rate_hz, table.last_ns - table.first_ns
    if span / step > MOST_FINER * len(table):
        raise Refused(2, f"--rate: {span / step:.0f} samples from {len(table)}; expected at most {MOST_FINER} for each")
    near_ns = GAP_PERIODS * median(lambda: diffs(rows["time_ns"] for rows in table.rows.chunks()))
    out, count = Table(table.names, table.store), int(span / step * (1 + 1e-12)) + 1
    out.left_out, out.joints = table.left_out, table.joints
    for first in range(0, count, CHUNK):
        grid = table.first_ns + step * np.arange(first, min(first + CHUNK, count))
        for part, rows, _ in around(table.rows, "time_ns", grid):
            right = np.clip(np.searchsorted(rows["time_ns"], grid[part]), 1, len(rows) - 1)
            near = rows["time_ns"][right] - rows["time_ns"][right - 1] <= near_ns
            at = grid[part][near]
            out.rows.append_columns(at, np.stack([np.interp(at, rows["time_ns"], value) for value in rows["value"].T], axis=1))
    return out
