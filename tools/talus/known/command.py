"""The command line."""

import argparse
import json
import os
import sys
from pathlib import Path

from ..blind.unseal import words
from . import across, across_outputs, camera, fleet, gate_outputs, gates, nulls, outputs, running, spikes


def read_only(text):
    """`plant=leg,slider rate_Hz=100` as {axis: values}."""
    only = {}
    for part in text.split():
        axis, _, words = part.partition("=")
        if axis not in nulls.AXES:
            raise argparse.ArgumentTypeError(f"expected AXIS=VALUE with an axis of {', '.join(nulls.AXES)}, found '{part}'")
        known = {str(value): value for value in nulls.AXES[axis]} | ({"exact": 0} if axis == "bits" else {})
        unknown = [word for word in words.split(",") if word not in known]
        if unknown:
            raise argparse.ArgumentTypeError(f"{axis}: expected some of {', '.join(known)}, found '{unknown[0]}'")
        only[axis] = {known[word] for word in words.split(",")}
    return only


def number(text):
    """A whole number of at least 1."""
    if not (text.isascii() and text.isdigit() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"expected a whole number above 0, found '{text}'")
    return int(text)


def run_nulls(options):
    cases = nulls.draw(options.seed, options.count, options.only)
    results = running.run("nulls", cases, Path(options.out) / f"seed{options.seed}", nulls.diagnose, options.jobs, options.keep)
    outputs.nulls(results, Path(options.out))
    return 0


def run_spikes(options):
    cases = spikes.draw(options.data, options.seed, options.count)
    results = running.run("spike", cases, Path(options.out) / f"seed{options.seed}", spikes.diagnose, options.jobs, options.keep)
    outputs.spikes(results, Path(options.out))
    return 0


def run_across(options):
    results = running.run("across", across.draw(options.data), Path(options.out) / "recordings", across.diagnose, options.jobs, options.keep)
    across_outputs.across(results, Path(options.out))
    return 0


def run_camera(options):
    cases = camera.draw(options.seed, options.count)
    results = running.run("camera", cases, Path(options.out) / f"seed{options.seed}", camera.diagnose, options.jobs, options.keep)
    outputs.camera(results, Path(options.out))
    return 0


def run_gate(options):
    cases = gates.draw(options.data, options.seed, options.count)
    results = running.run("gate", cases, Path(options.out) / f"seed{options.seed}", gates.examine, options.jobs, options.keep)
    gate_outputs.gate(results, Path(options.out))
    return 0


def run_fleet(options):
    found = fleet.measure(Path(options.out), options.count, options.seed, options.jobs)
    held = fleet.bars(found)
    running.write(Path(options.out) / "fleet.json", json.dumps({**found, "bars": [bar.row() for bar in (*held, fleet.speed(found))]}, indent=1) + "\n")
    print(words([*held, fleet.speed(found)]), found["found"]["sentence"], f"written: {options.out}/fleet.json", sep="\n")
    return 1 if any(bar.met is False for bar in held) else 0


def parser():
    top = argparse.ArgumentParser(prog="known", description="talus-gap where it is known what there is to find")
    commands = top.add_subparsers(dest="command", required=True)
    one = commands.add_parser("nulls", help="simulated benches without any effect")
    one.add_argument("--only", type=read_only, default={}, help="of the grid: 'plant=leg,slider rate_Hz=100'")
    one.set_defaults(run=run_nulls)
    other = commands.add_parser("spike", help="effects added to recordings of real machines")
    other.set_defaults(run=run_spikes)
    third = commands.add_parser("camera", help="benches with one effect, with and without a camera's angles")
    third.set_defaults(run=run_camera)
    fourth = commands.add_parser("fleet", help="a fleet of arms through talus-fleet, on processes of which two are killed and one by one")
    fourth.set_defaults(run=run_fleet)
    fifth = commands.add_parser("gate", help="recordings with a fault, and sound ones, before the gate")
    fifth.set_defaults(run=run_gate)
    sixth = commands.add_parser("across", help="effects found on one recording of a real machine, on its other recordings")
    sixth.set_defaults(run=run_across)
    for command in (other, fifth, sixth):
        command.add_argument("--data", default=os.environ.get("TALUS_DATA") or running.ROOT.parent / "shared" / "data",
                             help="folder of the recordings (TALUS_DATA)")  # fmt: skip
    for command in (one, other, third, fourth, fifth):
        command.add_argument("--seed", type=int, default=1)
        command.add_argument("--count", type=number, default=60)
    for command in (one, other, third, fourth, fifth, sixth):
        command.add_argument("--out", required=True, help="folder of reports, kept there, and of the outcome")
        command.add_argument("--jobs", type=number, default=1, help="cases at a time")
        command.add_argument("--keep", action="store_true", help="keep reports of another version of the diagnosis")
    return top


def main(arguments):
    options = parser().parse_args(arguments)
    try:
        return options.run(options)
    except (RuntimeError, OSError) as error:
        print(f"known: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
