"""ASAM MDF (.mf4, .mdf, .dat) through asammdf: groups of channels become a Table for each clock that they have."""

import contextlib
import gc
import io
import logging
import re
import sys
from pathlib import Path

import numpy as np

from talus.refused import Refused

from . import headers
from .table import Column, Table

BUS_EVENT = 1 << 1  # a group's flag: it holds frames of a bus
FRAME = re.compile(r"^(CAN|LIN|FLX|ETH|MOST)_\w+(\.|$)")  # the standard's names of frames and their fields
TIME = 1  # a master's kind, besides angle, distance and index
NO_UNIT = {"", "-"}


class Left:
    """What is left out of a file, and why."""

    def __init__(self):
        self.said = {}

    def out(self, why, name):
        self.said.setdefault(why, {})[name] = None  # in order, and once

    def notes(self):
        return [f"{why}, left out: {', '.join([*names][:12])}{', ...' if len(names) > 12 else ''}" for why, names in self.said.items()]


def tables(asammdf, path):
    """A Table for each clock; Refused where the file is damaged or has no channel of numbers."""
    left = Left()
    start, groups = _read(asammdf, path, left)
    out = _by_clock(groups, path)
    if not out:
        raise Refused(2, f"{path}: no channel of numbers with a time: {'; '.join(left.notes()) or 'it is empty'}")
    out[0].notes += [*left.notes(), f"its time counts from {start.isoformat(' ')}"]
    return out


def _read(asammdf, path, left):
    """(beginning, groups). Read from memory: by its path asammdf completes and may delete files of some names."""
    content, damage = io.BytesIO(Path(path).read_bytes()), None
    with _quiet():
        try:
            with asammdf.MDF(content) as file:
                groups = [_group(file, number, path, left) for number in range(len(file.groups))]
                return file.header.start_time, [group for group in groups if group]
        except Refused:
            raise
        except Exception as error:  # noqa: BLE001  the reader raises many kinds for a damaged file
            damage = f"{type(error).__name__} {error}".replace(repr(content), path).strip().splitlines()[0][:200]
        gc.collect()  # throws the half-read file away
    raise Refused(2, f"{path}: damaged or no MDF file: {damage}")


@contextlib.contextmanager
def _quiet():
    """Nothing that asammdf logs, prints, or says when a half-read file is thrown away: what stops it is raised."""
    log, hook = logging.getLogger("asammdf"), sys.unraisablehook
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    sys.unraisablehook = lambda _: None
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            yield
    finally:
        log.setLevel(level)
        sys.unraisablehook = hook


def _group(file, number, path, left):
    """(instants [s], columns) of a group; None where nothing of it can be used."""
    group, name = file.groups[number], f"group {number + 1}"
    master = file.masters_db.get(number)
    if not group.channel_group.cycles_nr:
        return left.out("no samples", name)
    if master is None or getattr(group.channels[master], "sync_type", TIME) != TIME:
        return left.out("no time", name)
    _check_places(group, path, name)
    is_bus = getattr(group.channel_group, "flags", 0) & BUS_EVENT
    wanted = []
    for index, channel in enumerate(group.channels):
        if is_bus and FRAME.match(channel.name):
            left.out("frames of a bus, to be decoded with their DBC first", channel.name.partition(".")[0])
        elif index != master:
            wanted.append(index)
    signals = file.select([(None, number, index) for index in wanted], copy_master=False)
    columns = [column for column in (_column(signal, left) for signal in signals) if column]
    if not columns:
        return None
    short = min(len(signal.timestamps) for signal in signals)
    if short < group.channel_group.cycles_nr:
        raise Refused(2, f"{path}: is cut: {name} has {short} of {group.channel_group.cycles_nr} samples")
    return signals[0].timestamps, columns


def _check_places(group, path, name):
    """A damaged file's channel may stand outside of its record, where asammdf ends the process."""
    size = group.channel_group.samples_byte_nr
    for channel in group.channels:
        if hasattr(channel, "byte_offset"):  # MDF 4
            bits = 8 * channel.byte_offset + channel.bit_offset
        else:
            bits = 8 * channel.additional_byte_offset + channel.start_offset
        if channel.bit_count and bits + channel.bit_count > 8 * size:
            raise Refused(2, f"{path}: damaged MDF file: {name}: {channel.name} stands outside of its record of {size} bytes")


def _column(signal, left):
    """A channel's Column, NaN where the file calls it invalid; None where it has no single numbers."""
    values = signal.samples
    if values.dtype.kind not in "fiub" or values.ndim > 1:
        return left.out("texts or arrays", signal.name)
    if signal.invalidation_bits is not None and signal.invalidation_bits.any():
        values = values.astype(float)
        values[signal.invalidation_bits] = np.nan
    return Column(*_named(signal), np.asarray(values))


def _named(signal):
    unit = signal.unit.strip()
    return headers.beside(signal.name, None if unit in NO_UNIT else unit)


def _by_clock(groups, path):
    """Groups with the same instants are one Table, except where a name would stand in it twice."""
    found = {}
    for seconds, columns in groups:
        names, key = {column.name for column in columns}, (seconds.tobytes(), 0)
        while key in found and names & {column.name for column in found[key].columns}:
            key = key[0], key[1] + 1
        if key not in found:
            time = Column("time", "s", np.asarray(seconds))
            found[key] = Table(path, [time], clock=time)
        found[key].columns += columns
    out = list(found.values())
    if len(out) > 1:
        for number, table in enumerate(out, 1):
            table.path = f"{path}, clock {number}"
    return out
