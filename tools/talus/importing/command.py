"""talus-import: the command line."""

import os
import sys
from pathlib import Path

import talus
from talus import command_line, outputs
from talus.refused import Refused

from . import assemble, formats, mapping, suggest

NAME = "talus-import"
USAGE = """\
usage: talus-import --out REC.csv [OPTION...] IN...

    talus-import --suggest log.csv > map.yaml              # drafts the map, says what it is unsure of
    talus-import --map map.yaml --out rec.csv log.csv
    talus-import --map 'joint_rad=Winkel [°]:deg' --map time_s=Zeit:ms --map joint_current_A=Strom:A --out rec.csv log.csv

makes a recording from text tables of any separator, decimal sign and encoding, MATLAB, HDF5, Parquet, rosbag2,
MCAP or ASAM MDF files

  -o, --out REC.csv[.gz]  the recording to write
  -m, --map MAP           MAP.yaml, or COLUMN=SOURCE:UNIT (repeatable; -SOURCE turns the sign)
  -s, --suggest           draft the map: printed without --out, used with it; what it is unsure of is said
  -p, --plant NAME        leg, pendulum or slider (else by the columns' names)
  -q, --quiet             say nothing but what is unsure
  -h, --help              print this text
      --version           print the version

Without --map and --suggest the headers alone must say it: where anything is unsure, nothing is written.
"""
LONG = ["out=", "map=", "suggest", "plant=", "quiet", "help", "version"]
SHORT = {"-o": "--out", "-m": "--map", "-s": "--suggest", "-p": "--plant", "-q": "--quiet", "-h": "--help"}


class Options:
    """The command line, parsed."""

    def __init__(self, arguments):
        pairs, self.inputs = command_line.parsed(NAME, arguments, LONG, SHORT)
        self.maps = [value for name, value in pairs if name == "--map"]
        self.flags = dict(pairs)
        self.out, self.plant = self.flags.get("--out"), self.flags.get("--plant")
        self.suggest = "--suggest" in self.flags

    def check(self):
        if not self.inputs:
            raise Refused(2, f"no file to import; {NAME} --help says what there is")
        if not self.out and not self.suggest:
            raise Refused(2, f"--out is missing; {NAME} --help says what there is")
        if self.suggest and self.maps:
            raise Refused(2, "--suggest drafts a map and --map gives one: expected one of them")
        if self.plant is not None and self.plant not in talus.plants():
            raise Refused(2, f"--plant: expected {', '.join(talus.plants())}, found '{self.plant}'")
        if self.out and os.path.realpath(self.out) in {os.path.realpath(p) for p in (*self.inputs, *self.maps)}:
            raise Refused(2, f"{self.out}: is an input and an output")


def say(text):
    print(f"{NAME}: {text}", file=sys.stderr)


def given_map(options):
    """The map of --map: a file's, and single columns that go before it."""
    files = [text for text in options.maps if "=" not in text or Path(text).is_file()]
    if len(files) > 1:
        raise Refused(2, "--map: expected one MAP.yaml")
    mapped = mapping.read(files[0]) if files else mapping.Map()
    for text in options.maps:
        if text not in files:
            mapping.add(mapped, text)
    mapped.plant = options.plant or mapped.plant or plant_of(mapped.columns)
    if mapped.plant not in talus.plants():
        raise Refused(2, f"plant: expected {', '.join(talus.plants())}, found '{mapped.plant}'")
    return mapped


def plant_of(columns):
    known = {plant: talus.channel_set(talus.Model(plant)).known for plant in talus.plants()}
    return max(known, key=lambda plant: sum(known[plant] >> talus.channels()[name] & 1 for name in columns))


def drafted(options, tables):
    """A Suggestion; without --suggest nothing may be unsure."""
    found = suggest.Suggestion(tables, options.plant)
    if found.doubts and not options.suggest:
        more = f" (and {len(found.doubts) - 1} more)" if len(found.doubts) > 1 else ""
        raise Refused(2, f"unsure: {found.doubts[0]}{more}; --suggest takes it so, --map says otherwise")
    return found


def run(arguments):
    """The program; raises Refused."""
    options = Options(arguments)
    if command_line.answered(options.flags, NAME, USAGE):
        return
    options.check()
    tables = [table for path in options.inputs for table in formats.read(path)]
    doubts, times = [], {}
    if options.maps:
        mapped = given_map(options)
    else:
        found = drafted(options, tables)
        mapped, doubts, times = found.map, found.doubts, found.times
    if not options.out:
        print(mapped.text(doubts), end="")
        tell(options, doubts, tables, [])
        return
    notes = []
    recording = assemble.recording(tables, mapped, times, notes)
    outputs.write(options.out, recording.text())
    tell(options, doubts, tables, notes)
    if "--quiet" not in options.flags:
        say(f"{options.out}: {len(recording.t)} samples in {recording.t[-1] - recording.t[0]:.3f} s, a {mapped.plant}'s: "
            f"{', '.join(recording.columns)}")  # fmt: skip


def tell(options, doubts, tables, notes):
    for doubt in doubts:
        say(f"unsure: {doubt}")
    if "--quiet" not in options.flags:
        for note in [f"{table.path}: {note}" for table in tables for note in table.notes] + notes:
            say(f"note: {note}")


def main(arguments):
    """Exit status of the program."""
    return command_line.status(NAME, run, arguments)
