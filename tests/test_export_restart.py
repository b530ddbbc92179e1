"""A sender that begins anew in the middle of a record: the recording goes on behind it, with a mark, its own ticks and its own zeros."""

from dataclasses import replace

import bus_record
import numpy as np
import pytest
from bus_record import BEGIN_NS, BUS, frames_of, twin, write
from test_export import export, exported

JOINTS = ("knee", "ankle")


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """(the twin's recording, the frames that its bench would send)."""
    recording = twin(tmp_path_factory.mktemp("bench"), duration=8)
    return recording, frames_of(recording)


def restarted(recording, breaks, generator):
    """(frames, rows that were sent, [first row behind each restart], [knee's zero of each life]): silent for a while, then counters, zeros of
    the relative encoders and ticks begin somewhere else."""
    frames, rows, behind, zeros, begin = [], [], [], [], 0
    for end, silent in [*breaks, (len(recording), 0)]:
        with pytest.MonkeyPatch.context() as patch:
            zeros.append(int(generator.integers(65_536)))
            patch.setattr(bus_record, "ZEROS", {"knee": zeros[-1], "ankle": int(generator.integers(65_536))})
            part = recording[begin:end].copy()
            part["time_s"] += float(generator.uniform(0, 0.9e-3))
            life = frames_of(part, first=int(generator.integers(65_536)), seed=end)
        frames += life
        rows.append(part)
        behind.append(sum(map(len, rows)))
        begin = end + silent
    return sorted(frames, key=lambda frame: frame.t_ns), np.concatenate(rows), behind[:-1], zeros


@pytest.mark.parametrize("seed", range(3))
def test_a_restart_is_bridged_with_a_mark(bench, tmp_path, seed):
    recording, generator = bench[0], np.random.default_rng(seed)
    breaks = [(2000, int(generator.integers(3, 1000))), (4300, int(generator.integers(3, 1000))), (6100, 0)]
    frames, sent, behind, zeros = restarted(recording, breaks, generator)
    words = export(write(tmp_path / "rec.log", frames), tmp_path, status=1)
    got, told = exported(tmp_path)
    assert len(got) == len(sent) and told["left_out"] == 0  # no row was made up, and none is missing
    instants = got["time_s"] + (told["zero_ns"] - BEGIN_NS) / 1e9 - sent["time_s"]
    assert np.ptp(instants) < 20e-6 and 0 < instants[0] < 60e-6  # behind the ticks by the shortest delay
    for joint in JOINTS:
        step = 2 * np.pi / BUS[joint]["motor"]["counts_per_turn"]
        assert got[f"{joint}_motor_rad"] == pytest.approx(sent[f"{joint}_motor_rad"], abs=7 * step)  # half a step of the absolute encoder
        assert got[f"{joint}_current_A"] == pytest.approx(sent[f"{joint}_current_A"], abs=0.00027)
    assert [mark["sample"] for mark in told["restarts"]] == behind
    for mark in told["restarts"]:
        assert mark["time_s"] == pytest.approx(got["time_s"][mark["sample"] - 1:mark["sample"] + 1], abs=2e-7)
    knee = told["encoders"]["knee"]
    found = [zero["zero_count"] for zero in (knee, *knee["behind_restarts"])]
    assert [(a - b + 32_768) % 65_536 - 32_768 for a, b in zip(found, zeros, strict=True)] == pytest.approx([0] * 4, abs=7)
    assert words.count("where the counter began anew") >= 2  # by each message that shows it
    assert f"the recording goes on behind it, with sample {behind[0]}\n" in words


def test_a_restart_that_one_message_does_not_show(bench, tmp_path):
    """The ankle's counter happens to go on where it stopped: then it keeps its longer life, and nothing is mixed up."""
    frames = [replace(f, data=(f.number - 70_000).to_bytes(2, "little") + f.data[2:])
              if f.name == "KneeState" and f.number >= 70_000 else f for f in bench[1]]  # fmt: skip
    export(write(tmp_path / "rec.log", frames), tmp_path, status=1)
    got, told = exported(tmp_path)
    assert len(got) == 5000 and told["restarts"] == []
    assert [(m["message"], m["left_out"]) for m in told["messages"] if m["left_out"]] == [("KneeState", 3000)]
    assert got["knee_motor_rad"] == pytest.approx(bench[0]["knee_motor_rad"][:5000], abs=0.003)


def test_frames_left_from_before_are_no_life(bench, tmp_path):
    """What an adapter still held, in the middle of a record: left out and named; ticks and rows stay the bench's."""
    recording, frames = bench
    state = next(i for i, frame in enumerate(frames) if frame.name == "KneeState" and frame.number == 68_000)
    left = [replace(frames[state], t_ns=frames[state].t_ns + 1000 * k, data=(20_000 + k).to_bytes(2, "little") + frames[state].data[2:])
            for k in range(6)]  # fmt: skip
    words = export(write(tmp_path / "rec.log", [*frames[:state], *left, *frames[state:]]), tmp_path, status=1)
    got, told = exported(tmp_path)
    assert "KneeState on can0: 2 frames where the counter began anew" in words and told["restarts"] == []
    assert "KneeState on can0: 6 frames left out" in words
    assert len(got) == len(recording) and np.ptp(got["time_s"] - recording["time_s"]) < 20e-6
    assert got["knee_motor_rad"] == pytest.approx(recording["knee_motor_rad"], abs=0.003)


def test_a_restart_without_an_absolute_encoder_ends_the_angle(bench, tmp_path):
    """Nothing says where the relative one is behind it: the longest life alone."""
    (tmp_path / "x.dbc").write_text(bus_record.DBC.read_text().replace('BA_ "Channel" SG_ 513 JointCount "knee_joint_rad";\n', ""))
    frames, _, _, _ = restarted(bench[0], [(5000, 500)], np.random.default_rng(1))
    export(write(tmp_path / "rec.log", frames), tmp_path, status=1, dbc=tmp_path / "x.dbc")
    got, told = exported(tmp_path)
    assert len(got) == 5000 and told["encoders"]["knee"] is None and told["restarts"] == []
