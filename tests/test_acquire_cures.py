"""What was once lost without a word, with the cure and without it in one run: the same is done to the whole program and to one whose cure
is taken out. The second loses and says nothing; so the first is judged by a test that can fail. What needs interfaces is in
tests/rig/test_interface_cures.py."""

import contextlib
import itertools
import subprocess
import time

import pytest
from frame_source import FrameSource
from support import REPOSITORY
from uncured import EVENT_LEFT_OUT, EVENTS_HELD_UP, LAST_STAMP_WAITS, LAST_STAMP_WAITS_TOLD, SYNC_IGNORED, uncured

pytestmark = pytest.mark.release  # compiled here, not from the build

START_NS = 1_700_000_000 * 10**9


@pytest.fixture(params=["cured", "uncured"])
def program_of(request, tmp_path):
    """(the program or None for the whole one, is it cured) for what would be taken out."""
    return lambda changes: (None, True) if request.param == "cured" else (uncured(tmp_path / "uncured", changes), False)


def silent(source):
    return source.status == 0 and "nothing lost" in source.printed and source.events("end")[0]["lost"] == 0


def test_a_disk_that_fails_behind_the_write(tmp_path, monkeypatch, program_of):
    path, cured = program_of(SYNC_IGNORED)
    library = tmp_path / "failing_disk.so"
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", library, REPOSITORY / "tests/failing_disk.c", "-ldl"], check=True)
    monkeypatch.setenv("LD_PRELOAD", str(library))
    monkeypatch.setenv("FAILING_SYNC", "2")
    with FrameSource(tmp_path / "r", path=path) as source:
        monkeypatch.delenv("LD_PRELOAD")
        sent = 0
        with contextlib.suppress(OSError):  # the recorder has gone
            while source.process.poll() is None and sent < 4_000:
                source.send(0x123, sent.to_bytes(4, "little"))
                sent += 1
                time.sleep(0.0005)
        source.close()
    there = source.log.read_bytes().count(b"#")
    assert there < sent
    if cured:
        assert source.status == 1 and source.events("end")[0]["lost"] > 0 and "Input/output error" in source.printed
    else:
        assert silent(source)


def record_with_the_last_stamp(folder, path):
    """600 frames of two sources, one of them with the last stamp there is; the recording, and how many are in its log."""
    with FrameSource(folder / "r", "a", "b", path=path) as source:
        for k in range(600):
            source.send(0x123, k.to_bytes(4, "little"), stamp_ns=2**63 - 1 if k == 300 else START_NS + k * 10**6, to="ab"[k % 2])
        source.close()
    return source, source.log.read_bytes().count(b"#")


def test_a_stamp_at_the_end_of_time(tmp_path, program_of):
    path, cured = program_of(LAST_STAMP_WAITS)
    source, there = record_with_the_last_stamp(tmp_path, path)
    assert there == 600 if cured else there < 600
    assert silent(source)


def test_an_account_that_does_not_balance(tmp_path):
    """What a fault of the program keeps from the log is unexplained: each frame, the source that had it, and the status."""
    source, there = record_with_the_last_stamp(tmp_path, uncured(tmp_path / "uncured", LAST_STAMP_WAITS_TOLD))
    end = source.events("end")[0]
    unexplained = {one["name"]: one["unexplained"] for one in end["sources"]}
    assert unexplained == {"a": 600 - there, "b": 0} and end["lost"] == 600 - there > 0
    assert source.status == 1 and f"UNEXPLAINED {600 - there}" in source.printed


@pytest.mark.parametrize("cured", [True, pytest.param(False, marks=pytest.mark.long)], ids=["cured", "uncured"])
def test_events_that_meet_a_full_ring(tmp_path, cured):
    """From the first second to 3.3 s the writer does not look: the next clocks wait for it, or are missing."""
    path = uncured(tmp_path / "uncured", EVENTS_HELD_UP if cured else (*EVENTS_HELD_UP, *EVENT_LEFT_OUT))
    with FrameSource(tmp_path / "r", options=("--duration", 4.5), path=path) as source:
        source.process.wait(30)
    assert silent(source)
    apart_s = [(b["mono_ns"] - a["mono_ns"]) / 1e9 for a, b in itertools.pairwise(source.events("clock"))]
    assert sum(s > 1.7 for s in apart_s) == (0 if cured else 1)
