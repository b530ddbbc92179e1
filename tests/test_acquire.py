"""talus-acquire as far as any machine can run it: frames come through its `fd:` source. What needs a real
SocketCAN or a GPIO chip is in tests/rig."""

import contextlib
import json
import os
import pty
import random
import re
import resource
import signal
import subprocess
import time

import can
import cantools
import pytest
from frame_source import BRS, ERROR, ESI, EXTENDED, REMOTE, FrameSource
from support import REPOSITORY, program, run

START_NS = 1_700_000_000_123_456_789
DBC = REPOSITORY / "models/leg.dbc"


# ---- the record ---------------------------------------------------------------------------


def random_frame(generator, k):
    """(identifier with flags, data, keywords) of any kind of frame."""
    extended = generator.random() < 0.3
    identifier = generator.randrange(1 << 29) | EXTENDED if extended else generator.randrange(1 << 11)
    kind = generator.choice(("classic", "classic", "remote", "fd"))
    if kind == "fd":
        size = generator.choice((0, 1, 7, 8, 12, 20, 48, 64))
        return identifier, generator.randbytes(size), {"fd": True, "flags": generator.choice((0, BRS, ESI, BRS | ESI))}
    if kind == "remote":
        return identifier | REMOTE, b"", {"length": generator.randrange(9)}
    return identifier, generator.randbytes(generator.randrange(9)), {}


def test_python_can_reads_every_field(tmp_path):
    generator = random.Random(1)
    sent = [random_frame(generator, k) for k in range(3000)]
    with FrameSource(tmp_path / "r") as source:
        for k, (identifier, data, more) in enumerate(sent):
            source.send(identifier, data, stamp_ns=START_NS + 110_000 * k, **more)
    assert source.status == 0, source.printed
    messages = list(can.LogReader(source.log))
    assert len(messages) == len(sent)
    for k, (message, (identifier, data, more)) in enumerate(zip(messages, sent, strict=True)):
        assert message.channel == "bench"
        assert abs(message.timestamp - (START_NS + 110_000 * k) / 1e9) < 1.1e-6
        assert message.arbitration_id == identifier & 0x1FFFFFFF
        assert message.is_extended_id == bool(identifier & EXTENDED)
        assert message.is_remote_frame == bool(identifier & REMOTE) and not message.is_error_frame
        assert message.is_fd == more.get("fd", False)
        assert message.bitrate_switch == bool(more.get("flags", 0) & BRS)
        assert message.error_state_indicator == bool(more.get("flags", 0) & ESI)
        if message.is_remote_frame:
            assert message.dlc == more["length"]
        else:
            assert bytes(message.data) == data


def test_cantools_decodes_what_was_sent(tmp_path):
    """Every message of the bench's bus, with random content: the decoded record is the decoded original."""
    database, generator = cantools.database.load_file(DBC), random.Random(2)
    sent = []
    with FrameSource(tmp_path / "r") as source:
        for k in range(2000):
            message = generator.choice(database.messages)
            data = generator.randbytes(message.length)
            sent.append((message.frame_id, data))
            source.send(message.frame_id, data, stamp_ns=START_NS + 110_000 * k)
    read = list(can.LogReader(source.log))
    assert len(read) == len(sent)
    for message, (identifier, data) in zip(read, sent, strict=True):
        decoded = database.decode_message(message.arbitration_id, bytes(message.data), decode_choices=False)
        assert decoded == database.decode_message(identifier, data, decode_choices=False)


def merged_frames(folder, count):
    """Numbers of frames that three sources sent in a wild order between them, as they stand in the record."""
    generator = random.Random(3)
    now = time.time_ns() - 10_000_000_000  # in the past, so that none is ahead of the clock
    with FrameSource(folder, "a", "b", "c") as source:
        for k in range(count):
            source.send(0x100, k.to_bytes(4, "little"), to=generator.choice("abc"), stamp_ns=now + 100_000 * k)
    return [int.from_bytes(bytes.fromhex(line.split("#")[1]), "little") for line in source.lines()]


def test_sources_are_merged_in_order_of_time(tmp_path):
    """Lines stand in the order of their stamps. The recorder waits for a slow source three cycles long and no longer, and a
    machine that others use may starve one for longer: nothing is lost then, and one run of three is in order."""
    runs = [merged_frames(tmp_path / "first", 3000)]
    while runs[-1] != sorted(runs[-1]) and len(runs) < 3:
        runs.append(merged_frames(tmp_path / f"again{len(runs)}", 3000))
    assert all(sorted(numbers) == list(range(3000)) for numbers in runs)
    assert runs[-1] == sorted(runs[-1])


def test_header_clocks_and_end(tmp_path):
    before = time.time_ns()
    with FrameSource(tmp_path / "r") as source:
        for k in range(100):
            source.send(0x123, bytes(8))
        time.sleep(2.3)
    header, *_, end = source.events()
    assert header["type"] == "header" and header["schema"] == "talus-acquire/1" and header["log"] == "r.log"
    assert [(one["name"], one["kind"], one["stamps"]) for one in header["sources"]] == [("bench", "fd", "software")]
    assert end["type"] == "end" and end["reason"] == "sources closed" and end["lost"] == 0
    assert end["sources"][0]["frames"] == 100 and end["loop"]["allocations"] in (0, None)
    clocks = source.events("clock")
    assert len(clocks) == 4  # at the start, after one and two seconds, at the end
    for clock in clocks:
        assert before <= clock["real_ns"] <= time.time_ns() and 0 <= clock["width_ns"] < 1e9
        offset = time.time_ns() - time.monotonic_ns()
        assert abs(clock["real_ns"] - clock["mono_ns"] - offset) < 5e7
    assert abs(float(source.lines()[0][1:18]) - before / 1e9) < 30


# ---- errors, losses, repeats, swaps ---------------------------------------------------------


def test_error_frames_are_folded_into_states_and_none_is_in_the_log(tmp_path):
    error = [  # identifier, data, state that follows
        (0x4, bytes([0, 0x08, 0, 0, 0, 0, 96, 0]), "warning"),
        (0x4, bytes([0, 0x20, 0, 0, 0, 0, 128, 0]), "passive"),
        (0x8, bytes([0, 0, 0, 0x1A, 0, 0, 0, 0]), None),  # a protocol violation changes no state
        (0x40, bytes(8), "off"),
        (0x100, bytes(8), "restarted"),
        (0x4, bytes([0, 0x40, 0, 0, 0, 0, 0, 0]), "active"),
        (0x4, bytes([0, 0x01, 0, 0, 0, 0, 0, 0]), None),  # the controller's buffer ran over
    ]
    with FrameSource(tmp_path / "r") as source:
        for k, (identifier, data, _) in enumerate(error):
            for _ in range(k):
                source.send(0x100, b"data", stamp_ns=START_NS + 1_000_000 * k)
            source.send(identifier | ERROR, data, stamp_ns=START_NS + 1_000_000 * k)
    assert source.status == 1 and "1 lost" in source.printed  # of a controller's overflow at least one
    assert len(source.lines()) == sum(range(7))
    assert all("100#" in line for line in source.lines())
    after = [sum(range(k + 1)) for k in range(7)]
    errors = source.events("error")
    assert [(int(one["id"], 16), bytes.fromhex(one["data"]), one["count"]) for one in errors] == [
        (identifier | ERROR, data, 1) for identifier, data, _ in error
    ]
    assert [one["after"] for one in errors] == after
    states = [(one["state"], one["after"], one["by"]) for one in source.events("bus_state")]
    assert states == [(state, after[k], "error_frame") for k, (_, _, state) in enumerate(error) if state]


def test_equal_error_frames_are_counted_together(tmp_path):
    with FrameSource(tmp_path / "r") as source:
        for k in range(500):
            source.send(ERROR | 0x8, bytes(8), stamp_ns=START_NS + 1000 * k)
    errors = source.events("error")
    assert sum(one["count"] for one in errors) == 500 == source.events("end")[0]["sources"][0]["errors"]
    assert len(errors) < 100


class Bus:
    """A minute's beginning of the leg's bus at 1 kHz, with injections; and what must be found."""

    TICKS, SPACING = 42_000, 40

    def __init__(self, seed):
        generator = random.Random(seed)
        self.sequence = []  # (identifier, counter, late_ns) in the order of sending; None: an error frame
        self.expected = []  # (kind, message, counter, count), found by its counter
        self.errors = []  # frames of the log before each error frame
        hit = {tick: generator.choice(("lost", "repeated", "swapped", "error", "jitter")) for tick in
               range(500, self.TICKS - 500, self.SPACING)}  # fmt: skip
        self.injections = len(hit)
        for tick in range(self.TICKS):
            self.sequence += [(0x201, tick, 0), (0x202, tick, 0)]
        for tick, kind in reversed(hit.items()):
            self.inject(kind, tick, generator)

    def inject(self, kind, tick, generator):
        side = generator.randrange(2)
        at, message = 2 * tick + side, ("KneeState", "AnkleState")[side]
        if kind == "lost":
            count = generator.randrange(1, 4)
            for k in reversed(range(count)):
                del self.sequence[at + 2 * k]
            self.expected.append(("lost", message, tick, count))
        elif kind == "repeated":
            self.sequence.insert(at + 1, self.sequence[at])
            self.expected.append(("repeated", message, tick, 1))
        elif kind == "swapped":
            self.sequence[at], self.sequence[at + 2] = self.sequence[at + 2], self.sequence[at]
            self.expected.append(("swapped", message, tick, 1))
        elif kind == "error":
            self.sequence.insert(at, None)
        else:  # late by less than a period: no fault
            identifier, counter, _ = self.sequence[at]
            self.sequence[at] = (identifier, counter, 300_000)

    def send(self, source):
        frames = 0
        tick = 0
        for entry in self.sequence:
            if entry is None:
                self.errors.append(frames)
                source.send(ERROR | 0x8, bytes([0, 0, 0, 0x1A, 0, 0, 0, 0]), stamp_ns=START_NS + 1_000_000 * tick)
                continue
            identifier, tick, late_ns = entry
            data = tick.to_bytes(4, "little")[:2] + bytes.fromhex("000800080000")
            source.send(identifier, data, stamp_ns=START_NS + 1_000_000 * tick + 50_000 * (identifier - 0x200) + late_ns)
            frames += 1


def test_a_thousand_injections_are_found_and_none_invented(tmp_path):
    """Losses, repeats and swaps by the export's counters, with their lines; error frames by the record, with their place."""
    bus = Bus(seed=11)
    assert bus.injections >= 1000
    with FrameSource(tmp_path / "r") as source:
        bus.send(source)
    assert source.status == 0, source.printed
    errors = source.events("error")
    places = [one["after"] for one in errors for _ in range(one["count"])]
    assert places == bus.errors
    arguments = ("--dbc", DBC, "--model", REPOSITORY / "models/leg_bench.yaml", "--out", tmp_path / "r.csv")
    run("talus-acquire", "export", source.log, *arguments, "--report", tmp_path / "r.json", "--quiet", status=1)
    faults = json.loads((tmp_path / "r.json").read_text())["faults"]
    found = [(one["kind"], one["message"], one["counter"], one["count"]) for one in faults]
    assert sorted(found) == sorted(bus.expected)
    lines = [entry for entry in bus.sequence if entry]
    for one in faults:
        identifier = {"KneeState": 0x201, "AnkleState": 0x202}[one["message"]]
        before, at = lines[one.get("after_line", one["line"]) - 1], lines[one["line"] - 1]
        assert at[0] == before[0] == identifier
        if one["kind"] == "lost":
            assert (before[1], at[1]) == (one["counter"] - 1, one["counter"] + one["count"])
        else:
            assert at[1] == one["counter"]


# ---- ends ------------------------------------------------------------------------------------


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "SIGTERM"])
def test_a_signal_ends_cleanly(tmp_path, sent):
    with FrameSource(tmp_path / "r") as source:
        for _ in range(10):
            source.send(0x1, b"\1")
        time.sleep(0.5)
        source.process.send_signal(sent)
        source.process.wait(20)
        source.close()
    assert source.status == 0 and "ended by signal, nothing lost" in source.printed
    assert len(source.lines()) == 10 and source.events("end")[0]["reason"] == "signal"


def test_live_line_on_a_terminal(tmp_path):
    """Rates, what was lost and the time to the end, over and over in one line."""
    terminal, theirs = pty.openpty()
    with FrameSource(tmp_path / "r", options=("--duration", 3.4), stderr=theirs) as source:
        os.close(theirs)
        for k in range(300):
            source.send(0x100, bytes([k % 256]))
            time.sleep(0.01)
        source.process.wait(20)
        shown = os.read(terminal, 65536).decode()
        os.close(terminal)
    lines = [re.fullmatch(r"(\d+)\.\d s  bench (\d+)/s  lost 0  to go (\d+)\.\d s\x1b\[K\s*", line) for line in shown.split("\r")
             if "to go" in line]  # fmt: skip
    assert [(int(line[1]), int(line[3])) for line in lines] == [(0, 3), (1, 2), (2, 1), (3, 0)]
    assert all(20 < int(line[2]) <= 110 for line in lines[1:])
    assert "ended by duration, nothing lost" in shown


def test_duration_ends(tmp_path):
    with FrameSource(tmp_path / "r", options=("--duration", 0.6)) as source:
        began = time.monotonic()
        source.process.wait(20)
        assert 0.4 < time.monotonic() - began < 5
        source.close()
    assert source.status == 0 and source.events("end")[0]["reason"] == "duration"


def test_a_file_that_may_not_grow(tmp_path):
    """The recording ends with a clear word; what is there are whole lines, and what is not is counted."""
    source = None
    soft = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, soft[1]))
    try:
        source = FrameSource(tmp_path / "r")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, soft)
    with source:
        try:
            for k in range(5000):
                source.send(0x123, k.to_bytes(4, "little"))
        except OSError:
            pass  # the recorder has gone
        source.close()
    assert source.status == 1 and f"{source.log}: File too large; the recording ends here" in source.printed
    text = source.log.read_text()
    assert text.endswith("\n") and 39_900 < len(text) <= 40_000
    numbers = [int.from_bytes(bytes.fromhex(line.split("#")[1]), "little") for line in source.lines()]
    assert numbers == list(range(len(numbers)))
    end = source.events("end")[0]
    assert end["sources"][0]["frames"] == len(numbers) and end["lost"] == end["sources"][0]["not_written"] > 0


@pytest.fixture(scope="module")
def failing_disk(tmp_path_factory):
    library = tmp_path_factory.mktemp("disk") / "failing_disk.so"
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", library, REPOSITORY / "tests/failing_disk.c", "-ldl"], check=True)
    return library


@pytest.mark.release
@pytest.mark.parametrize("call", [2, 3])
def test_a_disk_that_fails_behind_the_write(tmp_path, failing_disk, monkeypatch, call):
    """It ends as a full one does: a clear word, status 1, and what the disk never confirmed counts as lost, with its place."""
    monkeypatch.setenv("LD_PRELOAD", str(failing_disk))
    monkeypatch.setenv("FAILING_SYNC", str(call))
    with FrameSource(tmp_path / "r") as source:
        monkeypatch.delenv("LD_PRELOAD")
        sent = 0
        with contextlib.suppress(OSError):  # the recorder has gone
            while source.process.poll() is None and sent < 20_000:
                source.send(0x123, sent.to_bytes(4, "little"))
                sent += 1
                time.sleep(0.0005)
        source.close()
    assert source.status == 1 and f"{source.log}: Input/output error; the recording ends here" in source.printed
    end = source.events("end")[0]
    (bench,) = end["sources"]
    there = len(source.lines())
    assert end["reason"] == "write failed" and bench["unexplained"] == 0
    assert end["events_not_written"] > 0 and f"EVENTS NOT WRITTEN {end['events_not_written']}" in source.printed  # the last clock
    assert bench["synced"] <= there and bench["frames"] == bench["synced"] + bench["not_synced"]
    assert end["lost"] == bench["not_synced"] + bench["not_written"] > 0
    assert bench["read"] == bench["synced"] + end["lost"]
    (drop,) = source.events("drop")
    assert (drop["where"], drop["lost"], drop["after"]) == ("disk", bench["not_synced"], bench["synced"])


def test_the_account_of_a_whole_record_balances(tmp_path):
    with FrameSource(tmp_path / "r", "a", "b") as source:
        for k in range(1000):
            source.send(0x100, k.to_bytes(4, "little"), to="ab"[k % 2])
        source.send(ERROR | 0x8, bytes(8), to="b")
    assert source.status == 0
    for one, errors in zip(source.events("end")[0]["sources"], (0, 1), strict=True):
        assert (one["read"], one["frames"], one["synced"], one["not_synced"]) == (500 + errors, 500, 500, 0)
        assert one["not_written"] == one["unexplained"] == one["lost_socket"] == 0


@pytest.mark.parametrize("stamp_ns", [2**63 - 1, -(2**63), -1])
def test_a_stamp_beyond_all_times_holds_up_nobody(tmp_path, stamp_ns):
    """What it stands behind is written, and the frames before and after it too."""
    with FrameSource(tmp_path / "r", "a", "b") as source:
        for k in range(3000):
            source.send(0x100, k.to_bytes(4, "little"), to="ab"[k % 2], stamp_ns=stamp_ns if k == 100 else START_NS + k)
    assert source.status == 0, source.printed
    for name in "ab":
        numbers = [int.from_bytes(bytes.fromhex(line.split("#")[1]), "little") for line in source.lines() if f" {name} " in line]
        assert numbers == list(range("ab".index(name), 3000, 2))


# ---- usage -----------------------------------------------------------------------------------


def complaint(*arguments, status=2):
    lines = run("talus-acquire", *arguments, status=status).stderr.splitlines()
    assert len(lines) == 1
    return lines[0].removeprefix("talus-acquire: ")


@pytest.mark.parametrize(("source", "words"), [
    ("gpio:x", "source 'gpio:x': expected gpio:NAME=CHIP:LINE"),
    ("gpio:x=gpiochip0:1:sideways", "expected gpio:NAME=CHIP:LINE"),
    ("gpio:x=nochip9:1", "GPIO line nochip9:1: the chip cannot be opened: No such file or directory"),
    ("pulse:x=gpiochip0:1", "expected pulse:NAME=CHIP:LINE:HZ"),
    ("pulse:x=gpiochip0:1:10:200", "expected pulse:NAME=CHIP:LINE:HZ"),
    ("estop:x=gpiochip0:1", "an estop source needs --stop"),
    ("fd:x=", "expected fd:NAME=NUMBER"),
    ("fd:x=99", "fd:x=99: expected an open datagram socket"),
    ("fd:a name=3", "expected fd:NAME=NUMBER"),
    ("averyveryverylongname", "expected a CAN interface of at most 15 letters"),
    ("nocan9", "nocan9: no such interface"),
])  # fmt: skip
def test_sources_that_are_none(tmp_path, source, words):
    assert words in complaint("--out", tmp_path / "x", source)
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize(("options", "words"), [
    (("--duration", "-1"), "--duration"),
    (("--buffer", "1"), "--buffer"),
    (("--gpio-backend", "other"), "'other' is not in this build"),
    (("--stop", "nocan9:12#"), "--stop: expected for instance can0 or can0:001#0011"),
    (("--stop", "nocan9"), "--stop: nocan9: no such interface"),
])  # fmt: skip
def test_options_that_are_none(tmp_path, options, words):
    assert words in complaint("--out", tmp_path / "x", *options, "can0")


@pytest.mark.parametrize("out", ["", "folder/", ".log", "folder/.log", "."])
def test_names_that_are_none(tmp_path, monkeypatch, out):
    """No hidden ".log" is made."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    with FrameSource(out) as source:
        source.process.wait(20)
        source.close()
    assert source.status == 2 and source.printed.startswith("talus-acquire: --out: expected a file's name")
    assert [str(path) for path in tmp_path.rglob("*")] == [str(tmp_path / "folder")]


@pytest.mark.parametrize("name", ["r.log", "r.jsonl"])
@pytest.mark.parametrize("is_read", [False, True], ids=["nobody reads", "read"])
@pytest.mark.parametrize("options", [(), ("--overwrite",)], ids=["", "overwrite"])
def test_what_is_no_file_is_not_written(tmp_path, options, is_read, name):
    """A pipe that nobody reads would hold up the program for good, deaf to every signal; one that is read keeps no record."""
    os.mkfifo(tmp_path / name)
    reader = os.open(tmp_path / name, os.O_RDONLY | os.O_NONBLOCK) if is_read else -1
    with FrameSource(tmp_path / "r", options=options) as source:
        source.process.wait(20)
        source.close()
    if is_read:
        assert os.read(reader, 100) == b""
        os.close(reader)
    assert source.status == 2 and f"{name}: is there, and is no file" in source.printed
    assert os.listdir(tmp_path) == [name]


def test_an_earlier_record_stays(tmp_path):
    (tmp_path / "r.log").write_text("precious\n")
    with FrameSource(tmp_path / "r.log") as source:
        source.process.wait(20)
        source.close()
    assert source.status == 2 and "is there already (--overwrite replaces it)" in source.printed
    assert (tmp_path / "r.log").read_text() == "precious\n" and os.listdir(tmp_path) == ["r.log"]


def test_overwrite_replaces(tmp_path):
    (tmp_path / "r.log").write_text("old\n")
    (tmp_path / "r.jsonl").write_text("old\n")
    with FrameSource(tmp_path / "r", options=("--overwrite",)) as source:
        source.send(0x7, b"\7")
    assert [line.split(" ", 1)[1] for line in source.lines()] == ["bench 007#07"]
    assert source.events()[0]["type"] == "header"


def test_a_folder_that_is_not_there(tmp_path):
    with FrameSource(tmp_path / "no/r") as source:
        source.process.wait(20)
        source.close()
    assert source.status == 1 and "cannot be written: No such file or directory" in source.printed


def test_two_sources_of_one_name(tmp_path):
    with FrameSource(tmp_path / "r", sources=("fd:bench=0",)) as source:
        source.process.wait(20)
        source.close()
    assert source.status == 2


def test_a_message_that_is_no_frame_is_counted(tmp_path):
    with FrameSource(tmp_path / "r") as source:
        source.send(0x1, b"\1")
        source.socket["bench"].send(b"not a frame")
        source.socket["bench"].send(b"\0" * 4 + bytes([9, 0, 0, 0]) + b"\0" * 8)  # says 9 bytes of 8
        source.send(0x2, b"\2")
    assert len(source.lines()) == 2
    assert source.status == 1 and source.events("end")[0]["sources"][0]["malformed"] == 2


def test_export_is_the_program_beside_it():
    direct = subprocess.run([program("talus-acquire-export"), "--help"], check=True, capture_output=True, text=True)
    assert run("talus-acquire", "export", "--help").stdout == direct.stdout


# ---- trajectories, machines ------------------------------------------------------------------

LIMITS = "knee.position=-1:1,knee.speed=5,ankle.position=-1:1,ankle.speed=5"
ROWS = "time_s,knee_rad,ankle_rad\n0,0,0\n0.001,0.001,0\n0.002,0.002,0\n"


@pytest.mark.parametrize(("text", "limits", "words"), [
    (ROWS.replace("knee_rad", "nee_rad"), LIMITS, ":1: missing column: knee_rad; found time_s, nee_rad, ankle_rad"),
    (ROWS.replace("0.001,0.001", "0.001,x"), LIMITS, ":3: knee_rad: 'x' is not a number"),
    (ROWS.replace("0.001,0.001", "0.001,nan"), LIMITS, ":3: knee_rad: 'nan' is not a finite number"),
    (ROWS.replace("0.002,0.002,0", "0.002,0.002"), LIMITS, ":4: 2 fields, expected 3 as in the header"),
    (ROWS.replace("0.002,", "0.001,"), LIMITS, ":4: time_s does not rise from 0.001 to 0.001"),
    (ROWS.replace("0.002,0.002", "0.0011,0.002"), LIMITS, ":4: time_s is 0.0001 s after the row before, expected 0.0002 to 0.05 s"),
    (ROWS.replace("0.002,0.002", "1.0,0.002"), LIMITS, ":4: time_s is 0.999 s after the row before, expected 0.0002 to 0.05 s"),
    ("time_s,knee_rad,ankle_rad\n0,0,0\n", LIMITS, "t.csv: 1 rows, expected at least 2"),
    ("", LIMITS, "t.csv: the file is empty"),
    (ROWS, "knee.position=-1:1,knee.speed=5", "ankle.position and ankle.speed are needed"),
    (ROWS, LIMITS + ",hip.speed=1", "--limits: expected for instance knee.position=-0.9:0.1 or ankle.speed=4, found 'hip.speed=1'"),
    (ROWS, LIMITS.replace("-1:1", "1:-1"), "--limits: expected"),
    (ROWS, LIMITS.replace("speed=5", "speed=0.5"), "knee.speed is 1.5 at time_s 0.001, outside its limit: nothing is sent"),  # 3 (q2 - q0) / 4 h of the spline at rest at both ends
    (ROWS, LIMITS.replace("-1:1", "-1:0.0015"), "knee.position is 0.002 at time_s 0.002"),
    (ROWS, LIMITS, "--play-on: nocan9: no such interface"),
])  # fmt: skip
def test_trajectories_that_are_not_played(tmp_path, text, limits, words):
    (tmp_path / "t.csv").write_text(text)
    options = ("--play", tmp_path / "t.csv", "--play-on", "nocan9", "--limits", limits)
    assert words in complaint("--out", tmp_path / "x", *options, "fd:x=99")
    assert os.listdir(tmp_path) == ["t.csv"]


@pytest.mark.parametrize(("arguments", "words"), [
    (("--out", "x"), "SOURCE... is missing"),
    (("can0",), "--out REC[.log] is missing"),
    (("--report", "q.json", "--out", "x", "can0"), "--report goes with --qualify"),
    (("--qualify", "--out", "x"), "SOURCE... is missing"),
    (("--play", "t.csv", "--out", "x", "fd:a=9"), "--play needs --limits"),
])  # fmt: skip
def test_words_that_do_not_go_together(arguments, words):
    assert words in complaint(*arguments)


def test_qualify_judges_every_item(tmp_path):
    """As text and as JSON; of the figures only what does not depend on the machine's speed is looked at."""
    printed = run("talus-acquire", "--qualify", "--duration", 2, "--report", tmp_path / "q.json").stdout
    told = json.loads((tmp_path / "q.json").read_text())
    assert told["schema"] == "talus-qualify/1" and 1.9 < told["seconds"] < 20
    verdicts = {item["name"]: item["verdict"] for item in told["items"]}
    assert list(verdicts) == ["kernel", "priority", "memory", "sleep", "clock", "clock steps", "governor", "throttling",
                              "wake-up", "loop", "drops"]  # fmt: skip
    assert set(verdicts.values()) <= {"good", "usable", "poor", "unknown"} and verdicts["drops"] == "unknown"
    for name, verdict in verdicts.items():
        assert any(line.startswith(verdict) and name in line for line in printed.splitlines())
    wake_ups = told["wake_ups"]
    assert sum(wake_ups["late_below_us"].values()) == wake_ups["count"]
    assert abs(wake_ups["count"] + wake_ups["missed"] - 1000 * told["seconds"]) < 50
    assert told["loop"]["allocations"] in (0, None)


def test_qualify_without_rights_says_so(tmp_path):
    told = tmp_path / "q.json"
    run("talus-acquire", "--qualify", "--duration", 0.2, "--no-realtime", "--report", told)
    verdicts = {item["name"]: item for item in json.loads(told.read_text())["items"]}
    for name in ("priority", "memory"):
        assert verdicts[name]["verdict"] == "poor" and "advice" in verdicts[name]


def test_qualify_while_recording(tmp_path):
    options = ("--qualify", "--duration", 1.5, "--report", tmp_path / "q.json")
    with FrameSource(tmp_path / "r", options=options) as source:
        for k in range(100):
            source.send(0x100, bytes([k]))
        time.sleep(1.7)
    assert source.status == 0, source.printed
    assert len(source.lines()) == 100
    told = {item["name"]: item for item in json.loads((tmp_path / "q.json").read_text())["items"]}
    assert told["drops"]["verdict"] == "good" and told["drops"]["found"] == "1 sources recorded, 0 lost"
