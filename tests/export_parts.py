"""Parts of the export on columns that fit into memory.

    sequence = follow(counter, bits, time_ns, period_s)     # what a counter says of its frames
    time_ns, zero_ns = tick_times(tick, stamp_ns, period_s)
"""

from dataclasses import dataclass

import numpy as np
from talus.acquire_export.clock import tick_line
from talus.acquire_export.faults import Faults
from talus.acquire_export.sequence import SURE, Follower, Outputs
from talus.acquire_export.spool import Store


@dataclass
class Sequence:
    number: np.ndarray  # of the frames that are used, rising
    kept: np.ndarray  # their places
    trusted: np.ndarray  # of all frames
    faults: list


def follow(counter, bits, time_ns, period_s=0.0, same=lambda a, b: True, chunk=1000):
    kept, trusted, faults = [], [], Faults()

    def find(number):
        return next((int(k[n == number][0]) for n, k in kept if (n == number).any()), None)

    follower = Follower(bits, period_s, same, Outputs(lambda n, k: kept.append((n, k.copy())), trusted.append, find, lambda index: None, faults))
    counter, time_ns = np.asarray(counter), np.asarray(time_ns)
    for first in range(0, len(counter), chunk):
        end, low = min(first + chunk, len(counter)), max(first - 1, 0)
        follower.feed(first, end, counter[low:end + SURE], time_ns[low:end + SURE], low)
    follower.close()
    number, places = (np.concatenate(columns) for columns in zip(*kept, strict=True))
    listed = sorted(faults, key=lambda fault: (fault.index, fault.number))
    return Sequence(number, places, np.concatenate(trusted), listed)


def tick_times(tick, stamp_ns, period_s):
    """Instants [ns, float from the first stamp on] for each of the rising ticks, and that first stamp."""
    store = Store(None)
    points = store.spool([("number", "i8"), ("stamp_ns", "i8")])
    points.append_columns(tick, stamp_ns)
    line = tick_line(points, period_s, int(stamp_ns.min()), store)
    rows = line.read(0, len(line))
    store.close()
    assert (rows["number"] == tick).all()
    return rows["time_ns"], int(stamp_ns.min())
