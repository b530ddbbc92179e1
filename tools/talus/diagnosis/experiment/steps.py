"""The next experiment as a list of steps, each with the command to run."""

import math
import shlex
from pathlib import Path

DBC = "models/leg.dbc"
RECORD, RECORDING = "new", "new.csv"
ROOM = 1.05  # of the trajectory's positions and speeds, as limits while it is played


def steps(options, found):
    """[(what to do, command or None)] of a diagnosis; empty where nothing is to be recorded."""
    verdict = found.report["verdict"]
    if verdict["effect"] == "none" or verdict.get("withheld"):
        return []
    return [*_recorded(options, found.trajectory, len(found.report["gap"])), _diagnosed(options)]


def _recorded(options, trajectory, joints):
    """How the recording is made; `trajectory` is its file's text, or None."""
    if not trajectory:
        return [(f"Make the recording that is described above: {RECORDING}", None)]
    if joints < 2:
        return [(f"Have the joint follow {Path(options.trajectory).name} and record it: {RECORDING}", None)]
    model = shlex.quote(options.flags["--model"])
    return [
        ("Bring the leg to where the trajectory begins, and play it",
         f"talus-acquire --out {RECORD} --play {shlex.quote(options.trajectory)} --limits {','.join(limits(trajectory))} can0"),
        ("Make a recording of it", f"talus-acquire-export {RECORD}.log --dbc {DBC} --model {model} --out {RECORDING}"),
    ]  # fmt: skip


def _diagnosed(options):
    flags = [x for name in ("--model", "--report", "--html") if name in options.flags for x in (name, options.flags[name])]
    return "Diagnose all recordings together", shlex.join(["talus-gap", *flags, *options.recordings, RECORDING])


def limits(text):
    """--limits of talus-acquire that a trajectory's file keeps within: joint.position=low:high, joint.speed=most."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    columns = list(zip(*(map(float, line.split(",")) for line in lines[1:])))
    t = columns[0]
    for name, q in zip(lines[0].split(",")[1:], columns[1:]):
        joint, low, high = name.rsplit("_", 1)[0], min(q), max(q)
        room = (ROOM - 1.0) * (high - low)
        speed = max(abs(b - a) / (after - before) for a, b, before, after in zip(q, q[1:], t, t[1:]))
        yield f"{joint}.position={math.floor(100 * (low - room)) / 100:g}:{math.ceil(100 * (high + room)) / 100:g}"
        yield f"{joint}.speed={math.ceil(100 * ROOM * speed) / 100:g}"
