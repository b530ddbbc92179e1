"""talus-acquire under the thread sanitizer on a real SocketCAN and GPIO: source, ring, writer, watch, stop, player, the disk's thread
and the compressor, without a data race; one that is planted is found. In the QEMU guest: the sanitizer needs more addresses than UML gives a process."""

import os
import random
import subprocess
import time

import pytest
from recording import SOURCE, Recording, ip
from support import BUILD
from talus.acquire_export import record as export_record
from test_gpio import chip  # noqa: F401 - a fixture
from trajectory import LIMITS, write_trajectory
from uncured import SANITIZED, STOP_RACE, uncured

pytestmark = [pytest.mark.rig, pytest.mark.release]

SECONDS = int(os.environ.get("TALUS_RIG_SECONDS", "60"))
OPTIONS = ("--no-realtime", "--rotate", "50k", "--compress")


@pytest.fixture
def record(tmp_path, monkeypatch):
    """Starts a recording by the sanitized program, or one that is given; a data race makes its status 66, whatever else there was."""
    monkeypatch.setenv("TSAN_OPTIONS", "exitcode=66")
    whole = BUILD / "tsan/bin/talus-acquire"
    assert whole.exists(), "make tsan"
    return lambda *arguments, path=whole: Recording(tmp_path / "r", *OPTIONS, *arguments, path=path)


def finish(recording):
    printed = recording.stop(status=None)
    assert "ThreadSanitizer" not in printed and recording.process.returncode in (0, 1), printed
    assert all(source["unexplained"] == 0 for source in recording.end()["sources"])


def test_load_and_plugging(vcan, record):
    names, generator = vcan(2), random.Random(5)
    with record(*names) as recording:
        senders = [subprocess.Popen([SOURCE, way, str(SECONDS / 2), "1", name], stdout=subprocess.PIPE, text=True)
                   for way, name in zip(("rate", "plugged"), names, strict=True)]  # fmt: skip
        while senders[1].poll() is None:
            time.sleep(generator.random())
            ip("del", names[1])
            ip("add", "dev", names[1], "type", "vcan")
            ip("set", names[1], "up")
        sent = {name: int(sender.communicate()[0].split()[1]) for name, sender in zip(names, senders, strict=True)}
        time.sleep(1)
        finish(recording)
    counted = {}
    for name in names:
        at_end = recording.at_end(name)
        counted[name] = at_end["frames"] + at_end["lost_socket"] + at_end["lost_interface"]
        assert at_end["read"] == at_end["frames"] + at_end["errors"] + at_end["other_interfaces"]
    assert counted[names[0]] == sent[names[0]] > 100
    pulled = recording.at_end(names[1])
    assert pulled["not_known"] == 0 and 100 < counted[names[1]] <= sent[names[1]] <= counted[names[1]] + pulled["perhaps_lost"]


def test_stop_and_player(vcan, tmp_path, record, chip):  # noqa: F811
    """Played until the button is pressed; then pressed again and again, with the interface down and up."""
    (name,) = vcan()
    write_trajectory(tmp_path / "t.csv", rows=1000 * SECONDS)
    chip.drive(6, 1)
    play = ("--play", tmp_path / "t.csv", "--limits", LIMITS, "--play-latest", 600, "--duration", SECONDS)
    with record(*play, "--stop", name, f"estop:button={chip.name}:6", name) as recording:
        time.sleep(SECONDS / 4)
        for k in range(SECONDS // 4):
            chip.drive(6, 0)
            time.sleep(0.5)
            ip("set", name, "up" if k % 2 else "down")
            chip.drive(6, 1)
            time.sleep(0.5)
        finish(recording)
    (told,) = recording.events("play")
    stops = [stop["frames"] for stop in recording.events("stop")]
    assert told["end"] == "stopped" and told["sent"] > 0 and stops[0] == 3 and {0, 3} == set(stops)
    assert (export_record.read(str(recording.log)).identifier == 1).sum() == 3 * stops.count(3)


def test_a_planted_race_is_found(vcan, tmp_path, record, chip):  # noqa: F811
    """The button's thread tells the player's to end, and one of the two does it without an atomic."""
    (name,) = vcan()
    path = uncured(tmp_path / "racing", STOP_RACE, BUILD / "tsan", SANITIZED)
    write_trajectory(tmp_path / "t.csv", rows=5000)
    chip.drive(6, 1)
    play = ("--play", tmp_path / "t.csv", "--limits", LIMITS, "--play-latest", 600)
    with record(*play, "--stop", name, f"estop:button={chip.name}:6", name, path=path) as recording:
        time.sleep(1)
        chip.drive(6, 0)
        printed = recording.wait(status=66)
    assert "WARNING: ThreadSanitizer: data race" in printed and "stop_line" in printed
    chip.drive(6, 1)
