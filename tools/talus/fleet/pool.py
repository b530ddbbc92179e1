"""Items to processes: one after the other, or on Dask's distributed, by itself on this machine or on a cluster that is there."""

import logging
import os
import signal
from contextlib import contextmanager
from itertools import islice

from talus import constants
from talus.refused import Refused

AHEAD = 3  # items under way for each worker's thread: none waits for the next, and the scheduler's memory stays the same
CONNECT_S = 30
NAME = "diagnosis"


def processors():
    """That this process may use."""
    return len(os.sched_getaffinity(0))


def outcomes(items, work, jobs=1, scheduler=None):
    """Yields (item, (status, text) or an exception) as items end; one that is killed with its process is tried again elsewhere."""
    if scheduler is None and jobs == 1:
        for item in items:
            yield item, work(item)
        return
    with connected(jobs, scheduler) as client:
        try:
            yield from spread(client, items, work)
        except OSError as error:  # Dask's own are OSError, too
            raise Refused(1, f"the cluster has gone: {error}; what is done stays, and the same command goes on") from error


def spread(client, items, work):
    """The same on a client's workers. Items are handed over as others end: what the scheduler holds does not grow with them."""
    from distributed import as_completed

    waiting, under_way, pool = iter(items), {}, as_completed()

    def hand_over():
        room = AHEAD * max(1, sum(client.nthreads().values())) - len(under_way)
        for item in islice(waiting, max(0, room)):
            future = client.submit(work, item, key=f"{NAME}-{item.name}", pure=False)
            under_way[future.key] = item
            pool.add(future)

    hand_over()
    for future in pool:
        if future.cancelled():
            raise OSError("its work was cancelled")
        item, error = under_way.pop(future.key), future.exception()
        outcome = future.result() if error is None else error
        future.release()
        hand_over()
        yield item, outcome


@contextmanager
def connected(jobs, scheduler):
    """A client of the cluster at an address, or of `jobs` processes on this machine, each of one thread and watched by a nanny."""
    distributed = _library()
    for handler in logging.getLogger("distributed").handlers:
        handler.setLevel(logging.CRITICAL)  # what ends the work is said in one line, by Refused
    if scheduler is None:
        local = {"n_workers": jobs, "threads_per_worker": 1, "processes": True, "dashboard_address": "127.0.0.1:0",
                 "silence_logs": logging.CRITICAL, "preload": [__name__]}  # fmt: skip
        with _unwatched(), distributed.LocalCluster(**local) as cluster, distributed.Client(cluster) as client:
            yield client
        return
    try:
        client = distributed.Client(scheduler, timeout=CONNECT_S)
    except (OSError, ValueError) as error:
        raise Refused(1, f"--scheduler {scheduler}: cannot be reached: {error}") from error
    with client:
        _check_workers(client, scheduler)
        yield client


# Dask looks at each worker's stack every 10 ms, at its loop's every 20 and at its memory every 100, for a dashboard that nobody has
# open: on two processors that takes a twentieth of them from the items.
SELDOM = {"distributed.worker.profile.enabled": False, "distributed.admin.tick.interval": "1s", "distributed.admin.system-monitor.interval": "10s",
          "distributed.worker.memory.monitor-interval": "1s"}  # fmt: skip


def _unwatched():
    import dask

    return dask.config.set(SELDOM)


def _check_workers(client, scheduler):
    """Each worker that is there has this version of talus: others would give other bytes."""
    try:
        versions = client.run(version)
    except Exception as error:  # whatever stands in the way of an import over there
        raise Refused(1, f"--scheduler {scheduler}: talus cannot be imported there: {error}") from error
    for worker, found in versions.items():
        if found != constants.TL_VERSION:
            raise Refused(1, f"--scheduler {scheduler}: {worker} has talus {found}, expected {constants.TL_VERSION}")


def dask_setup(_worker):
    """Dask calls this in each local worker. Ctrl-C reaches all processes of a terminal; the first of them ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def version():
    """Of talus where this runs."""
    return constants.TL_VERSION


def _library():
    try:
        import distributed
    except ImportError as error:
        raise Refused(1, "needs Dask's distributed: pip install 'talus[fleet]', or --jobs 1 does without it") from error
    return distributed
