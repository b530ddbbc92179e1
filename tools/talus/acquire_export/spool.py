"""Columns on disk: what a long record holds does not fit into memory, what is computed of it at a time does.

    store = Store(folder)                        # one unnamed file
    spool = store.spool([("number", "i8"), ("time_ns", "f8")])
    spool.append(rows)
    for rows in spool.chunks(): ...
    spool.read(first, end), spool.take(indices), spool.search("number", 7)
    for part, rows, first in around(spool, "number", wanted): ...
"""

import os
import tempfile
from array import array
from bisect import bisect_right
from contextlib import contextmanager
from functools import cache

import numpy as np

from talus.refused import Refused

CHUNK = 16_384  # rows that are computed at a time
MOST_WAITING = 2 << 20  # bytes of all spools of a store that are not yet in its file
MOST_AROUND = 4 * CHUNK
AT_ONCE = 4096  # rows among which a search ends


@contextmanager
def told():
    try:
        yield
    except OSError as error:
        raise Refused(1, f"a temporary file cannot be written or read: {error.strerror}") from error


@cache
def dtype_of(columns):
    return np.dtype(list(columns))


class Store:
    """One file, which has no name and so is gone with the process, whatever becomes of it."""

    def __init__(self, folder):
        with told():
            self.file = tempfile.TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115 - lives as long as the store
        self.folder, self.end, self.waiting = folder, 0, 0
        self.unwritten = []  # spools with rows that wait

    def spool(self, dtype):
        return Spool(self, dtype_of(tuple(dtype)))

    def write(self, rows):
        """Where they stand."""
        place, left = self.end, memoryview(rows.view(np.uint8).reshape(-1))
        with told():
            while left:
                written = os.pwrite(self.file.fileno(), left, self.end)
                self.end, left = self.end + written, left[written:]
        return place

    def read_into(self, rows, place):
        left = memoryview(rows.view(np.uint8).reshape(-1))
        with told():
            while left:
                count = os.preadv(self.file.fileno(), [left], place)
                if not count:
                    raise OSError(0, "it ends too early")
                place, left = place + count, left[count:]

    def flush(self):
        for spool in self.unwritten:
            spool.flush()
        self.unwritten.clear()

    def close(self):
        self.file.close()


class Spool:
    """Rows of one kind, in the order in which they were appended."""

    __slots__ = ("store", "dtype", "parts", "waiting", "firsts", "places", "written", "end", "probed")

    def __init__(self, store, dtype):
        self.store, self.dtype, self.parts, self.waiting = store, dtype, [], 0
        self.firsts, self.places, self.written = array("q"), array("q"), 0  # extents: their first rows, where they stand
        self.end = -1  # where the last extent ends
        self.probed = {}

    def __len__(self):
        return self.written + self.waiting

    def append(self, rows):
        """Rows of its kind, which nobody changes any more: they may wait here for a while."""
        if not len(rows):
            return
        if not self.waiting:
            self.store.unwritten.append(self)
        self.parts.append(rows)
        self.waiting += len(rows)
        self.store.waiting += len(rows) * self.dtype.itemsize
        if self.store.waiting > MOST_WAITING:
            self.store.flush()

    def append_columns(self, *columns):
        rows = np.empty(len(columns[0]), self.dtype)
        for name, column in zip(self.dtype.names, columns, strict=True):
            rows[name] = column
        self.append(rows)

    def flush(self):
        if not self.waiting:
            return
        rows = self.parts[0] if len(self.parts) == 1 else np.concatenate(self.parts)
        self.parts.clear()
        place = self.store.write(rows)
        if place != self.end:
            self.firsts.append(self.written)
            self.places.append(place)
        self.end = self.store.end
        self.written, self.waiting = self.written + len(rows), 0
        self.store.waiting -= rows.nbytes

    def read(self, first, end):
        self.flush()
        rows, at = np.empty(max(end - first, 0), self.dtype), first
        extent = bisect_right(self.firsts, first) - 1
        while at < end:
            until = self.firsts[extent + 1] if extent + 1 < len(self.firsts) else self.written
            count = min(until, end) - at
            place = self.places[extent] + (at - self.firsts[extent]) * self.dtype.itemsize
            self.store.read_into(rows[at - first:at - first + count], place)
            at, extent = at + count, extent + 1
        return rows

    def chunks(self, size=CHUNK, first=0, end=None):
        end = len(self) if end is None else end
        for begin in range(first, end, size):
            yield self.read(begin, min(begin + size, end))

    def take(self, indices):
        """The rows of any indices; those that lie near each other cost one reading."""
        rows = np.empty(len(indices), self.dtype)
        block = np.asarray(indices) // CHUNK
        for number in np.unique(block):
            there = block == number
            low, high = int(indices[there].min()), int(indices[there].max())
            rows[there] = self.read(low, high + 1)[indices[there] - low]
        return rows

    def probe(self, key, row):
        """One value; searches ask for the same ones again and again, and there are few of them."""
        if (key, row) not in self.probed:
            self.probed[key, row] = self.read(row, row + 1)[key][0]
        return self.probed[key, row]

    def search(self, key, value, side="left"):
        """As np.searchsorted in the rising column `key`."""
        low, high = 0, len(self)
        while high - low > AT_ONCE:
            middle = (low + high) // 2
            found = self.probe(key, middle)
            if found < value or side == "right" and found == value:
                low = middle + 1
            else:
                high = middle
        return low + int(np.searchsorted(self.read(low, high)[key], value, side))


def around(spool, key, wanted):
    """(slice of the rising `wanted`, rows of the spool from the one before them to the one behind them, place of the first)."""
    todo = [(0, len(wanted))] if len(wanted) else []
    while todo:
        a, b = todo.pop()
        first = max(spool.search(key, wanted[a:b].min()) - 1, 0)
        end = min(spool.search(key, wanted[a:b].max(), "right") + 1, len(spool))
        if end - first <= MOST_AROUND:
            yield slice(a, b), spool.read(first, end), first
        elif b - a == 1:
            yield slice(a, b), spool.read(first, min(first + 3, len(spool))), first
        else:
            todo += [((a + b) // 2, b), (a, (a + b) // 2)]


def interpolate(spool, x, y, wanted):
    """np.interp at rising places."""
    out = np.empty(len(wanted))
    for part, rows, _ in around(spool, x, wanted):
        out[part] = np.interp(wanted[part], rows[x], rows[y])
    return out
