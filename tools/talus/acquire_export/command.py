"""talus-acquire-export: the command line, and the way from a record to a recording."""

import contextlib
import ctypes
import json
import math
import os
import sys
from contextlib import closing
from itertools import chain

import numpy as np
import talus
from talus import command_line, outputs
from talus.refused import Refused

from . import decimals, events, record, report, streams, table, ticks
from .bench_model import BenchModel
from .layout import Database
from .spool import Store

NAME = "talus-acquire-export"
USAGE = """\
usage: talus-acquire-export --dbc D.dbc --model M.yaml --out REC.csv [OPTION...] RECORD.log

    talus-acquire-export --dbc models/leg.dbc --model models/leg_bench.yaml --out walk.csv walk.log

turns a record of the bus into a recording, and says which frames were lost, repeated, out of order or late

  -d, --dbc D.dbc                  what the frames hold
  -m, --model M.yaml               plant, transmissions, and how the drives count (bus:)
  -o, --out REC.csv[.gz]           the recording to write
      --report R.json              every fault with its place, for machines
      --rate HZ                    an even grid of so many samples a second (the bench's own ticks)
      --interface NAME             only the frames of this interface
      --channel COLUMN=MSG.SIGNAL  a column's signal, where the DBC does not say it (repeatable)
      --side RECORD.jsonl          clocks and drops (beside the record, where it is)
  -q, --quiet                      say nothing but what was lost
  -h, --help                       print this text
      --version                    print the version

Exit status 1: something was lost; the recording is written all the same.
"""
LONG = ["dbc=", "model=", "out=", "report=", "rate=", "interface=", "channel=", "side=", "quiet", "help", "version"]
SHORT = {"-d": "--dbc", "-m": "--model", "-o": "--out", "-q": "--quiet", "-h": "--help"}
SCHEMA = "talus-export/1"
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # malloc.h
LEAST_ROWS = 100  # of a recording
MOST_UNCERTAIN_NS = 100_000  # of instants, by the readings of the clocks, that is not worth a word
ROWS_AT_ONCE = 5_000  # that are turned into text


# ---- the command line ----------------------------------------------------------------


class Options:
    def __init__(self, arguments):
        pairs, self.records = command_line.parsed(NAME, arguments, LONG, SHORT)
        self.given, self.mapping = {name.removeprefix("--"): value for name, value in pairs}, {}
        for name, value in pairs:
            if name == "--channel":
                self.add_channel(value)

    def add_channel(self, text):
        column, equals, signal = text.partition("=")
        message, dot, name = signal.partition(".")
        if not (column and equals and message and dot and name):
            raise Refused(2, f"--channel: expected COLUMN=MESSAGE.SIGNAL, found '{text[:60]}'")
        if column.rsplit("_", 1)[-1] not in table.UNITS:
            raise Refused(2, f"--channel: '{column[:40]}' is no column of a recording")
        self.mapping[column] = (message, name)

    def check(self):
        for name in ("dbc", "model", "out"):
            if not self.given.get(name):
                raise Refused(2, f"--{name} is missing; {NAME} --help says what there is")
        if len(self.records) != 1:
            raise Refused(2, f"expected one record, found {len(self.records)}; {NAME} --help says what there is")
        self.record = self.records[0]
        self.side = self.given.get("side", events.beside(self.record))
        if "side" in self.given and not os.path.exists(self.side):
            raise Refused(2, f"--side: there is no {self.side}")
        self.rate = self.number("rate") if "rate" in self.given else None
        files = [self.given[name] for name in ("out", "report") if name in self.given]
        inputs = {os.path.realpath(path) for path in (self.record, self.given["dbc"], self.given["model"], self.side)}
        if len({os.path.realpath(path) for path in files}) < len(files):
            raise Refused(2, "--out and --report are one file")
        for path in files:
            if os.path.realpath(path) in inputs:
                raise Refused(2, f"{path}: is an input and an output")

    def number(self, name):
        try:
            value = float(self.given[name])
        except ValueError:
            value = math.nan
        if not 0.01 <= value <= 1e6:
            raise Refused(2, f"--{name}: expected a number from 0.01 to 1e6, found '{self.given[name]}'")
        return value


# ---- what was found --------------------------------------------------------------------


class Findings:
    """Words for people and entries for the report, collected on the way."""

    def __init__(self):
        self.lost, self.notes, self.messages, self.not_listed = [], [], [], 0

    def take_stream(self, stream, zero_ns):
        self.messages.append(report.stream_entry(stream))
        self.lost += report.words_of(stream, report.LOST, zero_ns)
        if stream.outside:
            self.lost.append(f"{stream.name}: {stream.outside} frames left out: their stretches between new beginnings are short, or fit to no other's")
        self.notes += report.words_of(stream, [kind for kind in report.WORDS if kind not in report.LOST], zero_ns)
        self.not_listed += stream.faults.not_listed

    def take_record(self, rec, unknown):
        if rec.cut:
            self.notes.append(f"line {rec.cut} is cut off and was left out; the record ends there")
        for line, frames in rec.dropped:
            self.lost.append(f"line {line}: candump dropped {frames} frames")
        if rec.drops > len(rec.dropped):
            self.lost.append(f"candump dropped frames at {rec.drops - len(rec.dropped)} more lines")
        if rec.errors:
            self.notes.append(f"{rec.errors} error frames")
        if rec.remote:
            self.notes.append(f"{rec.remote} remote frames, which hold nothing")
        if unknown:
            shown = ", ".join(f"{report.identifier_text(i)} on {source} ({frames} frames, the first in line {line})"
                              for i, source, frames, line in unknown[:5])  # fmt: skip
            more = f" and {len(unknown) - 5} more" if len(unknown) > 5 else ""
            self.notes.append(f"not in the DBC: {shown}{more}")

    def take_side(self, beside, interface):
        if beside is None:
            return
        for drop in beside.drops:
            if interface in (None, drop["source"]):
                self.lost.append(f"{drop['source']}: {drop['lost']} frames lost at the {drop['where']}, "
                                 f"behind its frame {drop['after']}")  # fmt: skip
        if beside.more:
            self.lost.append(f"{beside.more} more losses and changes of bus and interface")
        if beside.perhaps_lost:
            self.lost.append(f"perhaps {beside.perhaps_lost} more frames lost, where an interface vanished")
        if beside.not_known:
            self.lost.append(f"an interface vanished {beside.not_known} times: how many frames were on their way is not known")
        if beside.edges_lost:
            self.lost.append(f"{beside.edges_lost} edges of GPIO lines lost")
        for state in beside.states:
            if state["state"] in ("off", "down", "gone", "renamed", "replaced"):
                self.notes.append(f"{state['source']}: {state['type']} {state['state']} behind its frame {state['after']}")
        if beside.end is None:
            self.notes.append(f"{beside.path} has no end: the recorder was killed")

    def take_joints(self, made):
        """Where the sender began anew; entries for the report: `sample` is the first one behind it."""
        entries = [{"time_s": [(at_ns - made.first_ns) / 1e9 for at_ns in joint], "sample": made.rows.search("time_ns", joint[1])}
                   for joint in made.joints]  # fmt: skip
        entries = [entry for entry in entries if 0 < entry["sample"] < len(made)]
        for entry in entries[:5]:
            before, behind = entry["time_s"]
            self.notes.append(f"the sender began anew, or stood still, between {before:.3f} s and {behind:.3f} s: the recording goes on "
                              f"behind it, with sample {entry['sample']}")  # fmt: skip
        if len(entries) > 5:
            self.notes.append(f"the sender began anew at {len(entries) - 5} more places")
        return entries

    def take_clock(self, beside, origin_ns):
        """Steps of the clock, once stamps have been converted; entries for the report."""
        def seconds(*instants_ns):
            return [(at_ns - origin_ns) / 1e9 for at_ns in instants_ns]

        entries = []
        for step in beside.model.steps if beside else []:
            entry = {"time_s": seconds(step.before.mono_ns, step.after.mono_ns), "size_s": step.size_ns / 1e9, "uncertain_s": step.uncertain_ns / 1e9}
            words = f"the clock was set {('forward', 'back')[step.size_ns < 0]} by {abs(entry['size_s']):.6f} s before {entry['time_s'][1]:.3f} s"
            if step.uncertain_ns:
                first, last = entry["uncertain_time_s"] = seconds(step.uncertain_from_ns, step.uncertain_to_ns)
                words += f"; instants from {first:.3f} s to {last:.3f} s are uncertain by {entry['uncertain_s']:.6f} s"
            self.notes.append(words)
            entries.append(entry)
        if beside and beside.model.uncertain_ns > MOST_UNCERTAIN_NS:
            self.notes.append(f"the clocks were not read quickly between two steps: instants are uncertain by {beside.model.uncertain_ns / 1e9:.6f} s there")
        return entries

    def take_unrelated(self, beside, streams):
        """Interfaces whose stamps stay on the clock that they have, though the record has readings."""
        for source in sorted({stream.source for stream in streams if not stream.clock.is_monotonic}) if beside and beside.clocks else []:
            self.notes.append(f"{source}: nothing relates the adapter's clock to the monotonic one (no pair with realtime, or it was set back)")


def say(text):
    shown = "".join(c if c.isprintable() else "?" for c in text)  # an interface's name may hold any character
    print(f"{NAME}: {shown}", file=sys.stderr)


# ---- the way ----------------------------------------------------------------------------


def column_names(model, columns, absent, findings):
    """(names to write in order, required ones); Refused when a required one is not there."""
    known, required = model.columns()
    known.remove("time_s")
    required.remove("time_s")
    for name in required:
        if name in absent:
            message = absent[name]
            raise Refused(2, f"the record has no whole frame {message.name} ({report.identifier_text(message.key)}), "
                             f"which holds {name}")  # fmt: skip
        if name not in columns:
            raise Refused(2, f"nothing says which signal is {name}: attribute Channel of the DBC, or --channel")
    for name, message in absent.items():
        if name in known:
            findings.notes.append(f"no {name}: the record has no frame {message.name}")
    names = [name for name in known if name in columns]
    if not names:
        raise Refused(2, f"no signal is a column of a {model.plant}'s recording")
    return names, required or names


def with_values(names, required, columns, findings):
    """Those that have values."""
    for name in names:
        if name not in columns and name in required:
            raise Refused(2, f"{name}: none of its frames holds a number up to {table.LARGEST:g}")
        if name not in columns:
            findings.notes.append(f"no {name}: none of its frames holds a number up to {table.LARGEST:g}")
    return [name for name in names if name in columns]


def check_base(names, required):
    """The motor encoder's frames give the time base where there is one."""
    motor = [name for name in required if name.endswith("_motor_rad")]
    return motor + [name for name in required if name not in motor]


def places_of(step):
    return min(max(math.ceil(2 - math.log10(step)), 0), 12) if 0 < step < math.inf else 9


def recording_text(found, columns):
    """The recording's bytes, some thousand rows at a time."""
    places = [7, *(places_of(columns[name].step) for name in found.names)]
    yield (",".join(["time_s", *found.names]) + "\n").encode()
    first_ns = found.first_ns
    for rows in found.rows.chunks(ROWS_AT_ONCE):
        values = np.column_stack([(rows["time_ns"] - first_ns) / 1e9, rows["value"]])
        yield decimals.lines(values, places)


def read_streams(options, findings, store):
    """(streams in order, events, summary of the record's own faults)."""
    database = Database.read(options.given["dbc"])
    beside, rec = events.read(options.side, store), record.Record(options.record)
    sorter = streams.Sorter(database, store, options.given.get("interface"))
    found, unknown = streams.streams_of(rec, record.parts_of(rec), sorter, beside)
    findings.take_record(rec, unknown)
    findings.take_side(beside, options.given.get("interface"))
    if not found:
        raise Refused(2, f"{options.record}: none of its frames is in {options.given['dbc']}")
    for stream in found:
        with closing(Store(store.folder)) as scratch:
            stream.put_in_order(store, scratch)
    summary = {"unknown": [{"identifier": report.identifier_text(i), "source": s, "frames": n, "line": line} for i, s, n, line in unknown],
               "cut_line": rec.cut, "error_frames": rec.errors, "remote_frames": rec.remote,
               "dropped": {"recorder": beside.lost if beside else 0, "candump": rec.dropped_frames}}  # fmt: skip
    return database, found, beside, summary


def origin_of(found):
    least = [int(stream.converted(rows)["stamp_ns"].min()) for stream in found for rows in stream.frames.chunks()]
    if not least:
        raise Refused(2, "no frame has all the bytes that the DBC says")
    return min(least)


def make_table(options, findings, inputs, store):
    """(the recording, its columns, how encoders were zeroed, the first stamp)."""
    model, database, found = inputs
    streams.find_silence(found)
    groups = ticks.tick_groups(found, store)
    for group in groups:
        for stream in group.streams:
            stream.find_late(group, store)
    columns, absent = table.find_columns(found, database, options.mapping, options.given["dbc"])
    names, required = column_names(model, columns, absent, findings)
    origin_ns = origin_of(found)
    zeros = table.fill(columns, groups, model, origin_ns, store)
    names = with_values(names, required, columns, findings)
    made = table.assemble(columns, names, check_base(names, required), store)
    for joint, zero in zeros.items():
        if zero is None:
            findings.notes.append(f"{joint}: no absolute encoder; {joint}_motor_rad is 0 at the first sample")
    if options.rate and len(made) > 1:
        made = table.even(made, options.rate)
    if len(made) < LEAST_ROWS:
        raise Refused(2, f"{options.record}: gives {len(made)} samples, fewer than {LEAST_ROWS}")
    return made, columns, zeros, origin_ns


def export(options, findings, store):
    model = BenchModel(options.given["model"])  # what is wrong with it is said before a long record is read
    database, found, beside, of_record = read_streams(options, findings, store)
    made, columns, zeros, origin_ns = make_table(options, findings, (model, database, found), store)
    zero_ns = origin_ns + round(made.first_ns)
    for stream in found:
        findings.take_stream(stream, zero_ns)
    converted = all(stream.clock.is_monotonic for stream in found)
    steps = findings.take_clock(beside, zero_ns) if converted else []
    findings.take_unrelated(beside, found)
    marks = ({**mark, "time_s": (mark["mono_ns"] - zero_ns) / 1e9} for mark in (beside.all_marks() if beside and converted else ()))
    summary = {"rows": len(made), "left_out": made.left_out, "duration_s": (made.last_ns - made.first_ns) / 1e9,
               "columns": made.names, "zero_ns": zero_ns, "clock": "CLOCK_MONOTONIC" if converted else "the stamps' clock",
               "clock_uncertain_s": beside.model.uncertain_ns / 1e9 if beside and converted else None, "clock_steps": steps, "restarts": findings.take_joints(made), "marks": report.Listed(marks), "encoders": zeros, **of_record,
               "faults_not_listed": findings.not_listed, "messages": findings.messages,
               "faults": report.Listed(entry for stream in found for entry in report.fault_entries(stream, zero_ns))}  # fmt: skip
    return recording_text(made, columns), summary


def write_report(options, findings, summary):
    if "report" not in options.given:
        return
    content = {"schema": SCHEMA, "record": str(options.record), "complete": not findings.lost, **summary}
    pieces = json.JSONEncoder(indent=1, ensure_ascii=False).iterencode(content)
    outputs.write(options.given["report"], (piece.encode() for piece in chain(pieces, "\n")))


def tell(options, findings, summary):
    for line in findings.lost:
        say(line)
    if "quiet" in options.given:
        return
    for line in findings.notes:
        say(f"note: {line}")
    left_out = f"; {summary['left_out']} samples left out, where a frame was missing" if summary["left_out"] else ""
    say(f"{options.given['out']}: {summary['rows']} samples in {summary['duration_s']:.3f} s{left_out}")


def keep_freed_memory():
    """Arrays of some hundred kilobytes come and go all the time: what one leaves the next one takes, instead of new pages from the
    kernel each time. Where the C library knows no such thing it stays as it is."""
    with contextlib.suppress(OSError, AttributeError):
        tune = ctypes.CDLL(None).mallopt
        tune(M_MMAP_THRESHOLD, 32 << 20)
        tune(M_TRIM_THRESHOLD, 128 << 20)


def run(arguments):
    """The program; raises Refused. Its status: 1 where frames were lost."""
    keep_freed_memory()
    options = Options(arguments)
    if command_line.answered([f"--{name}" for name in options.given], NAME, USAGE):
        return 0
    options.check()
    findings = Findings()
    try:
        with closing(Store(outputs.folder_beside(options.given["out"]))) as store:
            text, summary = export(options, findings, store)
            outputs.write(options.given["out"], text)
            write_report(options, findings, summary)
    except talus.TalusError as error:
        raise Refused(1, str(error)) from error
    tell(options, findings, summary)
    return 1 if findings.lost else 0


def main(arguments):
    """Exit status of the program."""
    return command_line.status(NAME, run, arguments)
