"""What the export found, as JSON and in words."""

import heapq

import numpy as np

LOST = ("lost", "short", "silent", "restarted", "jumped", "contradicting", "stale", "unusable")  # what makes the exit status 1
WORDS = {
    "lost": "lost", "repeated": "repeated", "swapped": "out of order", "late": "late by more than a period",
    "short": "shorter than the DBC says", "silent": "missing while its sender went on",
    "restarted": "where the counter began anew", "jumped": "where the stamps' clock was set or the sender stood still", "contradicting": "with a number that came before, but other content",
    "stale": "too long after the frames around it in number to be put between them",
    "unusable": "that are no number, or beyond 1e9",
}  # fmt: skip
NOUNS = {"unusable": "value"}  # what is counted, where it is not frames


RANKS = {"jumped": 1, "silent": 2, "late": 3, "short": 4}  # in which order faults of one frame stand
AT_ONCE = 1000


def sorted_faults(stream, kinds=tuple(WORDS)):
    """As they stand in the record; short frames behind the others, for they have a line and no number."""
    faults = [fault for fault in stream.faults if fault.kind in kinds]
    return sorted(faults, key=lambda fault: (fault.kind == "short", fault.index, RANKS.get(fault.kind, 0), fault.number))


def entries_of(stream, faults, zero_ns):
    """Faults of a stream with their places in the record."""
    turn = 1 << stream.message.counter_bits if stream.message.counter else 1
    whole = [fault for fault in faults if fault.kind != "short"]
    index = np.array([fault.index for fault in whole], np.int64)
    frames = iter(stream.converted(stream.frames.take(index)).tolist())
    before = iter(stream.frames.take(np.maximum(index - 1, 0))["line"].tolist())
    about = {"message": stream.message.name, "source": stream.source}
    for fault in faults:
        if fault.kind == "short":
            yield {"kind": "short", **about, "count": 1, "line": fault.index}
            continue
        (stamp_ns, line, *_), after_line = next(frames), next(before)
        entry = {"kind": fault.kind, **about, "counter": fault.number % turn, "count": fault.count, "line": line,
                 "time_s": round((stamp_ns - zero_ns) / 1e9, 6)}  # fmt: skip
        yield entry | ({"after_line": after_line if fault.index else 0} if fault.kind == "lost" else {})


def fault_entries(stream, zero_ns):
    """All that are listed, in the order of their lines."""
    faults = sorted_faults(stream)
    short = [fault for fault in faults if fault.kind == "short"]
    others = faults[:len(faults) - len(short)]
    yield from heapq.merge(*(in_pieces(stream, those, zero_ns) for those in (others, short)), key=lambda entry: entry["line"])


def in_pieces(stream, faults, zero_ns):
    for first in range(0, len(faults), AT_ONCE):
        yield from entries_of(stream, faults[first:first + AT_ONCE], zero_ns)


def stream_entry(stream):
    entry = {"message": stream.message.name, "source": stream.source, "frames": len(stream.frames) + stream.unread,
             **{kind: stream.faults.frames[kind] for kind in WORDS}, "left_out": stream.outside}  # fmt: skip
    return entry | ({"delay": dict(zip(("median_s", "quantile_999_s", "worst_s"), stream.delay_s, strict=True))} if stream.delay_s else {})


class Listed(list):
    """A list for json whose entries are made one after the other."""

    def __init__(self, entries):
        super().__init__()
        self.first = next(entries, None)
        self.rest = entries

    def __bool__(self):
        return self.first is not None

    def __iter__(self):
        yield self.first
        yield from self.rest


def place(fault):
    if fault["kind"] == "lost":
        numbers = f"counter {fault['counter']}" + (f" and {fault['count'] - 1} more" if fault["count"] > 1 else "")
        return f"{numbers} between lines {fault['after_line']} and {fault['line']}"
    if fault["kind"] == "silent":
        return f"at line {fault['line']}"
    return f"line {fault['line']}"


def words_of(stream, kinds, zero_ns):
    """One line a kind of fault."""
    for kind, words in WORDS.items():
        if kind not in kinds or not stream.faults.places[kind]:
            continue
        frames = stream.faults.frames[kind]
        shown = "; ".join(place(entry) for entry in entries_of(stream, sorted_faults(stream, (kind,))[:3], zero_ns))
        more = f", and {stream.faults.places[kind] - 3} more places" if stream.faults.places[kind] > 3 else ""
        about = "about " if kind == "silent" else ""
        yield f"{stream.name}: {about}{frames} {NOUNS.get(kind, 'frame')}{'s' * (frames != 1)} {words}: {shown}{more}"


def identifier_text(identifier):
    return f"0x{identifier & 0x1FFFFFFF:08X}" if identifier >> 31 else f"0x{identifier:03X}"
