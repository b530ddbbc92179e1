"""A record in candump's log format, as columns.

    record = Record("walk.log")
    for part in parts_of(record): part.time_ns, part.source, part.identifier, part.length, part.data, part.line

Only what is a data frame becomes a row; remote and error frames are counted.
"""

import gzip
import os
import re
import zlib
from dataclasses import dataclass, field
from itertools import count

import numpy as np
from talus._library import ffi, files
from talus.refused import Refused

FILES = files()  # apps/candump: what a line holds
BLOCK = 1 << 18
MOST_LINE = 1 << 20  # characters
MOST_UNASKED = 1 << 26  # bytes that are unpacked whatever their packed size
MOST_GROWTH = 100
MOST_INTERFACES = int(FILES.CANDUMP_NAMES)
MOST_DROPS = 1000  # that are told line by line
MOST_DIGITS = 20
EXTENDED = 1 << 31  # set in identifiers of 29 bits
CLASSIC_BYTES = 8
MOST_BYTES, SHORTEST = int(FILES.CANDUMP_BYTES), int(FILES.CANDUMP_SHORTEST)


@dataclass
class Record:
    path: str
    sources: list[str] = field(default_factory=list)  # interfaces' names
    file: str = ""  # that is being read, and how many lines stand before it
    before: int = 0
    lines: int = 0  # of all files
    cut: int = 0  # number of the last line when it is no whole one
    remote: int = 0
    errors: int = 0
    drops: int = 0  # lines of candump's own DROPCOUNT
    dropped_frames: int = 0
    dropped: list = field(default_factory=list)  # (line, frames) of the first ones


def blocks(path):
    """(bytes of whole lines, is it the end) of a file; what follows the last newline comes alone, at the end."""
    rest = b""
    try:
        for block in pieces(path):
            if not block.strip(b"\0"):  # what a power cut leaves
                continue
            whole, newline, tail = block.rpartition(b"\n")
            if newline:
                yield rest + whole + newline, False
                rest = tail
            elif len(rest) > MOST_LINE:
                raise Refused(2, f"{path}: is no record: a line has more than {MOST_LINE} characters")
            else:
                rest += block
    except OSError as error:
        raise Refused(2, f"{path}: cannot be read: {error.strerror or error}") from error
    except (EOFError, zlib.error):
        pass  # a compressed record that was cut off: what came out of it counts
    yield rest, True


def pieces(path):
    """A file's bytes, unpacked where it is compressed. What grows a hundredfold holds nothing that happened."""
    with open(path, "rb") as packed, gzip.GzipFile(fileobj=packed) if str(path).endswith(".gz") else packed as file:
        total = 0
        while block := file.read(BLOCK):
            total += len(block)
            if total > MOST_UNASKED and total > MOST_GROWTH * packed.tell():
                raise Refused(2, f"{path}: is no record: it unpacks to more than {MOST_GROWTH} times its size")
            yield block


def odd_line(record, line, text):
    """A line that holds no frame: candump's own word about drops, or a fault."""
    words = text.split()
    if not words:
        return
    if words[0] == b"DROPCOUNT:" and len(words) > 2 and words[2].isdigit() and len(words[2]) <= MOST_DIGITS:
        record.drops += 1
        record.dropped_frames += int(words[2])
        if record.drops <= MOST_DROPS:
            record.dropped.append((line, int(words[2])))
        return
    shown = text.decode("utf-8", "replace").strip()
    shown = "".join(c if c.isprintable() else "?" for c in shown)
    raise Refused(2, f"{record.file}:{line - record.before}: no line of candump's log format: '{shown[:60]}'")


def series(path):
    """The files of a record that was divided: REC.log, REC.001.log, ... as long as the next one is there; any of them may be
    compressed (REC.log.gz)."""
    yield f"{path}.gz" if os.path.exists(f"{path}.gz") and not os.path.exists(path) else path
    stem = re.sub(r"(\.log)?(\.gz)?$", "", path, count=1)
    for number in count(1):
        found = next((name for end in (".log", ".log.gz") if os.path.exists(name := f"{stem}.{number:03d}{end}")), None)
        if found is None:
            return
        yield found


@dataclass
class Part:
    """Data frames of some lines, in their order."""

    time_ns: np.ndarray
    source: np.ndarray  # index into the record's sources
    identifier: np.ndarray
    length: np.ndarray
    data: np.ndarray  # (n, 8), or (n, 64) with CAN FD
    line: np.ndarray  # counted from 1


def parts_of(record):
    """Its data frames, some thousand at a time, from all files in which it goes on; `record` grows meanwhile. Refused with
    status 2 when it is none."""
    names, frames = {}, 0
    for path in series(record.path):
        record.file, record.before = path, record.lines
        for text, last in blocks(path):
            if last:
                record.cut = record.lines + 1 if text.strip(b"\0") else record.cut
                break
            part = part_of(record, text, names)
            frames += len(part.line)
            yield part
    if not frames:
        raise Refused(2, f"{record.path}: holds no frame")


def part_of(record, text, names):
    if text.endswith(b"\0\n"):
        text = text.rstrip(b"\0\n") + b"\n"
    block, part = empty_columns(text)
    while (found := FILES.candump_lines_read(block)) > 0:
        odd_line(record, record.lines + block.lines, text[block.begin:block.end])
    number = numbers_of(block, text, names)
    if found < 0 or len(names) > MOST_INTERFACES:
        raise Refused(2, f"{record.file}:{record.lines - record.before + 1}: more than {MOST_INTERFACES} interfaces")
    record.remote += block.remote
    record.errors += block.errors
    record.sources = list(names)
    width = MOST_BYTES if block.widest > CLASSIC_BYTES else CLASSIC_BYTES
    n = block.frames
    part = Part(part.time_ns[:n], number[part.source[:n]], part.identifier[:n], part.length[:n], part.data[:n, :width], part.line[:n] + record.lines)
    record.lines += block.lines
    return part


def empty_columns(text):
    """(a struct candump_lines, the Part that it fills)."""
    n = min(text.count(b"\n"), len(text) // SHORTEST)
    part = Part(np.empty(n, np.int64), np.empty(n, np.uint16), np.empty(n, np.int64), np.empty(n, np.uint8), np.zeros((n, MOST_BYTES), np.uint8),
                np.empty(n, np.int64))  # fmt: skip
    block = ffi.new("struct candump_lines *", {"text": ffi.from_buffer(text), "size": len(text)})
    block.time_ns, block.identifier, block.line = (ffi.from_buffer("int64_t[]", column) for column in (part.time_ns, part.identifier, part.line))
    block.name = ffi.from_buffer("uint16_t[]", part.source)
    block.length, block.data = (ffi.from_buffer("uint8_t[]", column) for column in (part.length, part.data))
    return block, part


def numbers_of(block, text, names):
    """The interfaces' numbers in `names`, which grows, for those of a block."""
    found = [(one.least, text[one.at:one.at + one.n].decode("utf-8", "replace")) for one in block.found[0:block.names]]
    for _, name in sorted(found):
        names.setdefault(name, len(names))
    return np.array([names[name] for _, name in found], np.uint16)


def read(path):
    """A whole record that fits into memory, its frames as a Part's columns."""
    record = Record(str(path))
    parts = list(parts_of(record))
    width = max(part.data.shape[1] for part in parts)
    for part in parts:
        part.data = np.pad(part.data, ((0, 0), (0, width - part.data.shape[1])))
    for name in Part.__dataclass_fields__:
        setattr(record, name, np.concatenate([getattr(part, name) for part in parts]))
    return record
