"""talus-fleet: the command line."""

import json
import os
import sys
from pathlib import Path

from talus import command_line, constants, outputs
from talus.progress import Progress
from talus.refused import Refused

NAME = "talus-fleet"
USAGE = """\
usage: talus-fleet run FLEET.csv --out DIR [OPTION...]
       talus-fleet report DIR

    talus-fleet run fleet.csv --out fleet                  # a diagnosis of each recording, on all processors
    talus-fleet report fleet                               # fleet/report.html, report.json, report.parquet

diagnoses each recording of a table as talus-gap does, and says what the diagnoses have in common: effects that all robots
share or that are one robot's own, drift over date and temperature, robots that stand out, what changed since the session before

  -o, --out DIR            where results stand; what is there already is not made again
      --by-session         one diagnosis of all recordings of a robot and session
  -j, --jobs N             processes on this machine (default: its processors; 1 does without Dask)
      --scheduler ADDRESS  the Dask cluster at this address, tcp://HOST:PORT
      --shard I/N          only every N-th item, from the I-th on: for an array of jobs
      --lowpass HZ         as talus-gap's
      --quick              as talus-gap's: no replicates
      --seed N             as talus-gap's (default 1)
  -q, --quiet              say nothing but failures
  -h, --help               print this text
      --version            print the version

FLEET.csv has the columns recording, model, robot, session (a date) and perhaps temperature_C.
"""
LONG = ["out=", "by-session", "jobs=", "scheduler=", "shard=", "lowpass=", "quick", "seed=", "quiet", "help", "version"]
SHORT = {"-o": "--out", "-j": "--jobs", "-q": "--quiet", "-h": "--help"}
OF_GAP = ("--lowpass", "--quick", "--seed")
MOST_JOBS, MOST_SHARDS, MOST_SHOWN = 1024, 1_000_000, 20
FLEET = "fleet.json"


class Options:
    """The command line, parsed."""

    def __init__(self, arguments):
        pairs, self.words = command_line.parsed(NAME, arguments, LONG, SHORT)
        self.flags = dict(pairs)

    def check(self):
        self.quiet = "--quiet" in self.flags
        self.command, *rest = self.words or [""]
        if self.command not in ("run", "report"):
            raise Refused(2, f"expected run or report, found '{self.command}'; {NAME} --help says what there is")
        if len(rest) != 1:
            raise Refused(2, f"{self.command}: expected one {'FLEET.csv' if self.command == 'run' else 'DIR'}; {NAME} --help says what there is")
        self.path = rest[0]
        if self.command == "report" and set(self.flags) - {"--quiet"}:
            raise Refused(2, f"{min(set(self.flags) - {'--quiet'})} is an option of {NAME} run")
        if self.command == "run":
            self._check_run()

    def _check_run(self):
        if not self.flags.get("--out"):
            raise Refused(2, f"--out is missing; {NAME} --help says what there is")
        if "--jobs" in self.flags and "--scheduler" in self.flags:
            raise Refused(2, "--jobs are processes of this machine, --scheduler names others: expected one of them")
        self.jobs = self._number("--jobs", self.flags["--jobs"], MOST_JOBS) if "--jobs" in self.flags else None
        self.shard = self._shard(self.flags.get("--shard", "1/1"))
        self.of_gap = [word for name in OF_GAP if name in self.flags for word in (name, self.flags[name]) if word]
        self._check_gap()

    def _check_gap(self):
        """talus-gap's options are refused by its own words, once and not for each recording."""
        from talus.diagnosis import command

        try:
            command.Options(["--model", "m", "--report", "r", *self.of_gap, "--", "x"]).check()
        except command.Refused as refused:
            raise Refused(2, refused.text) from refused

    @staticmethod
    def _number(name, text, most):
        if not (text.isascii() and text.isdigit() and 1 <= int(text) <= most):
            raise Refused(2, f"{name}: expected a whole number from 1 to {most}, found '{text}'")
        return int(text)

    def _shard(self, text):
        part, slash, count = text.partition("/")
        whole = self._number("--shard", count, MOST_SHARDS) if slash else 0
        if not whole or not (part.isascii() and part.isdigit() and 1 <= int(part) <= whole):
            raise Refused(2, f"--shard: expected I/N with I from 1 to N, found '{text}'")
        return int(part), whole


def say(text):
    print(f"{NAME}: {text}", file=sys.stderr)


# ---- run ---------------------------------------------------------------------------


def run_fleet(options):
    """Diagnoses what is not done yet."""
    from . import pool, table
    from .item import Work

    items = table.read(options.path, "--by-session" in options.flags)
    work = Work(os.path.realpath(options.flags["--out"]), tuple(options.of_gap))
    write_fleet(work, items)
    part, whole = options.shard
    own = items[part - 1 :: whole]
    waiting = sorted((item for item in own if not work.is_done(item)), key=size, reverse=True)  # no process is left with a long one in the end
    jobs = options.jobs or min(pool.processors(), max(1, len(waiting)))
    step, failures = Progress(NAME, len(waiting), options.quiet), []
    if waiting:
        for item, outcome in pool.outcomes(waiting, work, jobs, options.flags.get("--scheduler")):
            status, text = settled(work, item, outcome)
            step(f"{item.robot}, {item.session}")
            if status:
                failures.append((item, text))
    conclude(options, len(own), len(own) - len(waiting), failures)


def size(item):
    """Of its recordings' files [bytes]; of one that is not there nothing."""
    return sum(os.path.getsize(path) for path in item.recordings if os.path.exists(path))


def write_fleet(work, items):
    """FLEET.json: what there is to diagnose, for the report."""
    try:
        os.makedirs(work.out, exist_ok=True)
    except OSError as error:
        raise Refused(1, f"{work.out}: cannot be made: {error.strerror}") from error
    plain = {"schema": "talus-fleet/1", "version": constants.TL_VERSION, "options": list(work.options), "items": [i.plain() for i in items]}
    path, text = Path(work.out) / FLEET, json.dumps(plain, indent=1) + "\n"
    if not path.is_file() or path.read_text(encoding="utf-8") != text:  # the other shards write the same
        outputs.write_text(path, text)


def settled(work, item, outcome):
    """(status, text); where no worker could answer, the failure is written here."""
    if not isinstance(outcome, BaseException):
        return outcome
    text = f"{type(outcome).__name__}: " + " ".join(str(outcome).split())
    work.keep(item, work.made_of(item), 1, text, {})
    return 1, text


def conclude(options, own, before, failures):
    """What was done, and what failed."""
    for item, text in failures[:MOST_SHOWN]:
        say(f"failed: {item.robot}, {item.session}: {text}")
    if len(failures) > MOST_SHOWN:
        say(f"and {len(failures) - MOST_SHOWN} more; {NAME} report lists them")
    if not options.quiet:
        kept = f", {before} of them before" if before else ""
        again = f"; {len(failures)} failed and will be tried again by the next run" if failures else ""
        say(f"{own - len(failures)} of {own} diagnosed{kept}{again}")


# ---- report ------------------------------------------------------------------------


def read_fleet(folder):
    """([Item], Work) of a run's folder."""
    from .item import Work
    from .table import Item

    path = Path(folder) / FLEET
    try:
        plain = json.loads(path.read_text(encoding="utf-8"))
        if plain["schema"] != "talus-fleet/1":
            raise Refused(2, f"{path}: expected schema talus-fleet/1, found '{plain['schema']}'")
        return [Item.of(one) for one in plain["items"]], Work(str(folder), tuple(plain["options"]))
    except OSError as error:
        raise Refused(2, f"{path}: cannot be read: {error.strerror}; {NAME} run makes it") from error
    except (ValueError, KeyError, TypeError) as error:
        raise Refused(2, f"{path}: is not what {NAME} run writes: {error}") from error


def report(options):
    """Reduces what is done."""
    from . import page, parquet, reduce

    items, work = read_fleet(options.path)
    kept = [(item, work.kept(item)) for item in items]
    found = reduce.fleet(kept)
    folder = Path(options.path)
    table = parquet.table(kept)
    outputs.write_text(folder / "report.json", json.dumps(found, indent=1, allow_nan=False) + "\n")
    outputs.write(folder / "report.parquet", [table])
    outputs.write_text(folder / "report.html", page.text(found))
    if not options.quiet:
        print(found["sentence"], file=sys.stderr)


def run(arguments):
    """The program; raises Refused."""
    options = Options(arguments)
    if command_line.answered(options.flags, NAME, USAGE):
        return
    options.check()
    {"run": run_fleet, "report": report}[options.command](options)


def main(arguments):
    """Exit status of the program."""
    return command_line.status(NAME, run, arguments)
