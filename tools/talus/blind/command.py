"""The command line."""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from . import cases


def read_mix(text):
    """`single:0.5,none:0.5` as a mapping."""
    mix = {}
    for part in text.split(","):
        kind, _, share = part.partition(":")
        if kind not in cases.MIX or not share:
            raise argparse.ArgumentTypeError(
                f"expected kind:share with a kind of {', '.join(cases.MIX)}, found '{part}'"
            )
        mix[kind] = float(share)
    if not sum(mix.values()) > 0:
        raise argparse.ArgumentTypeError("the shares sum to nothing")
    return mix


def draw(options):
    folder = Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        print(f"blind: {folder}: not empty; cases are drawn into a new folder", file=sys.stderr)
        return 2
    protocol = "wide" if options.wide else "narrow"
    one = partial(cases.make, options.seed, mix=options.mix, folder=folder, protocol=protocol)
    if options.jobs > 1:
        with ProcessPoolExecutor(options.jobs) as pool:
            answers = list(pool.map(one, range(options.count)))
    else:
        answers = [one(k) for k in range(options.count)]
    checksum = cases.seal(folder, options.seed, options.mix, answers, protocol)
    (folder / "seal.sha256").write_text(f"{checksum}  sealed/labels.json\n")
    print(f"{options.count} cases of seed {options.seed} in {folder}; labels sealed, SHA-256 {checksum}")
    return 0


def run(options):
    from . import running

    missing = [folder for folder in options.folder if not (Path(folder) / "seal.sha256").exists()]
    if missing:
        print(f"blind: {missing[0]}: no cases here; `blind draw` makes them", file=sys.stderr)
        return 2
    for folder in options.folder:
        print(f"{folder}: labels sealed, SHA-256 {(Path(folder) / 'seal.sha256').read_text().split()[0]}", flush=True)
    for folder in options.folder:
        running.run(Path(folder), options.jobs, options.keep, options.gap)
    return 0


def follow(options):
    from . import following

    try:
        for folder in options.folder:
            following.run(Path(folder), options.gap)
    except ValueError as error:
        print(f"blind: {error}", file=sys.stderr)
        return 2
    return 0


def open_seal(options):
    from . import unseal

    try:
        unseal.open_seal(options.folder, Path(options.out or options.folder[0]))
    except (unseal.Sealed, FileNotFoundError) as error:
        print(f"blind: {error}", file=sys.stderr)
        return 1
    return 0


def parser():
    top = argparse.ArgumentParser(prog="blind", description="talus-gap on withheld effects")
    commands = top.add_subparsers(dest="command", required=True)
    make = commands.add_parser("draw", help="draw cases by seed and seal their labels")
    make.add_argument("--seed", type=int, required=True)
    make.add_argument("--count", type=int, required=True)
    make.add_argument("--out", required=True)
    make.add_argument("--wide", action="store_true", help="another plant, rate, noise and motion in every case")
    make.add_argument("--mix", type=read_mix, default=dict(cases.MIX))
    make.add_argument("--jobs", type=int, default=1)
    make.set_defaults(run=draw)
    diagnose = commands.add_parser("run", help="diagnose every case with talus-gap; resumes where it was")
    diagnose.add_argument("folder", nargs="+")
    diagnose.add_argument("--jobs", type=int, default=1, help="cases at a time")
    diagnose.add_argument("--keep", action="store_true", help="keep verdicts of another version of the diagnosis")
    diagnose.add_argument("--gap", help="the command to judge (build/bin/talus-gap)")
    diagnose.set_defaults(run=run)
    after = commands.add_parser("next", help="make the proposed experiments on the twin and diagnose again")
    after.add_argument("folder", nargs="+")
    after.add_argument("--gap", help="the command to judge (build/bin/talus-gap)")
    after.set_defaults(run=follow)
    unseal = commands.add_parser("open", help="open the seal and compare")
    unseal.add_argument("folder", nargs="+")
    unseal.add_argument("--out", help="where blind.json and blind.html go (the first folder)")
    unseal.set_defaults(run=open_seal)
    return top


def main(arguments):
    options = parser().parse_args(arguments)
    return options.run(options)
