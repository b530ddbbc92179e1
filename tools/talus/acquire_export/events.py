"""The events file (JSON lines) beside a record: clocks, drops, and whether it ended of its own will."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .clock_model import Clock, ClockModel
from .refused import Refused

LINE = 1 << 20  # no event is longer


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
    hardware: dict = field(default_factory=dict)  # {source: [(hw_ns, real_ns)]}
    stamps: dict = field(default_factory=dict)  # {source: software, hardware, ...}
    marks: list = field(default_factory=list)  # edges and pulses of GPIO lines
    drops: list = field(default_factory=list)  # what the recorder itself says it lost
    states: list = field(default_factory=list)  # changes of bus and link
    errors: int = 0  # error frames
    edges_lost: int = 0
    end: dict | None = None

    def __post_init__(self):
        self._model = None

    @property
    def lost(self):
        return sum(drop["lost"] for drop in self.drops) + self.edges_lost

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
        self.clocks.append(Clock(whole(entry, "mono_ns"), whole(entry, "real_ns"), whole(entry, "width_ns", 0), entry.get("set") is True))

    def take_hardware_clock(self, entry):
        self.hardware.setdefault(word(entry, "source"), []).append((whole(entry, "hw_ns"), whole(entry, "real_ns")))

    def take_drop(self, entry):
        self.drops.append({"source": word(entry, "source"), "where": word(entry, "where"), "lost": whole(entry, "lost"),
                           "after": whole(entry, "after", 0)})  # fmt: skip

    def take_bus_state(self, entry):
        self.states.append({"source": word(entry, "source"), "type": "bus state", "state": word(entry, "state"),
                            "after": whole(entry, "after", 0)})  # fmt: skip

    def take_link(self, entry):
        self.take_bus_state(entry)
        self.states[-1]["type"] = "interface"

    def take_error(self, entry):
        self.errors += whole(entry, "count", 1)

    def take_edge(self, entry):
        self.marks.append({"kind": word(entry, "type"), "source": word(entry, "source"), "value": whole(entry, "value"),
                           "mono_ns": whole(entry, "mono_ns")})  # fmt: skip

    take_pulse = take_edge

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


def read(path):
    """The events file, or None when there is none."""
    events = Events(str(path))
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


def straight(pairs):
    """A function from the first clock of the pairs to the second: straight between them, at the same speed
    beyond. None when there are no pairs or the first clock was set back."""
    pairs = sorted(set(pairs), key=lambda pair: pair[1])
    first, second = (np.array(column, np.int64) for column in zip(*pairs, strict=True)) if pairs else ([], [])
    if len(first) == 0 or np.any(np.diff(first) <= 0):
        return None
    offset = second - first

    def convert(t_ns):
        return t_ns + np.rint(np.interp(t_ns - first[0], first - first[0], offset - offset[0])).astype(np.int64) + offset[0]

    return convert


def hardware_to_monotonic(events, source):
    """From the adapter's clock: its pairs with realtime, each on the monotonic clock."""
    pairs = events.hardware.get(source, [])
    mono = events.model.convert(np.array([real for _, real in pairs], np.int64))
    return straight([(hw, int(t)) for (hw, _), t in zip(pairs, mono, strict=True)]) if mono is not None else None


def monotonic(events, source, t_ns):
    """(stamps of a source, in the order of their lines, on the monotonic clock; were they converted?)."""
    if events is None:
        return t_ns, False
    if events.stamps.get(source) == "hardware" or source in events.hardware:
        convert = hardware_to_monotonic(events, source)
        return (convert(t_ns), True) if convert else (t_ns, False)
    mono = events.model.convert(t_ns)
    return (t_ns, False) if mono is None else (mono, True)
