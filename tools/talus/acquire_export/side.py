"""The file of JSON lines beside a record: clocks, drops, and whether it ended of its own will."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .refused import Refused


@dataclass
class Side:
    path: str = ""
    clocks: list = field(default_factory=list)  # (real_ns, mono_ns)
    hardware: dict = field(default_factory=dict)  # {source: [(hw_ns, real_ns)]}
    stamps: dict = field(default_factory=dict)  # {source: software, hardware, ...}
    marks: list = field(default_factory=list)  # edges and pulses of GPIO lines
    drops: list = field(default_factory=list)  # what the recorder itself says it lost
    states: list = field(default_factory=list)  # changes of bus and link
    errors: int = 0  # error frames
    edges_lost: int = 0
    end: dict | None = None

    @property
    def lost(self):
        return sum(int(drop.get("lost") or 0) for drop in self.drops) + self.edges_lost

    def take(self, entry):
        kind = entry.get("type")
        if kind == "header":
            self.stamps = {source["name"]: source.get("stamps") for source in entry.get("sources", [])}
        elif kind == "clock":
            self.clocks.append((int(entry["real_ns"]), int(entry["mono_ns"])))
        elif kind == "hardware_clock":
            self.hardware.setdefault(entry["source"], []).append((int(entry["hw_ns"]), int(entry["real_ns"])))
        elif kind == "drop":
            self.drops.append(entry)
        elif kind in ("bus_state", "link"):
            self.states.append(entry)
        elif kind == "error":
            self.errors += int(entry.get("count", 1))
        elif kind in ("edge", "pulse"):
            self.marks.append({"kind": kind, "source": entry["source"], "value": entry["value"], "mono_ns": int(entry["mono_ns"])})
        elif kind == "edges_lost":
            self.edges_lost += int(entry.get("lost", 0))
        elif kind == "end":
            self.end = entry


def beside(record):
    """Where the side file of a record is: REC.jsonl for REC.log."""
    path = Path(record)
    return path.with_suffix("").with_suffix(".jsonl") if path.suffix == ".gz" else path.with_suffix(".jsonl")


def read(path):
    """The side file, or None when there is none. A last line that was cut off is left out."""
    try:
        text = Path(path).read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise Refused(2, f"{path}: cannot be read: {error.strerror}") from error
    side = Side(str(path))
    for number, line in enumerate(text.rstrip(b"\0").split(b"\n")[:-1], 1):
        if not line.strip():
            continue
        try:
            side.take(json.loads(line))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise Refused(2, f"{path}:{number}: no line of a record's side file ({type(error).__name__})") from error
    return side


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


def monotonic(side, source, t_ns):
    """(stamps of a source on the monotonic clock, were they converted?)."""
    if side is None:
        return t_ns, False
    clock = straight(side.clocks)
    if side.stamps.get(source) == "hardware" or source in side.hardware:
        hardware = straight(side.hardware.get(source, []))
        if not (hardware and clock):
            return t_ns, False
        t_ns = hardware(t_ns)
    return (clock(t_ns), True) if clock else (t_ns, False)
