"""talus-acquire on a real SocketCAN: nothing lost at full load, everything accounted for beyond it."""

import fcntl
import itertools
import os
import pty
import random
import socket
import struct
import subprocess
import sys
import tempfile
import termios
import time
import tty
from array import array
from pathlib import Path

import pytest
from talus.acquire_export import record as export_record
from recording import Recording, counters, ip, lines_of, read_lines, send
from support import BUILD, run

pytestmark = [pytest.mark.rig, pytest.mark.release]

SECONDS = int(os.environ.get("TALUS_RIG_SECONDS", "60"))
KILLS = int(os.environ.get("TALUS_RIG_KILLS", "50"))
PER_MS = 9  # frames each millisecond: a full bus of 1 Mbit/s


def busy_processes(count):
    return [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]


def check_whole(path, sent):
    """Every frame of can_source is there, once, in order, its times never falling."""
    found = counters(path)
    assert {name: len(numbers) for name, (_, numbers) in found.items()} == sent
    for stamps, numbers in found.values():
        assert all(a == b for a, b in zip(numbers, itertools.count()))
        assert all(a <= b for a, b in itertools.pairwise(stamps))


def falling_stamps(path):
    """Lines of a log whose time is before that of the line above, whatever their interfaces; in whole microseconds."""
    stamps = array("q", (int(seconds.replace(".", "")) for seconds, *_ in lines_of(path)))
    return sum(b < a for a, b in itertools.pairwise(stamps))


@pytest.mark.parametrize("busy", [0, 2])
def test_full_load_loses_nothing_and_the_loop_stays_clean(vcan, tmp_path, busy, capsys):
    """Two full buses; candump beside it, whose count is printed; no page fault, no allocation after the start."""
    names, others = vcan(2), []
    candump = subprocess.Popen(["candump", "-L", *names], stdout=open(tmp_path / "candump.log", "w"))
    try:
        with Recording(tmp_path / "full", *names) as recording:
            others = busy_processes(busy)
            sent = send("rate", SECONDS, PER_MS, *names)
            time.sleep(0.2)
            recording.stop()
    finally:
        for process in [candump, *others]:
            process.kill()
            process.wait()
    assert sent == {name: SECONDS * 1000 * PER_MS for name in names}
    check_whole(recording.log, sent)
    end = recording.end()
    assert end["lost"] == 0
    assert falling_stamps(recording.log) <= end["out_of_order"]
    assert end["loop"] == {"page_faults_minor": 0, "page_faults_major": 0, "allocations": 0}
    total, kept = sum(sent.values()), (tmp_path / "candump.log").read_text().count("\n")
    with capsys.disabled():
        print(f"\n  {SECONDS} s, {busy} busy processes: sent {total}, logged {total}, candump -L {kept}; out of order {end['out_of_order']}")


def places(drops):
    """{frames before it: lost frames} as the drop records say."""
    told = {}
    for drop in drops:
        assert drop["where"] == "socket"
        told[drop["after"]] = told.get(drop["after"], 0) + drop["lost"]
    return told


def gaps(numbers):
    """The same from counters, the first of which stands before the recording."""
    return {i: b - a - 1 for i, (a, b) in enumerate(itertools.pairwise(numbers)) if b - a != 1}


def account(recording, name, sent):
    """sent = logged + reported, and every gap in the counters is a drop record of that size at that place."""
    numbers, drops = counters(recording.log)[name][1], recording.events("drop")
    reported = sum(drop["lost"] for drop in drops)
    assert len(numbers) + reported == sent
    assert recording.at_end(name)["frames"] == len(numbers)
    assert recording.end()["lost"] == reported
    assert places(drops) == gaps([-1, *numbers, sent])
    return reported


@pytest.mark.parametrize("buffer", [4 << 20, 65536])
def test_bursts_are_logged_or_counted(vcan, tmp_path, buffer, capsys):
    """As fast as the kernel takes frames; a small buffer must overflow, and every lost frame is told and placed."""
    (name,) = vcan()
    with Recording(tmp_path / "burst", name, "--buffer", buffer) as recording:
        others = busy_processes(2)
        sent = send("fast", 300_000, name)[name]
        for process in others:
            process.kill()
            process.wait()
        time.sleep(0.1)
        recording.stop(status=None)
    lost = account(recording, name, sent)
    assert recording.process.returncode == (1 if lost else 0)
    assert lost > 0 or buffer > 65536
    with capsys.disabled():
        print(f"\n  burst of {sent}, buffer {buffer}: logged {sent - lost}, reported {lost}")


def test_cangen_without_a_gap(vcan, tmp_path, capsys):
    """The tool that everybody has: sent = logged + reported."""
    (name,) = vcan()
    with Recording(tmp_path / "cangen", name) as recording:
        subprocess.run(["cangen", name, "-g", "0", "-n", "50000", "-I", "123", "-L", "8", "-i"], check=True)
        recording.stop(status=None)
    logged = len(read_lines(recording.log))
    assert logged + recording.end()["lost"] == 50000
    with capsys.disabled():
        print(f"\n  cangen -g 0: 50000 sent, {logged} logged, {recording.end()['lost']} reported")


def test_canplayer_plays_the_record(vcan, tmp_path):
    """The record of one interface, played onto another by the tool that everybody has, is recorded as the same frames."""
    name, other = vcan(2)
    with Recording(tmp_path / "first", name) as first:
        send("rate", 0.5, PER_MS, name)
        time.sleep(0.1)
        first.stop()
    with Recording(tmp_path / "second", other) as second:
        subprocess.run(["canplayer", "-I", str(first.log), f"{other}={name}"], check=True, timeout=60)
        time.sleep(0.1)
        second.stop()
    frames = [line[2:] for line in read_lines(first.log)]
    assert len(frames) == 500 * PER_MS and [line[2:] for line in read_lines(second.log)] == frames


def test_every_kind_of_frame_of_a_real_socket(vcan, tmp_path):
    """Classic, FD, extended and remote frames, sent by python-can: python-can reads the same from the log."""
    can = pytest.importorskip("can")
    (name,) = vcan()
    generator, sent = random.Random(6), []
    with can.Bus(name, interface="socketcan", fd=True) as bus, Recording(tmp_path / "kinds", name) as recording:
        for _ in range(1000):
            extended, fd = generator.random() < 0.5, generator.random() < 0.5
            remote = not fd and generator.random() < 0.2
            size = generator.choice((0, 3, 8, 12, 64)) if fd else generator.randrange(9)
            message = can.Message(arbitration_id=generator.randrange(1 << (29 if extended else 11)), is_extended_id=extended,
                                  is_fd=fd, bitrate_switch=fd and generator.random() < 0.5, is_remote_frame=remote,
                                  dlc=size, data=b"" if remote else generator.randbytes(size))  # fmt: skip
            bus.send(message)
            sent.append(message)
        time.sleep(0.1)
        recording.stop()
    read = list(can.LogReader(recording.log))
    assert len(read) == 1000
    for message, original in zip(read, sent, strict=True):
        assert message.equals(original, timestamp_delta=None, check_channel=False, check_direction=False)


def test_the_last_frames_before_the_end_are_counted(vcan, tmp_path):
    """Drops that no later frame tells about are asked for when the recording ends, in the middle of the load."""
    (name,) = vcan()
    with Recording(tmp_path / "end", name, "--buffer", 65536) as recording:
        sender = subprocess.Popen([str(BUILD / "tests/can_source"), "fast", "2000000", name], stdout=subprocess.PIPE)
        time.sleep(1.5)
        recording.stop(status=None)
        sender.kill()
        sender.communicate()
    numbers, drops = counters(recording.log)[name][1], recording.events("drop")
    before_the_last = sum(drop["lost"] for drop in drops if drop["after"] < len(numbers))
    assert len(numbers) + before_the_last == numbers[-1] + 1
    assert recording.end()["lost"] == sum(drop["lost"] for drop in drops) > 0


def calm_moment():
    """Waits until the guest has run without a stop for 100 ms, and answers the time: what stands still with its whole
    machine for longer can write nothing down."""
    for _ in range(200):
        for _ in range(20):
            before = time.monotonic()
            time.sleep(0.005)
            if time.monotonic() - before > 0.025:
                break
        else:
            return time.time()
    pytest.fail("this machine is too busy: the guest never runs for 100 ms on end")


def test_killed_at_random_times(vcan, tmp_path, capsys):
    """SIGKILL under load: what is there reads back in python-can and in the exporter, and at most 100 ms are missing."""
    can = pytest.importorskip("can")
    (name,) = vcan()
    generator, worst = random.Random(4), 0.0
    sender = subprocess.Popen([str(BUILD / "tests/can_source"), "rate", "100000", str(PER_MS), name])
    try:
        for attempt in range(KILLS):
            with Recording(tmp_path / f"k{attempt}", name) as recording:
                time.sleep(0.15 + 0.75 * generator.random())
                killed = calm_moment()
                recording.kill()
            messages = list(can.LogReader(recording.log))
            numbers = [int.from_bytes(message.data[:4], "little") for message in messages]
            ours = export_record.read(str(recording.log))  # the exporter's reader sees the same
            assert ours.data[:, :4].tobytes() == b"".join(bytes(message.data[:4]) for message in messages)
            # a busy machine's guest stands still, and the source then makes up for it: such a burst may be too much
            told = {after: lost for after, lost in places(recording.events("drop")).items() if 0 < after < len(numbers)}
            assert told == gaps([numbers[0] - 1, *numbers])
            missing = killed - messages[-1].timestamp
            worst = max(worst, missing)
            assert missing < 0.1, f"kill {attempt}"
            assert recording.events("header") and not recording.events("end")
    finally:
        sender.kill()
        sender.wait()
    with capsys.disabled():
        print(f"\n  {KILLS} kills: at most {1e3 * worst:.0f} ms missing")


@pytest.fixture
def small_disk(tmp_path):
    folder = tmp_path / "small"
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1M", "tmpfs", str(folder)], check=True)
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_full_disk(vcan, small_disk):
    """It stops with a clear word; the log reads back; what was had and not written is counted."""
    (name,) = vcan()
    with Recording(small_disk / "full", name) as recording:
        sender = subprocess.Popen([str(BUILD / "tests/can_source"), "rate", "20", str(PER_MS), name])
        printed = recording.wait(status=1)
        sender.kill()
        sender.wait()
    assert "No space left on device" in printed and "full.log" in printed
    numbers = counters(recording.log)[name][1].tolist()
    assert numbers == list(range(len(numbers))) and len(numbers) > 5000
    end = recording.end()
    assert end["reason"] == "disk full"
    at_end = recording.at_end(name)
    assert at_end["frames"] == len(numbers) and at_end["not_written"] > 0 and end["lost"] == at_end["not_written"]


# ---- interfaces -----------------------------------------------------------------------


def test_interface_down_and_up_and_gone_and_back(vcan, tmp_path):
    """The recording goes on by itself, and says when nothing could come."""
    (name,) = vcan()
    sent = 0
    with Recording(tmp_path / "link", name) as recording:
        sent += send("rate", 0.2, PER_MS, name)[name]
        time.sleep(0.1)
        ip("set", name, "down")
        time.sleep(0.3)
        ip("set", name, "up")
        time.sleep(0.3)
        sent += send("rate", 0.2, PER_MS, name)[name]
        time.sleep(0.1)
        ip("del", name)
        time.sleep(0.3)
        ip("add", "dev", name, "type", "vcan")
        ip("set", name, "up")
        time.sleep(0.5)
        sent += send("rate", 0.2, PER_MS, name)[name]
        time.sleep(0.1)
        recording.stop()
    assert len(read_lines(recording.log)) == sent == recording.at_end(name)["frames"]
    states = [(event["state"], event["after"]) for event in recording.events("link")]
    assert states == [("down", 1800), ("up", 1800), ("gone", 3600), ("down", 3600), ("back", 3600), ("up", 3600)] or states == [
        ("down", 1800), ("up", 1800), ("gone", 3600), ("back", 3600), ("up", 3600)]  # fmt: skip


def test_interface_that_is_down_at_the_start(vcan, tmp_path):
    (name,) = vcan()
    ip("set", name, "down")
    with Recording(tmp_path / "down", name) as recording:
        time.sleep(0.2)
        ip("set", name, "up")
        time.sleep(0.1)
        sent = send("rate", 0.1, PER_MS, name)[name]
        time.sleep(0.1)
        printed = recording.stop()
    assert f"{name} is down" in printed
    assert len(read_lines(recording.log)) == sent


# ---- errors on the bus ----------------------------------------------------------------


def test_error_frames_of_a_real_socket(vcan, tmp_path):
    """Error frames between data frames: each in its place, none in the log, states as they follow."""
    (name,) = vcan()
    generator, states, frames, expected, places = random.Random(5), ["unknown"], 0, [], []
    kinds = {"warning": (0x4, b"\0\x08\0\0\0\0\x60\0"), "passive": (0x4, b"\0\x10\0\0\0\0\0\x80"),
             "off": (0x40, bytes(8)), "restarted": (0x100, bytes(8)), "active": (0x4, b"\0\x40\0\0\0\0\0\0")}  # fmt: skip
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as bus, Recording(tmp_path / "e", name) as recording:
        bus.bind((name,))
        for _ in range(1000):
            for _ in range(generator.randrange(4)):
                bus.send(struct.pack("=IB3x8s", 0x123, 4, frames.to_bytes(8, "little")))
                frames += 1
            state = generator.choice(list(kinds))
            identifier, data = kinds[state]
            bus.send(struct.pack("=IB3x8s", identifier | 1 << 29, 8, data))
            places.append(frames)
            if state != states[-1]:
                expected.append((state, frames))
                states.append(state)
            time.sleep(0.0005)
        time.sleep(0.1)
        recording.stop()
    assert [one["after"] for one in recording.events("error") for _ in range(one["count"])] == places
    assert [(one["state"], one["after"]) for one in recording.events("bus_state")] == expected
    assert len(read_lines(recording.log)) == frames


@pytest.fixture
def serial_adapter():
    """A CAN driver with states of its own: slcan, whose adapter is a pseudo terminal that the test plays."""
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    try:
        fcntl.ioctl(theirs, termios.TIOCSETD, struct.pack("i", 17))  # N_SLCAN
    except OSError:
        pytest.skip("this kernel has no slcan")
    name = fcntl.ioctl(theirs, 0x8910, bytes(40)).split(b"\0")[0].decode()  # SIOCGIFNAME
    subprocess.run(["ip", "link", "set", name, "up"], check=True)
    yield name, ours
    os.close(theirs)
    os.close(ours)


def test_states_of_a_driver_and_bus_off_stays_off(serial_adapter, tmp_path):
    """The driver's own error frames; after bus-off nothing is restarted, and the last state is in the record."""
    name, adapter = serial_adapter
    with Recording(tmp_path / "s", name) as recording:
        for message in (b"t1232AABB\r", b"sw096000\r", b"t1232AACC\r", b"sp000128\r", b"sb256256\r"):
            os.write(adapter, message)
            time.sleep(0.1)
        time.sleep(2.2)
        recording.stop()
    assert [line[2:] for line in read_lines(recording.log)] == [("123", "AABB"), ("123", "AACC")]
    states = [(one["state"], one["after"], one["by"]) for one in recording.events("bus_state")]
    assert states == [("warning", 1, "error_frame"), ("passive", 2, "error_frame"), ("off", 2, "error_frame")]
    assert recording.at_end(name)["state"] == "off"
    shown = subprocess.run(["ip", "-details", "link", "show", name], check=True, capture_output=True, text=True).stdout
    assert "BUS-OFF" in shown


# ---- usage ----------------------------------------------------------------------------


def complaint(*arguments, status=2):
    lines = run("talus-acquire", *arguments, status=status).stderr.splitlines()
    assert len(lines) == 1
    return lines[0]


def test_no_such_interface(vcan, tmp_path):
    (name,) = vcan()
    assert complaint("--out", tmp_path / "x", "nocan7") == (
        f"talus-acquire: nocan7: no such interface (CAN interfaces here: {name})"
    )
    assert complaint("--out", tmp_path / "x", "lo") == "talus-acquire: lo: no CAN interface, but one of another kind"
    assert not list(tmp_path.glob("x*"))


def test_no_permission_is_said_and_it_records_all_the_same(vcan):
    """As a user without rights: a note each, and no frame less."""
    (name,) = vcan()
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        Path(folder).chmod(0o777)
        user = ["setpriv", "--reuid", "65534", "--clear-groups", "--bounding-set=-all", "--inh-caps=-all"]
        command = [*user, str(BUILD / "bin/talus-acquire"), "--out", f"{folder}/user", "--duration", "2", name]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        time.sleep(0.7)
        sent = send("rate", 0.5, PER_MS, name)[name]
        _, printed = process.communicate(timeout=20)
        assert process.returncode == 0, printed
        assert "no real-time priority: Operation not permitted" in printed
        assert len(read_lines(f"{folder}/user.log")) == sent
