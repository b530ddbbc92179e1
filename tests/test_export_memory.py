"""The export of what does not fit into memory: its parts against the same on whole arrays, and its peak."""

import gc
import gzip
import json
import os
import random
import resource
import subprocess
import sys
import time

import numpy as np
import pytest
from bus_record import BEGIN_NS, DBC, MODEL, frames_of, twin, write_long
from export_parts import follow
from support import many, run
from talus.acquire_export import command, spool
from talus.acquire_export.clock import support_line
from talus.acquire_export.encoders import PlaceMeans
from talus.acquire_export.ranks import quantiles, ranked
from talus.acquire_export.window import WIDTH

MOST_MB = 100
MB_EACH = 0.971  # ten seconds of the leg's bus


@pytest.fixture
def store():
    store = spool.Store(None)
    yield store
    store.close()


# ---- parts --------------------------------------------------------------------------


def test_a_spool_is_an_array(store):
    """Two of them written in turn, so that neither stands in one piece."""
    generator = np.random.default_rng(1)
    spools = [store.spool([("x", "i8"), ("y", "f8")]) for _ in range(2)]
    whole = [np.cumsum(generator.integers(0, 4, 300_000)), np.cumsum(generator.integers(1, 3, 300_000))]
    for first in range(0, 300_000, 1000):
        for own, x in zip(spools, whole, strict=True):
            own.append_columns(x[first:first + 1000], np.sin(x[first:first + 1000]))
    for own, x in zip(spools, whole, strict=True):
        assert len(own) == len(x) and (np.concatenate([rows["x"] for rows in own.chunks(7777)]) == x).all()
        indices = generator.integers(0, len(x), 500)
        assert (own.take(indices)["x"] == x[indices]).all() and len(own.take(indices[:0])) == 0
        for value in generator.integers(x[0] - 3, x[-1] + 3, 50).tolist():
            for side in ("left", "right"):
                assert own.search("x", value, side) == np.searchsorted(x, value, side)


@pytest.mark.parametrize("count", [3, 200, 20_000])
def test_lines_between_rows_are_numpys(store, count):
    generator = np.random.default_rng(2)
    x = np.cumsum(generator.exponential(1.0, 400_000))
    own = store.spool([("x", "f8"), ("y", "f8")])
    own.append_columns(x, np.cos(x))
    wanted = np.sort(generator.uniform(-50, x[-1] + 50, count))
    assert (spool.interpolate(own, "x", "y", wanted) == np.interp(wanted, x, np.cos(x))).all()


@pytest.mark.parametrize("values", [
    np.random.default_rng(3).standard_cauchy(700_000), np.zeros(300_000), np.arange(500_000) % 3,
    np.append(np.full(400_000, 10**6), [10**17, -10**17]), np.arange(11.0),
], ids=["heavy tails", "one value", "three values", "two far away", "few"])  # fmt: skip
def test_order_statistics_are_numpys(values):
    def chunks():
        return iter(np.array_split(values, 23))

    for rank in (0, 1, len(values) // 2, len(values) - 1):
        assert ranked(chunks, rank) == np.sort(values)[rank]
    shares = (0.0, 0.1, 0.5, 0.999, 1.0)
    assert quantiles(chunks, shares) == pytest.approx(list(np.quantile(values.astype(float), shares)), rel=1e-15)
    assert quantiles(lambda: iter([]), shares) == []


def test_the_line_below_points_lies_on_two_and_below_all():
    generator = np.random.default_rng(4)
    for count in (2, 3, 70, 3000):
        x = np.sort(generator.choice(10**6, count, replace=False)).astype(float)
        y = generator.exponential(1.0, count) + 1e-6 * x
        level, slope = support_line(x, y)
        above = y - level - slope * x
        assert above.min() > -1e-9 and (above < 1e-9).sum() == 2


def test_each_place_counts_once(store):
    generator = np.random.default_rng(5)
    places, error = generator.integers(-3000, 3000, 200_000) // generator.integers(1, 9, 200_000), generator.standard_normal(200_000)
    means = PlaceMeans(store)
    for first in range(0, len(places), 999):
        means.take(places[first:first + 999], error[first:first + 999])
    expected = np.mean([error[places == place].mean() for place in np.unique(places)])
    assert means.result() == pytest.approx(expected, rel=1e-9)


def random_frames(generator):
    """Counters as a bus gives them, with everything that may happen; (counter, time_ns, content)."""
    counter, out = generator.randrange(1 << 16), []
    for _ in range(generator.choice((5, 300, 3000))):
        counter += 1
        kind = generator.random()
        if kind < 0.01:
            counter += generator.choice((1, 2, 40, 3000))
        elif kind < 0.012:
            counter = generator.randrange(1 << 16)
        elif kind < 0.03 and out:
            out.append(out[-generator.randint(1, min(len(out), 20))])
        out.append((counter % 65536, 10**6 * len(out), generator.randrange(2)))
        if kind > 0.98 and len(out) > 9:
            out.insert(-generator.randint(1, 8), out.pop())
    return out


@pytest.mark.parametrize("period_s", [0.0, pytest.param(0.001, marks=pytest.mark.long)])
def test_no_fault_depends_on_where_chunks_end(period_s):
    for seed in range(40):
        frames = random_frames(random.Random(seed))
        counter = np.array([frame[0] for frame in frames])
        time_ns = 10**6 * np.arange(len(frames))
        found = [follow(counter, 16, time_ns, period_s, lambda a, b, frames=frames: frames[a][2] == frames[b][2], chunk)
                 for chunk in (len(frames), 997, 17, 1)]  # fmt: skip
        for other in found[1:]:
            assert other.faults == found[0].faults, seed
            assert list(other.kept) == list(found[0].kept) and list(other.number) == list(found[0].number)
            assert list(other.trusted) == list(found[0].trusted)
        assert (np.diff(found[0].number) > 0).all() or any(fault.kind == "restarted" for fault in found[0].faults)


def test_what_comes_later_than_the_window_is_wide():
    """A stretch that comes again is told from one that is only now complete, by what was kept long ago."""
    count = 2 * WIDTH
    counter = np.delete(np.arange(count), [5])
    late = np.append(counter, [4, 5, 7])  # known, missing, known
    found = follow(late, 32, np.arange(len(late)) * 10**6, 0.0, chunk=10_000)
    assert [(f.kind, f.number, f.count) for f in found.faults] == [("lost", 5, 1), ("repeated", 4, 1), ("stale", 5, 1), ("repeated", 7, 1)]
    assert (found.number == counter).all()


def test_a_gap_wider_than_the_window():
    counter = np.concatenate([np.arange(100), 10**9 + np.arange(100), [10**9 - 1]])
    found = follow(counter, 48, np.arange(len(counter)) * 10**6)
    assert [(f.kind, f.number, f.count) for f in found.faults] == [("lost", 100, 10**9 - 101), ("swapped", 10**9 - 1, 1)]
    assert list(found.number) == sorted(counter)


# ---- the peak -----------------------------------------------------------------------


# VmHWM and not ru_maxrss, which begins with what the parent had
MEASURED = """
import sys, time
from talus.acquire_export.command import main
status = main(sys.argv[1:])
print(status, next(int(line.split()[1]) / 1024 for line in open("/proc/self/status") if line.startswith("VmHWM")), time.process_time())
"""


def measured(folder, log, status):
    """(peak [MB], processor time [s], what was said) of an export in a process of its own."""
    arguments = ["--dbc", DBC, "--model", MODEL, "--quiet", "--out", folder / "out.csv", "--report", folder / "out.json", log]
    done = subprocess.run([sys.executable, "-c", MEASURED, *map(str, arguments)], capture_output=True, text=True, check=True)
    got, mb, seconds = done.stdout.split()
    assert int(got) == status, done.stderr[:1000]
    return float(mb), float(seconds), done.stderr


def children_s():
    """Processor time of all programs that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def peak_mb(folder, log, status):
    return measured(folder, log, status)[0]


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    return frames_of(twin(tmp_path_factory.mktemp("memory"), duration=10))


@pytest.mark.long
def test_memory_does_not_grow_with_the_record(tmp_path, frames):
    """A minute and four: 6 and 23 MB of text."""
    write_long(tmp_path / "short.log", frames, 6)
    write_long(tmp_path / "long.log", frames, 24)
    short, long = peak_mb(tmp_path, tmp_path / "short.log", 1), peak_mb(tmp_path, tmp_path / "long.log", 1)
    assert long < short + 15 and long < MOST_MB


@pytest.mark.long
def test_memory_of_a_large_record(tmp_path, frames):
    """A gigabyte of text, or TALUS_EXPORT_MB: memory stays, and processor time grows with the text and no faster.

    How fast that is, tools/bench/exporting.py shows.
    """
    log, turns = tmp_path / "large.log", round(int(os.environ.get("TALUS_EXPORT_MB", many(1000))) / MB_EACH)
    write_long(log, frames, turns // 10)
    _, tenth_s, _ = measured(tmp_path, log, 1)
    write_long(log, frames, turns)
    mb, seconds, _ = measured(tmp_path, log, 1)
    print(f"{log.stat().st_size / 1e6:.0f} MB: at most {mb:.1f} MB in memory, {seconds:.1f} s of processor time, {tenth_s:.1f} s for a tenth")
    began_s = children_s()
    run("talus-acquire", "info", log)
    info_s = children_s() - began_s
    print(f"talus-acquire info: {info_s:.1f} s of processor time")
    log.unlink()
    told = json.loads((tmp_path / "out.json").read_text())
    lost = sum(one["count"] for one in told["faults"] if one["kind"] == "lost")
    assert told["rows"] + told["left_out"] == 10_000 * turns and lost > turns
    (tmp_path / "out.csv").unlink()
    assert mb < MOST_MB and seconds < 25 * tenth_s and info_s < seconds / 5


@pytest.mark.long
@pytest.mark.alone
def test_a_gigabyte_of_nothing(tmp_path):
    """1 GiB of NUL in some megabytes of gzip: one line that says what it is not, in little memory; most of the time unpacks."""
    with gzip.open(tmp_path / "bomb.log.gz", "wb", compresslevel=1) as file:
        for _ in range(1024):
            file.write(bytes(1 << 20))
    packed = (tmp_path / "bomb.log.gz").stat().st_size
    assert packed < 6e6
    mb, seconds, said = measured(tmp_path, tmp_path / "bomb.log.gz", 2)
    unpacking_s = time_to_unpack(tmp_path / "bomb.log.gz")
    print(f"1 GiB of NUL in {packed / 1e6:.1f} MB: at most {mb:.1f} MB in memory, {seconds:.1f} s of processor time, {unpacking_s:.1f} s to unpack: {said}")
    assert mb < MOST_MB and seconds < 10 * unpacking_s
    assert len(said.splitlines()) == 1 and "bomb.log.gz" in said and not (tmp_path / "out.csv").exists()


def time_to_unpack(path):
    """Processor time to read it with Python's gzip [s]."""
    began_s = time.process_time()
    with gzip.open(path) as file:
        while file.read(1 << 20):
            pass
    return time.process_time() - began_s


def test_nothing_of_an_export_stays_in_the_process(tmp_path, frames):
    """Of a record with an events file, whose clocks are looked at."""
    write_long(tmp_path / "r.log", frames[:400], 1)
    events = [{"type": "header", "sources": [{"name": "can0", "stamps": "software"}]}]
    events += [{"type": "clock", "mono_ns": 5 * 10**9 + t, "real_ns": BEGIN_NS + t, "width_ns": 50} for t in (0, 10**9)]
    (tmp_path / "r.jsonl").write_text("".join(json.dumps(event) + "\n" for event in events))
    arguments = ["--dbc", DBC, "--model", MODEL, "--quiet", "--out", tmp_path / "out.csv", tmp_path / "r.log"]
    gc.collect()
    before = sum(isinstance(thing, spool.Store) for thing in gc.get_objects())
    assert command.main([str(argument) for argument in arguments]) in (0, 1)
    gc.collect()
    assert sum(isinstance(thing, spool.Store) for thing in gc.get_objects()) == before


def test_no_room_for_what_is_computed_on_the_way(tmp_path, frames):
    """A word and status 1; nothing is written, and nothing stays."""
    write_long(tmp_path / "r.log", frames, 6)
    command = [sys.executable, "-m", "talus.acquire_export", "--dbc", DBC, "--model", MODEL, "--out", tmp_path / "out.csv", tmp_path / "r.log"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, 1 << 20)))  # fmt: skip
    assert done.returncode == 1 and done.stderr == "talus-acquire-export: a temporary file cannot be written or read: File too large\n"
    assert [path.name for path in tmp_path.iterdir()] == ["r.log"]


@pytest.mark.parametrize("what", [
    pytest.param("doubled frames", marks=pytest.mark.long), "counters at random", "in pairs", "lines without anything"])
def test_memory_of_what_nobody_means(tmp_path, frames, what):
    generator, lines = random.Random(1), [frame.line for frame in frames]
    if what == "doubled frames":
        text = "".join(line * 8 for line in lines)
    elif what == "counters at random":
        lines = [f"{line[:line.index('#')]}#{generator.randrange(65536):04X}{line[line.index('#') + 5:]}" for line in lines]
        text = "".join(lines * 2)
    elif what == "in pairs":
        text = "".join(b + a for a, b in zip(lines[::2], lines[1::2], strict=False)) * 4
    else:
        text = "".join(lines) + "\n" * 20_000_000
    (tmp_path / "r.log").write_text(text)
    assert peak_mb(tmp_path, tmp_path / "r.log", 2 if what == "counters at random" else 0) < MOST_MB
