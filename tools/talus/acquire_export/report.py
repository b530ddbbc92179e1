"""What the export found, as JSON and in words."""

from collections import Counter

import numpy as np

LOST = ("lost", "short", "silent", "restarted", "jumped", "contradicting")  # what makes the exit status 1
WORDS = {
    "lost": "lost", "repeated": "repeated", "swapped": "out of order", "late": "late by more than a period",
    "short": "shorter than the DBC says", "silent": "missing while its sender went on",
    "restarted": "where the counter began anew", "jumped": "where the stamps' clock was set or the sender stood still", "contradicting": "with a number that came before, but other content",
}  # fmt: skip


def fault_entries(stream, zero_ns):
    """Every fault of a stream with its place in the record."""
    turn = 1 << stream.message.counter_bits if stream.message.counter else 1
    entries = []
    for fault in stream.faults:
        entry = {"kind": fault.kind, "message": stream.message.name, "source": stream.source,
                 "counter": fault.number % turn, "count": fault.count, "line": int(stream.line[fault.index]),
                 "time_s": round((int(stream.stamp_ns[fault.index]) - zero_ns) / 1e9, 6)}  # fmt: skip
        if fault.kind == "lost":
            entry["after_line"] = int(stream.line[fault.index - 1]) if fault.index else 0
        entries.append(entry)
    entries += [{"kind": "short", "message": stream.message.name, "source": stream.source, "count": 1, "line": int(line)}
                for line in stream.short_lines]  # fmt: skip
    return sorted(entries, key=lambda entry: entry["line"])


def delays(delay_s):
    """Of frames behind their ticks."""
    half, most, worst = np.quantile(delay_s, (0.5, 0.999, 1.0))
    return {"median_s": float(half), "quantile_999_s": float(most), "worst_s": float(worst)}


def stream_entry(stream, faults, delay_s):
    count = Counter()
    for fault in faults:
        count[fault["kind"]] += fault["count"]
    entry = {"message": stream.message.name, "source": stream.source, "frames": len(stream.rows) + len(stream.unread),
             **{kind: count[kind] for kind in WORDS}}  # fmt: skip
    return entry | ({"delay": delays(delay_s)} if delay_s is not None and len(delay_s) else {})


def place(fault):
    if fault["kind"] == "lost":
        numbers = f"counter {fault['counter']}" + (f" and {fault['count'] - 1} more" if fault["count"] > 1 else "")
        return f"{numbers} between lines {fault['after_line']} and {fault['line']}"
    if fault["kind"] == "silent":
        return f"at line {fault['line']}"
    return f"line {fault['line']}"


def words_of(stream, faults):
    """One line a kind of fault."""
    for kind, words in WORDS.items():
        those = [fault for fault in faults if fault["kind"] == kind]
        if not those:
            continue
        frames = sum(fault["count"] for fault in those)
        more = f", and {len(those) - 3} more places" if len(those) > 3 else ""
        shown = "; ".join(place(fault) for fault in those[:3])
        about = "about " if kind == "silent" else ""
        yield f"{stream.name}: {about}{frames} frame{'s' * (frames != 1)} {words}: {shown}{more}"


def identifier_text(identifier):
    return f"0x{identifier & 0x1FFFFFFF:08X}" if identifier >> 31 else f"0x{identifier:03X}"
