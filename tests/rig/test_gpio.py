"""Edges, the emergency stop and pulses, on a simulated chip of a real kernel, through every back end."""

import os
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest
from recording import Recording, hold_up, read_lines
from support import BUILD

pytestmark = [pytest.mark.rig, pytest.mark.release]

CONFIG = Path("/sys/kernel/config/gpio-sim/talus")
PROGRAMS = {
    "kernel": BUILD / "bin/talus-acquire",
    "libgpiod1": BUILD / "bin/talus-acquire",
    "libgpiod2": BUILD / "gpiod2/bin/talus-acquire",
}


class Chip:
    """Eight lines of gpio-sim; line 3 has a name."""

    def __init__(self):
        bank = CONFIG / "bank0"
        (bank / "line3").mkdir(parents=True)
        (bank / "num_lines").write_text("8")
        (bank / "line3/name").write_text("sync")
        (CONFIG / "live").write_text("1")
        self.name = (bank / "chip_name").read_text().strip()
        device = (CONFIG / "dev_name").read_text().strip()
        self.lines = Path(f"/sys/devices/platform/{device}/{self.name}")

    def drive(self, line, level):
        (self.lines / f"sim_gpio{line}/pull").write_text("pull-up" if level else "pull-down")

    def value(self, line):
        return int((self.lines / f"sim_gpio{line}/value").read_text())

    def remove(self):
        (CONFIG / "live").write_text("0")
        for folder in (CONFIG / "bank0/line3", CONFIG / "bank0", CONFIG):
            folder.rmdir()


@pytest.fixture(scope="module")
def chip():
    if not CONFIG.parent.is_dir():
        pytest.skip("this kernel has no gpio-sim: `make rig` brings one")
    chip = Chip()
    yield chip
    chip.remove()


@pytest.fixture(params=PROGRAMS)
def record(request, tmp_path):
    """Starts a recording through one of the back ends."""

    def start(*arguments):
        options = ("--gpio-backend", request.param, *arguments)
        return Recording(tmp_path / "r", *options, path=PROGRAMS[request.param])

    start.backend = request.param
    return start


def test_edges_are_all_there_in_order_at_their_times(chip, record):
    generator = random.Random(7)
    chip.drive(3, 0)
    driven = []
    with record("gpio:sync=" + chip.name + ":sync") as recording:
        time.sleep(0.3)
        for k in range(200):
            before = time.monotonic_ns()
            chip.drive(3, k % 2 == 0)
            driven.append((before, time.monotonic_ns()))
            time.sleep(0.01 * generator.random())
        time.sleep(0.3)
        recording.stop()
    edges = recording.events("edge")
    assert [edge["value"] for edge in edges] == [1, 0] * 100
    if record.backend != "libgpiod1":
        assert [edge["sequence"] for edge in edges] == list(range(1, 201))
    for edge, (before, after) in zip(edges, driven, strict=True):
        assert before <= edge["mono_ns"] <= after + 20_000_000
    assert recording.events("header")[0]["sources"][0]["backend"] == record.backend
    assert recording.end()["lost"] == 0 and recording.at_end("sync")["edges"] == 200


def test_one_kind_of_edge_only(chip, record):
    chip.drive(4, 1)
    with record(f"gpio:fall={chip.name}:4:falling") as recording:
        time.sleep(0.3)
        for level in (0, 1, 0, 1, 0):
            chip.drive(4, level)
            time.sleep(0.02)
        time.sleep(0.2)
        recording.stop()
    assert [edge["value"] for edge in recording.events("edge")] == [0, 0, 0]


def test_overflow_of_the_kernels_queue_is_told(chip, record):
    """The recorder is held up while more edges come than the kernel keeps."""
    if record.backend == "libgpiod1":
        pytest.skip("libgpiod 1 has no sequence numbers: what the kernel loses cannot be seen (docs)")
    chip.drive(5, 0)
    with record(f"gpio:fast={chip.name}:5") as recording:
        time.sleep(0.3)
        hold_up(recording.process)
        for k in range(1500):
            chip.drive(5, k % 2 == 0)
        recording.process.send_signal(signal.SIGCONT)
        time.sleep(0.5)
        printed = recording.stop(status=1)
    edges, gaps = recording.events("edge"), recording.events("edges_lost")
    lost = sum(gap["lost"] for gap in gaps)
    assert (len(edges), lost) == (1024, 1500 - 1024)
    assert f"{lost} lost" in printed
    numbers = [edge["sequence"] for edge in edges]
    holes = {i: b - a - 1 for i, (a, b) in enumerate(zip([0, *numbers], numbers, strict=False)) if b - a > 1}
    assert {gap["after"]: gap["lost"] for gap in gaps} == holes


def test_emergency_edge_sends_the_stop_frame(chip, record, vcan):
    """Recorded as an edge, answered on the bus, and the answer is in the same record."""
    (name,) = vcan()
    chip.drive(6, 1)
    with record("--stop", name, f"estop:button={chip.name}:6", name) as recording:
        time.sleep(0.3)
        chip.drive(6, 0)
        time.sleep(0.3)
        recording.stop()
    (edge,), (stop,) = recording.events("edge"), recording.events("stop")
    assert edge["value"] == 0 and stop["sent"] and stop["mono_ns"] > edge["mono_ns"]
    assert [(line[2], line[3][4:6]) for line in read_lines(recording.log)] == [("001", "01")] * 3
    chip.drive(6, 1)


def test_a_stop_that_cannot_be_sent_is_a_failure(chip, record, vcan):
    (name,) = vcan()
    chip.drive(6, 1)
    with record("--stop", f"{name}:123#DEAD", f"estop:button={chip.name}:6") as recording:
        time.sleep(0.3)
        subprocess.run(["ip", "link", "set", name, "down"], check=True)
        chip.drive(6, 0)
        time.sleep(0.3)
        printed = recording.stop(status=1)
    (stop,) = recording.events("stop")
    assert not stop["sent"] and stop["errno"] and recording.at_end("button")["stops_failed"] == 1
    assert "of 1 emergency stops 1 not sent, 0 sent only in part" in printed
    chip.drive(6, 1)


@pytest.fixture
def play(tmp_path):
    """Options that play ten seconds."""
    rows = "".join(f"{k / 100},{k / 1e5},0\n" for k in range(1000))
    (tmp_path / "t.csv").write_text("time_s,knee_rad,ankle_rad\n" + rows)
    limits = "knee.position=-1:1,knee.speed=9,ankle.position=-1:1,ankle.speed=9"
    return "--play", tmp_path / "t.csv", "--play-latest", 60, "--limits", limits


def test_a_button_that_rises(chip, record, vcan):
    """Its level is read as the other way round, and only its rise is an emergency."""
    (name,) = vcan()
    chip.drive(6, 0)
    with record("--stop", name, f"estop:button={chip.name}:6:rising", name) as recording:
        time.sleep(0.3)
        for level in (1, 0, 1, 0):
            chip.drive(6, level)
            time.sleep(0.3)
        recording.stop()
    assert recording.events("header")[0]["sources"][0]["pressed"] is False
    assert [edge["value"] for edge in recording.events("edge")] == [1, 1]
    assert [stop["frames"] for stop in recording.events("stop")] == [3, 3]
    assert [line[2] for line in read_lines(recording.log)] == ["001"] * 6
    chip.drive(6, 1)


@pytest.mark.parametrize(("edges", "level", "words"), [
    ("falling", 0, "the emergency stop is pressed: nothing is played"),
    ("rising", 1, "the emergency stop is pressed: nothing is played"),
    ("both", 1, "whether the emergency stop is pressed cannot be read (with both edges it has no pressed level): nothing is played"),
])  # fmt: skip
def test_a_button_that_lets_nobody_play(chip, record, vcan, play, edges, level, words):
    (name,) = vcan()
    chip.drive(6, level)
    with record(*play, "--stop", name, f"estop:button={chip.name}:6:{edges}", name) as recording:
        assert recording.wait(status=1) == f"talus-acquire: button: {words}\n"
    assert not recording.log.exists()
    chip.drive(6, 1)


def test_an_emergency_edge_ends_the_playing(chip, record, vcan, play):
    """Behind the stop frame there is no set-point but one that was on its way, and the host no longer says follow."""
    (name,) = vcan()
    chip.drive(6, 1)
    with record(*play, "--stop", name, f"estop:button={chip.name}:6", name) as recording:
        time.sleep(2)
        chip.drive(6, 0)
        time.sleep(1)
        recording.stop()
    (told,) = recording.events("play")
    assert told["end"] == "stopped" and 0 < told["sent"] < 1000
    identifiers = [line[2] for line in read_lines(recording.log)]
    assert identifiers.count("001") == 3 and 50 < identifiers.count("101") <= told["sent"] + 1
    behind = identifiers[identifiers.index("001"):]
    assert behind.count("101") + behind.count("102") <= 1 and behind.count("010") <= 2
    chip.drive(6, 1)


def test_pulses_keep_to_their_grid(chip, record):
    with record(f"pulse:led={chip.name}:7:20:10") as recording:
        seen = {chip.value(7) for _ in range(200) if not time.sleep(0.005)}
        recording.stop()
    pulses = recording.events("pulse")
    assert seen == {0, 1} and chip.value(7) == 0
    assert [pulse["value"] for pulse in pulses] == [1, 0] * (len(pulses) // 2)
    rises = [pulse["mono_ns"] for pulse in pulses if pulse["value"]]
    elapsed = rises[-1] - rises[0]
    assert abs(elapsed / 50e6 - (len(rises) - 1)) < 0.9


@pytest.mark.parametrize(("source", "words"), [
    ("gpio:x=CHIP:99", "GPIO line CHIP:99: no such line: No such file or directory"),
    ("gpio:x=CHIP:nobody", "GPIO line CHIP:nobody: no such line"),
    ("gpio:x=gpiochip77:1", "GPIO line gpiochip77:1: the chip cannot be opened: No such file or directory"),
])  # fmt: skip
def test_lines_that_are_not_there(chip, record, tmp_path, source, words):
    command = [PROGRAMS[record.backend], "--gpio-backend", record.backend, "--out", tmp_path / "x", source.replace("CHIP", chip.name)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert words.replace("CHIP", chip.name).split(": No such")[0] in done.stderr
    assert not os.listdir(tmp_path)


def test_a_line_that_is_taken(chip, record, tmp_path):
    with record(f"gpio:one={chip.name}:2") as recording:
        time.sleep(0.2)
        command = [PROGRAMS[record.backend], "--gpio-backend", record.backend, "--out", tmp_path / "two", f"gpio:two={chip.name}:2"]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        recording.stop()
    assert done.returncode == 2 and "the line cannot be had: Device or resource busy" in done.stderr
