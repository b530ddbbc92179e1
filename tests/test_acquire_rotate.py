"""talus-acquire --rotate: a recording in several files, with no frame lost between them, and its readers."""

import contextlib
import errno
import gzip
import json
import subprocess
import time

import can
import pytest
from frame_source import FrameSource
from support import REPOSITORY, run
from talus.acquire_export import record

SECONDS = 5


def parts(source):
    """The files of a series, in order."""
    return [source.log, *sorted(source.log.parent.glob("r.[0-9][0-9][0-9].log"))]


def numbers(paths):
    return [int.from_bytes(message.data, "little") for path in paths for message in can.LogReader(str(path))]


def whole_numbers(paths):
    """Those of lines that stand whole: a disk that fails may have taken a part of the last."""
    lines = [line for path in paths for line in path.read_text().splitlines(keepends=True) if line.endswith("\n")]
    return [int.from_bytes(bytes.fromhex(line.split()[2].split("#")[1]), "little") for line in lines]


def send_for(source, seconds, count=0):
    end = time.monotonic() + seconds
    with contextlib.suppress(OSError):  # the recorder has gone
        while time.monotonic() < end and source.process.poll() is None:
            for _ in range(20):
                source.send(0x123, count.to_bytes(4, "little"))
                count += 1
            time.sleep(0.002)
    return count


def wait_for(condition):
    end = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


@pytest.fixture(scope="module", params=["20k", pytest.param("1s", marks=pytest.mark.long)])
def rotated(request, tmp_path_factory):
    """(source, how many frames were sent)."""
    with FrameSource(tmp_path_factory.mktemp("rotated") / "r", options=("--rotate", request.param)) as source:
        count = send_for(source, SECONDS)
    assert source.status == 0, source.printed
    return source, count


def test_no_frame_is_lost_between_files(rotated):
    source, count = rotated
    assert len(parts(source)) >= 3 and numbers(parts(source)) == list(range(count))
    texts = [path.read_text() for path in parts(source)]
    assert all(text.endswith("\n") for text in texts if text) and all(texts[:-1])  # the last may have been begun after the last frame
    begun = source.events("file")
    assert [event["name"] for event in begun] == [path.name for path in parts(source)[1:]] and all(event["begun"] for event in begun)
    (bench,) = source.events("end")[0]["sources"]
    assert bench["frames"] == bench["synced"] == count and bench["unexplained"] == 0


def test_a_series_is_read_from_its_first_file(rotated, tmp_path):
    """Compressed behind the recorder's back, too."""
    source, count = rotated
    for k, path in enumerate(parts(source)):
        if k % 2:
            (tmp_path / f"{path.name}.gz").write_bytes(gzip.compress(path.read_bytes()))
        else:
            (tmp_path / path.name).write_bytes(path.read_bytes())
    run("talus-acquire", "info", tmp_path / "r.log", "--report", tmp_path / "info.json")
    told = json.loads((tmp_path / "info.json").read_text())
    assert told["frames"] == count and told["files"] == len(parts(source))
    ours = record.read(tmp_path / "r.log")
    assert [int.from_bytes(row[:4].tobytes(), "little") for row in ours.data] == list(range(count))
    assert list(ours.line) == list(range(1, count + 1))


def test_a_fault_is_named_by_its_own_file(rotated, tmp_path):
    source, _ = rotated
    for path in parts(source):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    lines = (tmp_path / "r.001.log").read_text().splitlines(keepends=True)
    (tmp_path / "r.001.log").write_text("".join([*lines[:2], "nonsense\n", *lines[2:]]))
    with pytest.raises(record.Refused, match=r"r\.001\.log:3: no line of candump's log format: 'nonsense'"):
        record.read(tmp_path / "r.log")


@pytest.mark.release
@pytest.mark.parametrize("call", [3, 4])
def test_a_disk_that_fails_between_files(tmp_path, monkeypatch, call):
    """The account holds: what the disk never confirmed is lost, in whichever file it stands."""
    library = tmp_path / "failing_disk.so"
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", library, REPOSITORY / "tests/failing_disk.c", "-ldl"], check=True)
    monkeypatch.setenv("LD_PRELOAD", str(library))
    monkeypatch.setenv("FAILING_SYNC", str(call))
    with FrameSource(tmp_path / "r", options=("--rotate", "20k")) as source:
        monkeypatch.delenv("LD_PRELOAD")
        send_for(source, SECONDS)
    assert source.status == 1 and "Input/output error; the recording ends here" in source.printed
    end = source.events("end")[0]
    (bench,) = end["sources"]
    assert bench["unexplained"] == 0 and bench["frames"] == bench["synced"] + bench["not_synced"]
    found = whole_numbers(parts(source))
    assert 0 < bench["synced"] <= len(found) and set(range(bench["synced"])) <= set(found)
    assert end["lost"] == bench["not_synced"] + bench["not_written"] > 0 and bench["read"] == bench["synced"] + end["lost"]


def test_a_next_file_that_cannot_be_begun(tmp_path):
    """The present one goes on, and the events file says so once."""
    with FrameSource(tmp_path / "r", options=("--rotate", "20k")) as source:
        wait_for(source.log.exists)  # it has looked for an earlier series
        (tmp_path / "r.001.log").mkdir()
        count = send_for(source, 2)
    assert source.status == 0 and numbers([source.log]) == list(range(count))
    (event,) = source.events("file")
    assert (event["begun"], event["errno"]) == (False, errno.EEXIST)


def test_an_earlier_series_is_not_taken_for_this_ones(tmp_path):
    for name in ("r.001.log", "r.002.log"):
        (tmp_path / name).write_text("(1700000000.000000) old 001#00\n")
    with FrameSource(tmp_path / "r") as source:
        source.process.wait(20)
        source.close()
    assert source.status == 2 and "r.001.log: is there already (--overwrite replaces it)" in source.printed
    assert sorted(path.name for path in tmp_path.iterdir()) == ["r.001.log", "r.002.log"]
    with FrameSource(tmp_path / "r", options=("--overwrite",)) as source:
        source.send(0x7, b"\7")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["r.jsonl", "r.log"]


# ---- compressed ---------------------------------------------------------------------


def packed(folder):
    return sorted(path.name for path in folder.glob("r*.log*"))


def test_full_files_are_compressed(tmp_path):
    """All but the last, with not a frame lost on the way, whoever reads them; and nothing is allocated while recording."""
    with FrameSource(tmp_path / "r", options=("--rotate", "20k", "--compress")) as source:
        count = send_for(source, SECONDS)
    assert source.status == 0, source.printed
    full = len(source.events("file"))
    names = [f"r.{k:03d}.log" if k else "r.log" for k in range(full + 1)]
    assert full >= 3 and packed(tmp_path) == sorted([*(f"{name}.gz" for name in names[:-1]), names[-1]])
    text = b"".join(gzip.decompress((tmp_path / f"{name}.gz").read_bytes()) for name in names[:-1]) + (tmp_path / names[-1]).read_bytes()
    (tmp_path / "all.log").write_bytes(text)
    assert numbers([tmp_path / "all.log"]) == list(range(count))
    run("talus-acquire", "info", tmp_path / "r.log", "--report", tmp_path / "info.json")
    told = json.loads((tmp_path / "info.json").read_text())
    assert told["frames"] == count and told["files"] == full + 1
    assert len(record.read(tmp_path / "r.log").line) == len(record.read(tmp_path / "r.log.gz").line) == count
    end = source.events("end")[0]
    assert end["sources"][0]["synced"] == count and end["loop"]["allocations"] in (0, None)


def test_a_file_that_cannot_be_compressed_stays(tmp_path):
    """Its place is taken: said once, and nothing is lost."""
    with FrameSource(tmp_path / "r", options=("--rotate", "20k", "--compress")) as source:
        wait_for(source.log.exists)
        (tmp_path / "r.001.log.gz").mkdir()
        count = send_for(source, 3)
    assert source.status == 0 and "note: 1 of " in source.printed and "not compressed: File exists" in source.printed
    (tmp_path / "r.001.log.gz").rmdir()
    assert (tmp_path / "r.log.gz").exists() and (tmp_path / "r.001.log").exists() and (tmp_path / "r.002.log.gz").exists()
    assert len(record.read(tmp_path / "r.log").line) == count and not list(tmp_path.glob("*.part"))


@pytest.mark.long
@pytest.mark.release
@pytest.mark.parametrize("call", [1, 2])
def test_a_disk_that_fails_under_the_compressed_file(tmp_path, monkeypatch, call):
    """What it did not confirm does not replace what it did."""
    library = tmp_path / "failing_disk.so"
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", library, REPOSITORY / "tests/failing_disk.c", "-ldl"], check=True)
    monkeypatch.setenv("LD_PRELOAD", str(library))
    monkeypatch.setenv("FAILING_SYNC", str(call))
    monkeypatch.setenv("FAILING_NAME", ".gz.part")
    with FrameSource(tmp_path / "r", options=("--rotate", "20k", "--compress")) as source:
        monkeypatch.delenv("LD_PRELOAD")
        count = send_for(source, SECONDS)
    assert source.status == 0 and "not compressed: Input/output error" in source.printed
    assert [(tmp_path / name).exists() for name in ("r.log.gz", "r.001.log.gz")] == [call != 1, call != 2]
    assert len(record.read(tmp_path / "r.log").line) == count


def test_compressed_files_of_an_earlier_series_are_in_the_way(tmp_path):
    for name in ("r.log.gz", "r.001.log.gz"):
        (tmp_path / name).write_bytes(gzip.compress(b"(1700000000.000000) old 001#00\n"))
    with FrameSource(tmp_path / "r") as source:
        source.process.wait(20)
        source.close()
    assert source.status == 2 and "r.log.gz: is there already (--overwrite replaces it)" in source.printed
    with FrameSource(tmp_path / "r", options=("--overwrite",)) as source:
        source.send(0x7, b"\7")
    assert packed(tmp_path) == ["r.log"]


def test_compress_goes_with_rotate(tmp_path):
    done = run("talus-acquire", "--out", tmp_path / "r", "--compress", "fd:a=0", status=2)
    assert "--compress goes with --rotate" in done.stderr and not list(tmp_path.iterdir())


@pytest.mark.parametrize("limit", ["", "5", "1k", "0.5s", "nan", "10Q", "-3M", "1e99G", "M"])
def test_limits_that_are_none(tmp_path, limit):
    done = run("talus-acquire", "--out", tmp_path / "r", "--rotate", limit, "fd:a=0", status=2)
    assert "--rotate: expected a size from 4k on" in done.stderr and not list(tmp_path.iterdir())
