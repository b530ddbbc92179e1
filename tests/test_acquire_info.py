"""talus-acquire info against python-can's reading of the same record."""

import gzip
import json
import random
from collections import defaultdict

import can
import pytest
from support import run

START_S = 1_700_000_000


def made(count=3000, seed=1):
    generator, lines, t = random.Random(seed), [], 0
    for k in range(count):
        t += generator.randrange(1, 2000) * (500 if k == 1500 else 1) - 3000 * (k % 700 == 699)
        wide = generator.random() < 0.3
        identifier = f"{generator.randrange(4) + 0x18FF0000:08X}" if wide else f"{generator.randrange(5):03X}"
        data = "R" if generator.random() < 0.02 else generator.randbytes(generator.randrange(9)).hex()
        lines.append(f"({START_S + t // 10**6}.{t % 10**6:06d}) {generator.choice(('can0', 'can1'))} {identifier}#{data}\n")
    return "".join(lines)


def told(path, folder, status=0):
    done = run("talus-acquire", "info", path, "--report", folder / "info.json", status=status)
    return done.stdout, json.loads((folder / "info.json").read_text())


@pytest.mark.parametrize("compressed", [False, True])
def test_every_message_as_python_can_counts_it(tmp_path, compressed):
    text = made()
    (tmp_path / "r.log").write_text(text)
    expected = defaultdict(list)
    for message in can.LogReader(str(tmp_path / "r.log")):
        expected[message.channel, message.arbitration_id, message.is_extended_id].append(round(message.timestamp * 1e6))
    path = tmp_path / ("r.log.gz" if compressed else "r.log")
    if compressed:
        path.write_bytes(gzip.compress(text.encode()))
    _, found = told(path, tmp_path)
    assert found["frames"] == 3000 and found["no_frames"] == 0 and not found["cut"] and found["events"] is None
    assert len(found["messages"]) == len(expected)
    for one in found["messages"]:
        stamps = expected[one["interface"], one["identifier"], one["extended"]]
        steps = [b - a for a, b in zip(stamps, stamps[1:], strict=False)]
        assert one["frames"] == len(stamps)
        assert one["stamps_backwards"] == sum(step < 0 for step in steps)
        assert one["longest_silence_ns"] == 1000 * max(steps)
        assert one["longest_silence_at_ns"] == 1000 * stamps[steps.index(max(steps))]
        assert one["rate_hz"] == pytest.approx(1e6 * len(steps) / (stamps[-1] - stamps[0]), rel=1e-9)


def test_clocks_losses_and_the_end(tmp_path):
    (tmp_path / "r.log").write_text(made(100) + "(1700000000.0")
    clocks = [(k, START_S + k + 5 * (k > 6) - 0.25 * (k > 8)) for k in range(10)]
    events = [{"type": "clock", "mono_ns": k * 10**9, "real_ns": int(real * 1e9), "width_ns": 400} for k, real in clocks]
    events += [{"type": "drop", "source": "can0", "lost": 7}, {"type": "drop", "source": "can0", "lost": 5},
               {"type": "vanished", "lost": 2, "perhaps_lost": 4, "known": False}, {"type": "vanished", "lost": 0, "known": True},
               {"type": "edges_lost", "lost": 1}, {"type": "link"}, {"type": "stop", "sent": True, "frames": 3, "errno": 0},
               {"type": "stop", "sent": True, "frames": 2, "errno": 105}, {"type": "stop", "sent": False, "frames": 0, "errno": 100}, {"type": "end", "reason": "signal"}]  # fmt: skip
    (tmp_path / "r.jsonl").write_text("".join(json.dumps(event) + "\n" for event in events))
    words, found = told(tmp_path / "r.log", tmp_path)
    said = found["events"]
    assert found["cut"] and (said["lost"], said["drops"], said["links"], said["stops"], said["ended_by"]) == (15, 3, 1, 3, "signal")
    assert (said["stops_partial"], said["stops_failed"]) == (1, 1)
    assert (said["perhaps_lost"], said["not_known"]) == (4, 1) and "perhaps 4 more" in words
    assert (said["clocks"], said["clock_steps"], said["largest_step_s"]) == (10, 2, 5.0)
    assert "the last line is cut off" in words and "set 2 times, at most by 5.000000 s" in words and "ended by signal" in words
    (tmp_path / "r.jsonl").write_text(json.dumps(events[0]) + "\n")
    words, found = told(tmp_path / "r.log", tmp_path)
    assert "no end: the recorder was killed" in words and found["events"]["ended_by"] is None


def test_lines_that_are_none_are_counted(tmp_path):
    (tmp_path / "r.log").write_bytes(made(10).encode() + b"hello\n" + b"x" * (3 << 20) + b"\n" + b"\0" * 5000)
    words, found = told(tmp_path / "r.log", tmp_path)
    assert found["frames"] == 10 and found["no_frames"] >= 2 and not found["cut"]
    assert "lines are no frames, the first is line 11" in words


def test_what_is_no_record(tmp_path):
    assert "no.log: cannot be read" in run("talus-acquire", "info", tmp_path / "no.log", status=2).stderr
    assert "cannot be read" in run("talus-acquire", "info", tmp_path, status=2).stderr
    (tmp_path / "r.log").write_text("time_s,x\n1,2\n")
    assert "r.log:1: no line of candump's log format" in run("talus-acquire", "info", tmp_path / "r.log", status=2).stderr


def test_random_bytes_do_no_harm(tmp_path):
    generator = random.Random(7)
    text = made(60).encode()
    for _ in range(200):
        changed = bytearray(text)
        for _ in range(generator.randrange(1, 30)):
            changed[generator.randrange(len(changed))] = generator.randrange(256)
        (tmp_path / "r.log").write_bytes(changed)
        (tmp_path / "r.jsonl").write_bytes(generator.randbytes(300) + b'\n{"type":"clock","mono_ns":-9223372036854775808}\n[]\n5\n')
        run("talus-acquire", "info", tmp_path / "r.log")
