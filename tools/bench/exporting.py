"""Exporting a record of the bus: talus-acquire-export against python-can and cantools, which read and decode the same frames one by one."""

import contextlib
import io
import sys
import time

from measure import Comparison, Outcome

TURNS = 30  # of ten seconds and a megabyte each
PEER_TURNS = 1  # the peer's time grows with the frames, and is long


def ours(size, log):
    """Processor time: counters followed, losses named, everything on one time base, written as a recording."""
    from bus_record import DBC, MODEL
    from talus.acquire_export import command

    out = size.folder / "exporting.csv"
    arguments = ["--dbc", DBC, "--model", MODEL, "--quiet", "--out", out, log]
    begin = time.process_time()
    with contextlib.redirect_stderr(io.StringIO()):
        status = command.main([str(argument) for argument in arguments])
    seconds = time.process_time() - begin
    out.unlink()
    assert status in (0, 1)  # the record lacks some frames, and that is said
    return seconds


def peer(log):
    """Processor time, and the frames: only read and decoded."""
    import can
    from bus_record import DATABASE

    begin, frames = time.process_time(), 0
    for message in can.CanutilsLogReader(str(log)):
        DATABASE.decode_message(message.arbitration_id, message.data)
        frames += 1
    return time.process_time() - begin, frames


def bench(size):
    """Both on a record of the leg's bus; seconds for the same megabytes."""
    sys.path.append(str(size.repository / "tests"))  # where records of the leg's bus are made
    from bus_record import frames_of, twin, write_long

    long, short = size.folder / "exporting.log", size.folder / "exporting_short.log"
    turns = size.scaled(TURNS, PEER_TURNS)
    try:
        frames = frames_of(twin(size.folder, duration=10))
        write_long(long, frames, turns)
        write_long(short, frames, PEER_TURNS)
        pairs = [(ours(size, long), peer(short)) for _ in range(size.scaled(3, 1) + 1)][1:]
        megabytes, share = long.stat().st_size / 1e6, turns / PEER_TURNS
    finally:
        for path in (long, short, size.folder / "twin.csv"):
            path.unlink(missing_ok=True)
    seconds = [o for o, _ in pairs]
    gigabyte_s = min(seconds) * 1000 / megabytes
    return Outcome(
        [Comparison("exporting a record of the bus", f"{megabytes:.3g} MB, frames followed and put on one time base", "python-can and cantools, decoding alone",
                    seconds, [p * share for _, (p, _) in pairs], 1.0)],
        [f"{gigabyte_s:.0f} s of processor time for a gigabyte, at this speed; {pairs[0][1][1]:,} frames decoded by the peer"],
        {"gigabyte_s": gigabyte_s},
    )  # fmt: skip
