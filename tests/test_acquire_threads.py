"""talus-acquire under the thread sanitizer: source, ring, writer, watch and the disk's thread, without a data race. One that is planted is
found."""

import os
import subprocess
import time

import pytest
from frame_source import ERROR, FrameSource
from support import BUILD, REPOSITORY
from talus.acquire_export import record
from uncured import DISK_RACE, RING_RACE, SANITIZED, uncured

pytestmark = [pytest.mark.long, pytest.mark.alone, pytest.mark.release]


@pytest.fixture(scope="module")
def sanitized():
    """The program, built with -fsanitize=thread in a folder of its own."""
    folder = BUILD / "tsan"
    make = ["make", "-s", "-C", REPOSITORY, f"BUILD={folder}", "SANITIZE=thread", "CFLAGS=-O1 -g", folder / "bin/talus-acquire"]
    subprocess.run(list(map(str, make)), check=True, env={**os.environ, "MAKEFLAGS": ""})
    return folder / "bin/talus-acquire"


def send_for(seconds, source):
    """Frames to a and b by turns, and error frames among them; how many frames."""
    begin, k = time.monotonic(), 0
    while time.monotonic() - begin < seconds:
        for _ in range(200):
            source.send(0x100, k.to_bytes(4, "little"), to="ab"[k % 2])
            k += 1
        source.send(ERROR | 0x8, bytes(8), to="a")
        time.sleep(0.05)
    return k


@pytest.mark.parametrize("options", [("--no-realtime",), ("--no-realtime", "--duration", "60"),
                                     ("--no-realtime", "--rotate", "20k", "--compress")], ids=["closed", "a minute", "in files"])  # fmt: skip
def test_no_data_race(tmp_path, sanitized, monkeypatch, options):
    monkeypatch.setenv("TSAN_OPTIONS", "exitcode=66")
    with FrameSource(tmp_path / "r", "a", "b", options=options, path=sanitized) as source:
        k = send_for(50 if "60" in options else 4, source)
    assert source.status == 0, source.printed
    assert "ThreadSanitizer" not in source.printed and len(record.read(source.log).line) == k


@pytest.mark.parametrize("race", [RING_RACE, DISK_RACE], ids=["ring", "disk"])
def test_a_planted_race_is_found(tmp_path, sanitized, monkeypatch, race):
    monkeypatch.setenv("TSAN_OPTIONS", "exitcode=66")
    path = uncured(tmp_path / "racing", race, sanitized.parents[1], SANITIZED)
    with FrameSource(tmp_path / "r", "a", "b", options=("--no-realtime",), path=path) as source:
        send_for(4, source)
    assert source.status == 66 and "WARNING: ThreadSanitizer: data race" in source.printed
