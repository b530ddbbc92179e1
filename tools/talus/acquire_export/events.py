"""The events file (JSON lines) beside a record: clocks, drops, and whether it ended of its own will."""

import json
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from talus.refused import Refused

from .adapter_clock import Pair, to_monotonic
from .clock_model import Clock, ClockModel, is_step
from .step_search import MOST_USUAL

LINE = 1 << 20  # no event is longer
MOST_TOLD = 1000  # drops, and changes of bus and link
MANY_CLOCKS, MOST_CLOCKS = 50_000, 150_000  # readings: from there on those are left out that lie nearer than
APART_NS = 20 * 10**9
MOST_LINES = 1000
MOST_MONO_NS, MOST_REAL_NS = 1 << 60, 1 << 62  # 36 years after the start, 146 after 1970: no reading is later


def whole(entry, key, otherwise=None):
    """A whole number of 64 bits, or ValueError."""
    value = entry.get(key, otherwise)
    if type(value) is not int or not -(2**63) <= value < 2**63:
        raise ValueError(key)
    return value


def word(entry, key):
    value = entry.get(key)
    if not isinstance(value, str):
        raise ValueError(key)
    return "".join(c if c.isprintable() else "?" for c in value)[:60]


@dataclass
class Events:
    path: str = ""
    clocks: list = field(default_factory=list)  # Clock
    hardware: dict = field(default_factory=dict)  # {source: [Pair]}
    stamps: dict = field(default_factory=dict)  # {source: software, hardware, ...}
    marks: object = None  # spool of edges and pulses of GPIO lines
    drops: list = field(default_factory=list)  # what the recorder itself says it lost, the first ones
    states: list = field(default_factory=list)  # changes of bus and link, the first ones
    dropped: int = 0  # frames of all drops
    perhaps_lost: int = 0  # more frames, at most, where interfaces vanished
    not_known: int = 0  # interfaces that vanished, of which nobody has counted what was on its way
    more: int = 0  # drops and changes that were too many
    errors: int = 0  # error frames
    edges_lost: int = 0
    end: dict | None = None

    names: list = field(default_factory=list)  # of the lines that have marks

    def __post_init__(self):
        self._model = None

    @property
    def lost(self):
        return self.dropped + self.edges_lost

    def add(self, entries, entry):
        if len(entries) < MOST_TOLD:
            entries.append(entry)
        else:
            self.more += 1

    @property
    def model(self):
        """The clock model; all readings are in by now."""
        self._model = self._model or ClockModel(self.clocks)
        return self._model

    def take(self, entry):
        take = getattr(self, f"take_{entry.get('type')}", None)
        if take:
            take(entry)

    def take_header(self, entry):
        self.stamps = {word(source, "name"): word(source, "stamps") for source in entry.get("sources", [])}

    def take_clock(self, entry):
        """Of very many readings those are enough that lie some seconds apart."""
        clock = Clock(whole(entry, "mono_ns"), whole(entry, "real_ns"), whole(entry, "width_ns", 0), entry.get("set") is True)
        if not (0 <= clock.mono_ns < MOST_MONO_NS and 0 <= clock.real_ns < MOST_REAL_NS and clock.width_ns >= 0):
            raise ValueError("mono_ns, real_ns, width_ns")
        if len(self.clocks) >= MOST_CLOCKS:
            if is_step(self.clocks[-1], clock) or clock.mono_ns - self.clocks[-2].mono_ns >= APART_NS:
                raise Refused(2, f"{self.path}: more than {MOST_CLOCKS} readings of the clocks")
            self.clocks[-1] = clock
        elif len(self.clocks) >= MANY_CLOCKS and self.is_between(clock):
            self.clocks[-1] = clock
        else:
            self.clocks.append(clock)

    def is_between(self, clock):
        """Is the reading before this one near to the one before it, and the clock not set meanwhile?"""
        first, second = self.clocks[-2:]
        return not (is_step(first, second) or is_step(second, clock)) and clock.mono_ns - first.mono_ns < APART_NS

    def take_hardware_clock(self, entry):
        pairs = self.hardware.setdefault(word(entry, "source"), [])
        if len(pairs) >= MOST_CLOCKS:
            raise Refused(2, f"{self.path}: more than {MOST_CLOCKS} readings of an adapter's clock")
        pairs.append(Pair(whole(entry, "hw_ns"), whole(entry, "real_ns"), len(self.clocks)))

    def take_drop(self, entry):
        drop = {"source": word(entry, "source"), "where": word(entry, "where"), "lost": whole(entry, "lost"),
                "after": whole(entry, "after", 0)}  # fmt: skip
        self.dropped += drop["lost"]
        self.add(self.drops, drop)

    def take_vanished(self, entry):
        """An interface that is gone: what it had counted and nobody has read, and whether that is all."""
        if whole(entry, "lost", 0):
            self.take_drop({**entry, "where": "interface"})
        self.perhaps_lost += whole(entry, "perhaps_lost", 0)
        self.not_known += entry.get("known") is False

    def take_bus_state(self, entry, kind="bus state"):
        self.add(self.states, {"source": word(entry, "source"), "type": kind, "state": word(entry, "state"),
                               "after": whole(entry, "after", 0)})  # fmt: skip

    def take_link(self, entry):
        self.take_bus_state(entry, "interface")

    def take_error(self, entry):
        self.errors += whole(entry, "count", 1)

    def take_edge(self, entry):
        kind, source = word(entry, "type"), word(entry, "source")
        if source not in self.names:
            if len(self.names) >= MOST_LINES:
                raise Refused(2, f"{self.path}: more than {MOST_LINES} GPIO lines")
            self.names.append(source)
        row = kind == "pulse", self.names.index(source), whole(entry, "value"), whole(entry, "mono_ns")
        if self.marks is not None:
            self.marks.append_columns(*([value] for value in row))

    take_pulse = take_edge

    def all_marks(self):
        """Edges and pulses, as they stand in the report."""
        for rows in self.marks.chunks(1024) if self.marks is not None else ():
            for pulse, name, value, mono_ns in rows.tolist():
                yield {"kind": "pulse" if pulse else "edge", "source": self.names[name], "value": value, "mono_ns": mono_ns}

    def take_edges_lost(self, entry):
        self.edges_lost += whole(entry, "lost", 0)

    def take_end(self, entry):
        self.end = entry


def beside(record):
    """Where the events file of a record is: REC.jsonl for REC.log."""
    path = Path(record)
    return path.with_suffix("").with_suffix(".jsonl") if path.suffix == ".gz" else path.with_suffix(".jsonl")


def lines_of(path):
    """(number, text) of each whole line. A last line that was cut off is left out."""
    with open(path, "rb") as file:
        number = 0
        while line := file.readline(LINE):
            number += 1
            if not line.endswith(b"\n"):
                if len(line) == LINE and line.strip(b"\0"):
                    raise Refused(2, f"{path}:{number}: no line of a record's events file (too long)")
                return
            if line.strip(b"\0 \r\n"):
                yield number, line.strip(b"\0")


def read(path, store=None):
    """The events file, or None when there is none. Edges and pulses are kept in the store."""
    events = Events(str(path))
    events.marks = store and store.spool([("pulse", "?"), ("name", "i8"), ("value", "i8"), ("mono_ns", "i8")])
    number = 0
    try:
        for number, line in lines_of(path):
            events.take(json.loads(line))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise Refused(2, f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise Refused(2, f"{path}:{number}: no line of a record's events file ({type(error).__name__})") from error
    return events


class Clocks:
    """The clock of each interface, from its frames as they come: only where the clock was set they are looked at."""

    def __init__(self, events, store):
        self.events, self.store, self.frames = events, store, {}
        self.looks = events is not None and bool(events.model.steps)
        self.edges = cache(self.find_edges)  # goes with this object; a cache of the class would keep every record's frames

    def take(self, part, sources):
        for number in np.unique(part.source).tolist() if self.looks else ():
            rows = part.source == number
            if number not in self.frames:
                self.frames[number] = self.store.spool([("stamp_ns", "i8"), ("line", "i8")])
            self.frames[number].append_columns(part.time_ns[rows], part.line[rows])
        self.sources = sources

    def of(self, source):
        """The InterfaceClock of an interface, once all frames came."""
        if self.events is None:
            return InterfaceClock(None)
        if self.events.stamps.get(source) == "hardware" or source in self.events.hardware:
            straightly = to_monotonic(self.events.model, self.events.hardware.get(source, []))
            return InterfaceClock(straightly and (lambda stamp_ns, line: straightly(stamp_ns)))
        if not self.events.model.pieces:
            return InterfaceClock(None)
        edges = np.array(self.edges(self.sources.index(source)), np.int64)
        return InterfaceClock(lambda stamp_ns, line: self.events.model.convert_between(stamp_ns, np.searchsorted(edges, line, "right")))

    def find_edges(self, number):
        """The line of the first frame behind each step."""
        if not self.looks:
            return []
        frames = self.frames[number]
        places = self.events.model.edges(lambda first: (rows["stamp_ns"] for rows in frames.chunks(MOST_USUAL, first)), len(frames))
        return [int(frames.read(k, k + 1)["line"][0]) if k < len(frames) else 2**62 for k in places]


class InterfaceClock:
    """Turns stamps into instants of CLOCK_MONOTONIC, or leaves them where nothing relates the two."""

    def __init__(self, conversion):
        self.conversion, self.is_monotonic = conversion, conversion is not None

    def convert(self, stamp_ns, line):
        return self.conversion(stamp_ns, line) if self.conversion else stamp_ns
