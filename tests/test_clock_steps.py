"""One account of a clock that was set: what talus-acquire info tells, what the export joins, and records of one machine that follow each
other across steps."""

import json
import random
from dataclasses import replace

import numpy as np
import pytest
from bus_record import BEGIN_NS, frames_of, twin, write
from support import run
from talus.acquire_export import clock_model
from talus.acquire_export.clock_model import Clock, ClockModel
from test_export import export, exported

S = 10**9
MONO_NS = 5 * S  # the monotonic clock where realtime is BEGIN_NS
CUT = 4000  # the first row of the second record
STEPS = [(2.3 * S, 5 * S), (4.0 * S, -int(7.25 * S)), (6.1 * S, 800_000_000)]  # when, and by how much: within, between, within


def clock(t_ns, told=False):
    real_ns = BEGIN_NS + t_ns + sum(size for at, size in STEPS if t_ns >= at)
    return {"type": "clock", "mono_ns": MONO_NS + t_ns, "real_ns": real_ns, "width_ns": 400} | ({"set": True} if told else {})


def record(path, frames, first_ns, last_ns):
    """A record of the frames with the readings that the recorder takes: each second, at both ends, and when the clock was set."""
    at = [first_ns, *range(-(-first_ns // S) * S, last_ns, S), last_ns]
    told = [int(step) + 700_000 for step, _ in STEPS if first_ns < step < last_ns]
    lines = sorted([clock(t) for t in set(at)] + [clock(t, True) for t in told], key=lambda one: one["mono_ns"])
    path.with_suffix(".jsonl").write_text("".join(json.dumps(line) + "\n" for line in [*lines, {"type": "end"}]))
    return write(path, [replace(f, t_ns=clock(f.t_ns - BEGIN_NS)["real_ns"]) for f in frames])


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """(the twin's recording, the logs of its two halves)."""
    folder = tmp_path_factory.mktemp("two")
    recording = twin(folder, duration=8)
    frames, cut_ns = frames_of(recording), BEGIN_NS + round((recording["time_s"][CUT] + recording["time_s"][CUT - 1]) / 2 * S)
    halves = [f for f in frames if f.t_ns < cut_ns], [f for f in frames if f.t_ns >= cut_ns]
    return recording, [record(folder / "a.log", halves[0], 0, int(3.9999 * S)), record(folder / "b.log", halves[1], int(4.0001 * S), 8 * S)]


def instants_of(logs, folder):
    """(instants [ns] on the monotonic clock, [report]) of records that are exported one after the other."""
    parts, reports = [], []
    for log in logs:
        export(log, folder)
        got, told = exported(folder)
        parts.append(told["zero_ns"] + np.rint(got["time_s"] * S).astype(np.int64))
        reports.append(told)
    return np.concatenate(parts), reports


def info(log):
    done = run("talus-acquire", "info", log, "--report", log.with_suffix(".info"))
    return done.stdout, json.loads(log.with_suffix(".info").read_text())["events"]


def test_two_records_joined_across_steps_keep_one_base(two, tmp_path):
    """A step in each and one between them; the bar is 100 us on either side of each."""
    recording, logs = two
    joined, reports = instants_of(logs, tmp_path)
    true_ns = MONO_NS + np.rint(recording["time_s"] * S).astype(np.int64)
    assert len(joined) == len(recording) and np.abs(joined - true_ns).max() < 100_000
    assert np.abs(np.diff(joined) - S // 1000).max() < 20_000  # also from one record to the next
    assert [step["size_s"] for told in reports for step in told["clock_steps"]] == pytest.approx([5, 0.8], abs=1e-6)
    assert all(step["uncertain_s"] == 0 for told in reports for step in told["clock_steps"])


def test_the_same_without_a_look_for_steps(two, tmp_path, monkeypatch):
    """So the test above can fail."""
    recording, logs = two
    monkeypatch.setattr(clock_model, "is_step", lambda a, b: False)
    joined, reports = instants_of(logs, tmp_path)
    true_ns = MONO_NS + np.rint(recording["time_s"] * S).astype(np.int64)
    assert all(told["clock_steps"] == [] for told in reports)
    assert len(joined) != len(true_ns) or np.abs(joined - true_ns).max() > 100_000


def test_info_tells_the_steps_that_the_export_joins(two, tmp_path):
    recording, logs = two
    for log, (at_ns, size_ns) in zip(logs, (STEPS[0], STEPS[2]), strict=True):
        words, told = info(log)
        (step,) = told["steps"]
        assert step["size_s"] == pytest.approx(size_ns / S, abs=1e-9) and told["clock_steps"] == 1
        assert step["before_mono_ns"] <= MONO_NS + at_ns <= step["after_mono_ns"] <= step["before_mono_ns"] + S
        assert f"the clock was set forward by {size_ns / S:.6f} s between" in words
        export(log, tmp_path)
        (joined,) = exported(tmp_path)[1]["clock_steps"]
        zero_ns = exported(tmp_path)[1]["zero_ns"]
        assert joined["size_s"] == step["size_s"]
        assert [zero_ns + round(t * S) for t in joined["time_s"]] == [step["before_mono_ns"], step["after_mono_ns"]]


def readings(generator):
    """Clocks that drift, are set, take long to read, and now and then seem to run back."""
    mono, offset, out = 10 * S, generator.randrange(1 << 60), []
    for _ in range(generator.randrange(2, 60)):
        mono += generator.choice((1_000_000, S, S, S, 20 * S, -S))
        offset += generator.choice((0, 100, 19_000, 21_000, 500_000, 600_000, 640_000, -620_000, 5 * S, -S))
        out.append((max(mono, 1), max(mono, 1) + offset, generator.choice((0, 500, 30_000, 10**7))))
    return out


def test_info_and_export_find_the_same_steps(tmp_path):
    (tmp_path / "r.log").write_text("(1700000000.000000) can0 201#00\n")
    found = 0
    for seed in range(40):
        clocks = readings(random.Random(seed))
        lines = [{"type": "clock", "mono_ns": mono, "real_ns": real, "width_ns": width} for mono, real, width in clocks]
        (tmp_path / "r.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
        steps = ClockModel([Clock(*one) for one in clocks]).steps
        told = info(tmp_path / "r.log")[1]
        expected = [(step.before.mono_ns, step.after.mono_ns, step.size_ns / S) for step in steps]
        assert [(one["before_mono_ns"], one["after_mono_ns"], pytest.approx(one["size_s"], abs=1e-9)) for one in told["steps"]] == expected, seed
        assert told["clock_steps"] == len(steps) and told["largest_step_s"] == pytest.approx(max([step.size_ns for step in steps], key=abs, default=0) / S)
        found += len(steps)
    assert found > 5 * 40
