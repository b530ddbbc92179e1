"""A record in candump's log format, as columns.

    record = Record("walk.log")
    for part in parts_of(record): part.time_ns, part.source, part.identifier, part.length, part.data, part.line

Lines of one layout (same length, same places of the marks) are decoded together, a column of characters at a
time. Only what is a data frame becomes a row; remote and error frames are counted.
"""

import gzip
import os
import re
import zlib
from dataclasses import dataclass, field
from itertools import count

import numpy as np
from talus.refused import Refused


BLOCK = 1 << 18
MOST_LINE = 1 << 20  # characters
MOST_UNASKED = 1 << 26  # bytes that are unpacked whatever their packed size
MOST_GROWTH = 100
MOST_INTERFACES = 1000
MOST_DROPS = 1000  # that are told line by line
MOST_DIGITS = 20
LATEST_S = 2**63 // 10**9  # seconds that nanoseconds in 64 bits can hold
EXTENDED = 1 << 31  # set in identifiers of 29 bits
ERROR_FLAG = 0x20000000
CLASSIC_BYTES = 8
LONGEST = 511  # a line with more characters holds no frame
OPEN, CLOSE, SPACE, MARK, NEWLINE, DOT, REMOTE = (ord(c) for c in "() #\n.R")

HEX = np.full(256, 255, np.uint8)
for _digit, _characters in enumerate("0 1 2 3 4 5 6 7 8 9 aA bB cC dD eE fF".split()):
    for _character in _characters:
        HEX[ord(_character)] = _digit
NO_PAIR = 256
PAIR = np.where((HEX[None, :] == 255) | (HEX[:, None] == 255), NO_PAIR, HEX[None, :].astype(np.uint16) << 4 | HEX[:, None]).ravel()  # of two characters


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


def nearest_behind(places, wanted, end):
    """For each line the first of `places` at or behind `wanted`; `end` where there is none before it."""
    index = np.searchsorted(places, wanted)
    found = np.append(places, np.iinfo(np.int64).max)[index]
    return np.where(found < end, found, end)


def digits(characters):
    """(whole number, are they all digits) of each row of characters."""
    value = characters - np.uint8(ord("0"))  # what is less wraps
    power = 10.0 ** np.arange(characters.shape[1] - 1, -1, -1)
    return (value.astype(float) @ power).astype(np.int64), (value <= 9).all(1)  # few digits: exact


def hexadecimal(characters):
    """(whole number, are they all hexadecimal digits)."""
    value = HEX[characters]
    number = np.zeros(len(value), np.int64)
    for column in value.T:
        number = number << 4 | column
    return number, (value != 255).all(1)


def payload(characters):
    """(bytes, are they all hexadecimal digits) of each row of pairs."""
    value = PAIR[np.ascontiguousarray(characters).view("<u2")]
    return value.astype(np.uint8), (value < NO_PAIR).all(1)


class Block:
    """The lines of one block, decoded into `columns`; `good` says of which lines that succeeded."""

    def __init__(self, text, names):
        self.bytes = np.frombuffer(text, np.uint8)
        self.end = np.flatnonzero(self.bytes == NEWLINE)
        self.start = np.append(0, self.end[:-1] + 1)
        self.names = names  # {interface: its number}, grows
        n = len(self.end)
        self.good = np.zeros(n, bool)
        self.kind = np.zeros(n, np.uint8)  # of good ones: 0 data, 1 remote, 2 error
        self.time_ns, self.source = np.zeros(n, np.int64), np.zeros(n, np.uint16)
        self.identifier, self.length = np.zeros(n, np.int64), np.zeros(n, np.uint8)
        self.data = np.zeros((n, CLASSIC_BYTES), np.uint8)
        for layout in self.layouts():
            self.decode(*layout)

    def layouts(self):
        """Lines with the same marks in the same places: (length, dot, close, space, mark), what follows the mark
        (0 data, 1 remote frame, 2 CAN FD), is there candump's direction at the end, rows."""
        end = self.end - (self.bytes[np.maximum(self.end - 1, 0)] == ord("\r")) * (self.end > self.start)
        close = nearest_behind(np.flatnonzero(self.bytes == CLOSE), self.start, end)
        dot = nearest_behind(np.flatnonzero(self.bytes == DOT), self.start, end)
        space = nearest_behind(np.flatnonzero(self.bytes == SPACE), close + 2, end)
        mark = nearest_behind(np.flatnonzero(self.bytes == MARK), space, end)
        behind = self.bytes[np.minimum(mark + 1, len(self.bytes) - 1)]
        follows = np.select([mark + 1 >= end, behind == REMOTE, behind == MARK], [0, 1, 2], 0)
        marks = np.minimum(np.stack([end, dot, close, space, mark]) - self.start, LONGEST)
        key = follows + 4 * (self.bytes[np.maximum(end - 2, 0)] == SPACE)
        for place in marks:
            key = key << 9 | place
        kinds, which = np.unique(key, return_inverse=True)
        order = np.argsort(which, kind="stable")
        for rows in np.split(order, np.cumsum(np.bincount(which))[:-1]):
            first = rows[0]
            yield tuple(int(place[first]) for place in marks), int(follows[first]), bool(key[first] >> 47), rows

    def decode(self, marks, follows, direction, rows):
        length, dot, close, space, mark = marks
        if not (2 <= dot <= 12 and dot < close - 1 and close - dot <= 10 and close + 2 < space < mark < length < LONGEST and close < 30):
            return
        text = np.lib.stride_tricks.sliding_window_view(self.bytes, length)[self.start[rows]]
        seconds, good = digits(text[:, 1:dot])
        fraction, decimal = digits(text[:, dot + 1:close])
        good &= decimal & (seconds >= 0) & (seconds < LATEST_S) & (text[:, 0] == OPEN) & (text[:, close + 1] == SPACE)
        identifier, known = self.identifiers(text[:, space + 1:mark])
        self.time_ns[rows] = seconds * 10**9 + fraction * 10 ** (9 - (close - dot - 1))
        self.identifier[rows] = identifier
        self.kind[rows] = np.where((identifier & ERROR_FLAG != 0) & (mark - space - 1 == 8), 2, 0)
        good &= known & self.payloads(text[:, mark + 1:length - 2 * direction], follows, rows)
        self.sources(text[:, close + 2:space], rows, good)
        self.good[rows] = good

    @staticmethod
    def identifiers(text):
        number, good = hexadecimal(text)
        if text.shape[1] == 8:
            return np.where(number & ERROR_FLAG, number, number | EXTENDED), good
        return number, good & (text.shape[1] == 3) & (number < 0x800)

    def payloads(self, text, follows, rows):
        """Fills length and data from what stands behind the mark; which lines have such."""
        if follows == 1:
            self.kind[rows] = 1
            return np.full(len(rows), text.shape[1] <= 2)
        if follows == 2:
            text = text[:, 2:]
        most = 64 if follows == 2 else CLASSIC_BYTES
        if text.shape[1] % 2 or text.shape[1] > 2 * most:
            return np.zeros(len(rows), bool)
        values, good = payload(text)
        if values.shape[1] > self.data.shape[1]:
            self.data = np.pad(self.data, ((0, 0), (0, 64 - self.data.shape[1])))
        self.data[rows[:, None], np.arange(values.shape[1])] = values
        self.length[rows] = values.shape[1]
        return good

    def sources(self, text, rows, good):
        names, which = np.unique(np.ascontiguousarray(text).view(f"S{text.shape[1]}").ravel(), return_inverse=True)
        number = []
        for index, name in enumerate(names):
            if not good[which == index].any():
                number.append(0)
                continue
            number.append(self.names.setdefault(name.decode("utf-8", "replace"), len(self.names)))
        if len(self.names) > MOST_INTERFACES:
            raise Refused(2, f"more than {MOST_INTERFACES} interfaces")
        self.source[rows] = np.array(number, np.uint16)[which]


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
    try:
        block = Block(text, names)
    except Refused as error:
        raise Refused(2, f"{record.file}:{record.lines - record.before + 1}: {error.text}") from error
    for index in np.flatnonzero(~block.good & (block.end > block.start)):
        odd_line(record, record.lines + int(index) + 1, text[block.start[index]:block.end[index]])
    rows = np.flatnonzero(block.good & (block.kind == 0))
    record.remote += int((block.good & (block.kind == 1)).sum())
    record.errors += int((block.good & (block.kind == 2)).sum())
    record.sources = list(names)
    columns = [block.time_ns, block.source, block.identifier, block.length, block.data]
    part = Part(*(column[rows] for column in columns), rows + record.lines + 1)
    record.lines += len(block.end)
    return part


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
