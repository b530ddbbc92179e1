"""The processors that a diagnosis works on."""

import multiprocessing
from concurrent.futures import ThreadPoolExecutor

COUNT = 2


def are_free():
    """Are there others beside this one? Not where this process is itself one of several."""
    return COUNT > 1 and multiprocessing.parent_process() is None


def each(work, items):
    """work(item) of each, begun in this order, by this thread and as many as there are free processors: the library computes beside the
    interpreter."""
    items = list(items)
    out, waiting = [None] * len(items), iter(range(len(items)))

    def take():
        for place in waiting:
            out[place] = work(items[place])

    if not are_free() or len(items) < 2:
        take()
        return out
    with ThreadPoolExecutor(COUNT - 1) as pool:
        helpers = [pool.submit(take) for _ in range(COUNT - 1)]
        take()
        for one in helpers:
            one.result()  # raises what it raised
    return out
