"""The exporter on inputs that nobody means: mutated records, events files and DBCs. Whatever comes, it is exported or refused
with one line, in 10 s and 100 MB. `make fuzz COUNT=100000 SEED=1` runs the long one with so many, from that seed on."""

import contextlib
import ctypes
import io
import json
import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from bus_record import BEGIN_NS, DBC, MODEL, frames_of, twin, write
from support import many

from talus.acquire_export import command

MANY, FIRST = int(os.environ.get("TALUS_FUZZ", many(3000))), int(os.environ.get("TALUS_FUZZ_SEED", "10000"))
LONGEST_S, MOST_MB = 10, 100
NUMBERS = ("0", "-1", "1", "255", "256", "65536", "2147483648", "9223372036854775807", "9223372036854775808", "-9223372036854775809",
           "1e999", "-1e999", "1e-320", "NaN", "0.1", "2", "7", "8", "16", "33", "48", "63", "64", "true", "null", '"x"', "[]", "{}", "9" * 5000)  # fmt: skip
EXTREME_LINES = ("(0.000000) can0 201#", "(9999999999.999999) can0 201#0000000000000000", "(1700000000.0) can0 201#R", "", "\0", "(",
                 "(1.0)  201#00", "(1700000000.500000) can0 202##1" + "00" * 64, "(1700000000.000000) can0 310#FFFF",
                 "(99999999999999999999.0) can0 201#0000000000000000", "DROPCOUNT: dropped 99999999999999999999 CAN frames")  # fmt: skip
# seeds that once ended in a traceback or in gigabytes, or are near one
KEPT = (17, 230, 411, 14874, 20384, 20719, 302740, 311004, 325136, 334257, 500927)


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    """(lines of a record, lines of its events file, the DBC's text)."""
    folder = tmp_path_factory.mktemp("base")
    frames = frames_of(twin(folder, duration=1)[:400])
    log = write(folder / "r.log", frames).read_text().splitlines()
    events = [{"type": "header", "sources": [{"name": "can0", "stamps": "software"}]}]
    events += [{"type": "clock", "mono_ns": 5 * 10**9 + t, "real_ns": BEGIN_NS + t, "raw_ns": t, "width_ns": 50}
               for t in range(-(10**8), 10**9, 10**8)]  # fmt: skip
    events += [{"type": "drop", "source": "can0", "where": "socket", "lost": 3, "after": 10, "real_ns": 1},
               {"type": "hardware_clock", "source": "can1", "hw_ns": 1, "real_ns": BEGIN_NS},
               {"type": "link", "source": "can0", "state": "gone", "after": 5},
               {"type": "edge", "source": "x", "value": 1, "mono_ns": 5 * 10**9}, {"type": "end"}]  # fmt: skip
    return log, [json.dumps(event) for event in events], DBC.read_text()


def mutate_numbers(lines, generator):
    """Only numbers: the text stays one that parses, more often than not."""
    lines = list(lines)
    for _ in range(generator.choice((1, 1, 2, 5))):
        at = generator.randrange(len(lines))
        lines[at] = replace_number(lines[at], generator)
    return lines


def mutate_lines(lines, generator):
    lines = list(lines)
    for _ in range(generator.choice((1, 1, 2, 5, 50))):
        if not lines:
            break
        at = generator.randrange(len(lines))
        kind = generator.randrange(9)
        if kind == 0:
            del lines[at:at + generator.choice((1, 10, 200))]
        elif kind == 1:
            lines.insert(at, generator.choice(lines))
        elif kind == 2:
            lines.insert(at, generator.choice(EXTREME_LINES))
        elif kind == 3 and lines[at]:
            text, place = list(lines[at]), generator.randrange(len(lines[at]))
            text[place] = chr(generator.randrange(256))
            lines[at] = "".join(text)
        elif kind == 4:
            lines[at] = lines[at][:generator.randrange(len(lines[at]) + 1)]
        elif kind == 5:
            other = generator.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        elif kind == 6:
            lines[at] = lines[at].replace("can0", generator.choice(("can1", "x" * 200, "")), 1)
        elif kind == 7 and len(lines) < 5000:
            lines += lines
        else:
            lines[at] = replace_number(lines[at], generator)
    return lines


def replace_number(line, generator):
    """One run of digits becomes another number."""
    starts = [i for i, c in enumerate(line) if c.isdigit() and (i == 0 or not line[i - 1].isdigit())]
    if not starts:
        return line
    begin = generator.choice(starts)
    end = begin
    while end < len(line) and line[end].isdigit():
        end += 1
    return line[:begin] + generator.choice(NUMBERS) + line[end:]


def options_of(generator):
    return [word for option in (["--rate", generator.choice(("1e6", "250", "0.01"))], ["--interface", generator.choice(("can0", "can1"))],
                                ["--channel", "knee_temp_C=Supply.BusVoltage"], ["--quiet"])
            if generator.random() < 0.15 for word in option]  # fmt: skip


def export(folder, generator):
    """The exit status, and what was said."""
    arguments = ["--dbc", folder / "r.dbc", "--model", MODEL, "--out", folder / "r.csv", "--report", folder / "r.json",
                 *options_of(generator), folder / "r.log"]  # fmt: skip
    words = io.StringIO()
    with contextlib.redirect_stderr(words):
        status = command.main([str(argument) for argument in arguments])
    return status, words.getvalue()


def fuzz_one(base, folder, seed):
    generator = random.Random(seed)
    log, events, dbc = base
    which = generator.choice(("log", "log", "events", "both", "dbc"))
    mutate = generator.choice((mutate_lines, mutate_numbers))
    log = mutate_lines(log, generator) if which in ("log", "both") else log
    events = mutate(events, generator) if which in ("events", "both") else events
    if which == "dbc":
        dbc = "\n".join(mutate(dbc.splitlines(), generator))
    (folder / "r.log").write_text("\n".join(log) + "\n" * (generator.random() < 0.9), encoding="latin-1", errors="replace")
    (folder / "r.jsonl").write_text("\n".join(events) + "\n", encoding="latin-1", errors="replace")
    (folder / "r.dbc").write_text(dbc, encoding="latin-1", errors="replace")
    (folder / "r.csv").unlink(missing_ok=True)
    signal.alarm(LONGEST_S)
    try:
        status, words = export(folder, generator)
    finally:
        signal.alarm(0)
    assert status in (0, 1, 2), words
    assert (folder / "r.csv").exists() == (status != 2)
    if status == 2:
        assert len(words.splitlines()) == 1, words


def status_MB(process, key):
    """VmRSS: what it has; VmHWM: the most it had."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith(key))


def ready_MB():
    """What a process weighs that is ready to export."""
    script = "import talus.acquire_export.command; print(flush=True); input()"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen([sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment) as process:
        process.stdout.readline()
        weight = status_MB(process.pid, "VmRSS")
        process.communicate(b"\n")
    return weight


class Memory:
    """The peak of an export, were it alone in its process: what it adds to this one, and what one weighs that is ready to export. What
    earlier exports left behind counts as well, so that it says too much sooner than too little."""

    def __init__(self):
        self.give_back = ctypes.CDLL(None).malloc_trim
        self.give_back(0)
        self.besides = status_MB("self", "VmRSS") - ready_MB()

    def begin(self):
        """The highest so far is forgotten."""
        self.give_back(0)
        Path("/proc/self/clear_refs").write_text("5")

    def peak_MB(self):
        """0 under the sanitizers, which keep back what is freed."""
        return 0.0 if "LD_PRELOAD" in os.environ else status_MB("self", "VmHWM") - self.besides


def run_seeds(base, folder, seeds):
    def hang(*_):
        raise TimeoutError(f"more than {LONGEST_S} s")

    before = signal.signal(signal.SIGALRM, hang)
    failed, memory, most = {}, Memory(), 0.0
    try:
        for seed in seeds:
            try:
                memory.begin()
                fuzz_one(base, folder, seed)
                most = max(most, memory.peak_MB())
                assert memory.peak_MB() <= MOST_MB, "too much memory"
            except (Exception, TimeoutError) as error:  # noqa: BLE001 - each kind is to be shown
                failed.setdefault(f"{type(error).__name__}: {str(error)[:120]}", []).append(seed)
    finally:
        signal.signal(signal.SIGALRM, before)
    print(f"{len(seeds)} inputs, at most {most:.1f} MB")
    assert failed == {}


@pytest.mark.long
def test_mutated_inputs_are_exported_or_refused(base, tmp_path):
    run_seeds(base, tmp_path, [*KEPT, *range(250)])


@pytest.mark.release
def test_a_peak_is_seen_and_forgotten():
    """Also when the memory has been given back."""
    memory = Memory()
    memory.begin()
    before = memory.peak_MB()
    assert before < MOST_MB
    bytearray(b"x") * (MOST_MB << 20)
    assert memory.peak_MB() > MOST_MB
    memory.begin()
    assert memory.peak_MB() < before + 10


@pytest.mark.long
def test_many_mutated_inputs(base, tmp_path):
    run_seeds(base, tmp_path, range(FIRST, FIRST + MANY))


@pytest.mark.long
def test_mutated_inputs_with_floating_point(base, tmp_path):
    """A current, a temperature and a voltage of 16 bits that are read as floating-point numbers: some are none."""
    log, events, dbc = base
    floats = "\n".join(f"SIG_VALTYPE_ {number} {name} : 1;" for number, name in ((513, "Current"), (769, "MotorTemperature"), (784, "BusVoltage")))
    run_seeds((log, events, f"{dbc}\n{floats}\n"), tmp_path, range(400))
