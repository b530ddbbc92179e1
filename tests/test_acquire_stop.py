"""The emergency stop where the kernel takes all of its frames, some, or none; a button that is pressed at the start. GPIO chip and CAN socket
are preloaded fakes; on a real kernel tests/rig does the same."""

import contextlib
import errno
import os
import signal
import struct
import subprocess
import time

import pytest
from frame_source import FrameSource
from rig.button import Button
from support import REPOSITORY
from uncured import BUTTON_NOT_READ, uncured

pytestmark = pytest.mark.release  # preloaded libraries, compiled here

ATTEMPTS = 200  # for a full queue, 0.1 ms apart
INTERFACE = "lo"  # there on any machine


@pytest.fixture(scope="module")
def libraries(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fakes")
    for name in ("rig/fake_gpio", "fake_can"):
        subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", folder / f"{name.split('/')[-1]}.so", REPOSITORY / f"tests/{name}.c"], check=True)
    return f"{folder}/fake_gpio.so:{folder}/fake_can.so"


@pytest.fixture
def button(tmp_path, libraries, monkeypatch):
    (tmp_path / "gpio").mkdir()
    button = Button(tmp_path / "gpio", libraries)
    for name, value in {**button.environment, "FAKE_CAN": str(tmp_path / "bus"), "FAKE_CAN_TAKES": "3", "FAKE_CAN_FAILS": "0"}.items():
        if name != "LD_PRELOAD":
            monkeypatch.setenv(name, value)
    yield button
    os.close(button.fifo)


@contextlib.contextmanager
def recording(button, out, *options, path=None):
    """talus-acquire with a button, and a source of frames."""
    os.environ["LD_PRELOAD"] = button.environment["LD_PRELOAD"]  # for the recorder alone: its fakes would be this process' own
    try:
        source = FrameSource(out, options=(*options, "--gpio-backend", "kernel", "--stop", INTERFACE), sources=("estop:button=fakechip:4",), path=path)
    finally:
        os.environ.pop("LD_PRELOAD")
    with source:
        yield source


def wait_for(path, words):
    until = time.monotonic() + 20
    while words not in (path.read_text() if path.exists() else ""):
        assert time.monotonic() < until, f"no {words} in {path}"
        time.sleep(0.02)


def end(source):
    source.process.send_signal(signal.SIGINT)
    source.process.wait(20)
    source.close()


@pytest.mark.parametrize(("takes", "failure", "words", "attempts"), [
    (3, 0, "button: emergency stop sent on lo, 3 of 3 frames\n", 3),
    (2, errno.ENOBUFS, "button: EMERGENCY STOP SENT ONLY IN PART on lo, 2 of 3 frames: No buffer space available\n", 2 + ATTEMPTS),
    (1, errno.ENETDOWN, "button: EMERGENCY STOP SENT ONLY IN PART on lo, 1 of 3 frames: Network is down\n", 3),
    (0, errno.ENETDOWN, "button: EMERGENCY STOP NOT SENT on lo: Network is down\n", 3),
])  # fmt: skip
def test_how_many_frames_of_a_stop_went_out(button, tmp_path, monkeypatch, takes, failure, words, attempts):
    """On the bus, in the record and on the terminal it is the same number, and why. Only a whole stop is a success."""
    monkeypatch.setenv("FAKE_CAN_TAKES", str(takes))
    monkeypatch.setenv("FAKE_CAN_FAILS", str(failure))
    with recording(button, tmp_path / "r") as source:
        wait_for(source.side, '"header"')
        button.press()
        wait_for(source.side, '"type":"stop"')
        time.sleep(0.3)
        end(source)
    assert source.printed.count(words) == 1
    (stop,) = source.events("stop")
    assert (stop["frames"], stop["sent"], stop["errno"], stop["attempts"]) == (takes, takes > 0, failure, attempts)
    on_bus = (tmp_path / "bus").read_bytes() if takes else b""
    assert len(on_bus) == 16 * takes and all(struct.unpack_from("=I", on_bus, 16 * k)[0] == 1 for k in range(takes))
    (counted,) = [one for one in source.events("end")[0]["sources"] if one["name"] == "button"]
    assert [counted[key] for key in ("stops", "stops_partial", "stops_failed")] == [1, int(0 < takes < 3), int(takes == 0)]
    said = f"of 1 emergency stops {int(takes == 0)} not sent, {int(0 < takes < 3)} sent only in part; {source.side} says which\n"
    assert (source.status, source.printed.endswith(said)) == ((0, False) if takes == 3 else (1, True))


def playing(folder):
    """Options that play a second."""
    rows = "".join(f"{k / 100},{k / 1e5},0\n" for k in range(100))
    (folder / "t.csv").write_text("time_s,knee_rad,ankle_rad\n" + rows)
    return "--play", folder / "t.csv", "--play-on", INTERFACE, "--limits", "knee.position=-1:1,knee.speed=9,ankle.position=-1:1,ankle.speed=9"


def test_a_button_pressed_before_the_start_lets_nobody_play(button, tmp_path):
    """No record, no frame on the bus; without a trajectory it is said and recorded."""
    button.level(0)
    with recording(button, tmp_path / "p", *playing(tmp_path)) as source:
        source.process.wait(20)
        source.close()
    assert source.status == 1 and source.printed.endswith("button: the emergency stop is pressed: nothing is played\n")
    assert not source.log.exists() and not (tmp_path / "bus").exists()
    with recording(button, tmp_path / "r") as source:
        wait_for(source.side, '"header"')
        end(source)
    assert source.status == 0 and "button: the emergency stop is pressed\n" in source.printed
    assert [one["pressed"] for one in source.events("header")[0]["sources"] if one["name"] == "button"] == [True]


def test_a_button_that_nobody_reads_at_the_start_does(button, tmp_path):
    """What the test above is judged by: without the look at the level the trajectory is played, though the button is pressed."""
    button.level(0)
    with recording(button, tmp_path / "p", *playing(tmp_path), path=uncured(tmp_path / "uncured", BUTTON_NOT_READ)) as source:
        source.process.wait(20)
        source.close()
    assert source.status == 0 and source.events("play")[0]["sent"] == 100 and (tmp_path / "bus").exists()
