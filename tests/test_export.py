"""tools/talus/acquire_export: what is decoded is compared with cantools and python-can, what is found with what was put in."""

import contextlib
import gzip
import io
import json
import random
import re
import resource
import sys
import tracemalloc
from dataclasses import replace

import can
import cantools
import numpy as np
import pytest
from bus_record import BEGIN_NS, BUS, DATABASE, DBC, MODEL, Frame, frames_of, injected, twin, write
from export_parts import follow, tick_times
from support import REPOSITORY, run

sys.path.insert(0, str(REPOSITORY / "tools"))
from talus.acquire_export import command, record  # noqa: E402
from talus.acquire_export.layout import Database  # noqa: E402

FAULTS = ("lost", "repeated", "swapped")


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """(the twin's recording, the frames that its bench would send)."""
    recording = twin(tmp_path_factory.mktemp("bench"), duration=10)
    return recording, frames_of(recording)


def export(path, folder, *options, status=0, model=MODEL, dbc=DBC):
    """What the program says, run within this process: a new Python for each call would take most of the time."""
    arguments = ["--dbc", dbc, "--model", model, "--out", folder / "rec.csv", "--report", folder / "rec.json", path, *options]
    words = io.StringIO()
    with contextlib.redirect_stderr(words):
        got = command.main([str(argument) for argument in arguments])
    assert got == status, words.getvalue()
    return words.getvalue()


def exported(folder):
    return np.genfromtxt(folder / "rec.csv", delimiter=",", names=True), json.loads((folder / "rec.json").read_text())


def refused(path, folder, *options, status=2, **files):
    words = export(path, folder, *options, status=status, **files)
    assert len(words.splitlines()) == 1 and not (folder / "rec.csv").exists()
    return words


# ---- decoding ---------------------------------------------------------------------------

OTHER = """VERSION ""
BU_: Node
BO_ 100 Motorola: 8 Node
 SG_ Odd : 5|11@0- (0.25,-3) [0|0] "" Node
 SG_ Wide : 17|33@0+ (1,0) [0|0] "" Node
 SG_ One : 63|1@0+ (1,0) [0|0] "" Node
BO_ 101 Intel: 8 Node
 SG_ Odd : 3|13@1- (-0.5,7) [0|0] "" Node
 SG_ Wide : 16|47@1- (1e-3,0) [0|0] "" Node
BO_ 102 Floats: 12 Node
 SG_ Half : 0|32@1- (2,1) [0|0] "" Node
 SG_ Whole : 32|64@1- (1,0) [0|0] "" Node
BO_ 103 All: 8 Node
 SG_ All : 0|64@1+ (1,0) [0|0] "" Node
BO_ 104 AllSigned: 8 Node
 SG_ All : 7|64@0- (1,0) [0|0] "" Node
BO_ 2566848513 Extended: 64 Node
 SG_ Far : 443|21@1- (0.1,0) [0|0] "" Node
SIG_VALTYPE_ 102 Half : 1;
SIG_VALTYPE_ 102 Whole : 2;
"""


@pytest.mark.parametrize("text", [DBC.read_text(), OTHER], ids=["leg", "other"])
def test_every_field_is_what_cantools_decodes(tmp_path, text):
    path = tmp_path / "x.dbc"
    path.write_text(text)
    ours, theirs = Database.read(path), cantools.database.load_file(str(path))
    generator, compared = np.random.default_rng(1), 0
    assert len(ours.messages) == len(theirs.messages)
    for message in theirs.messages:
        mine = next(m for m in ours.messages.values() if m.name == message.name)
        data = generator.integers(0, 256, (200, 64), np.uint8)
        data[0], data[1] = 0, 255
        columns = {name: mine.decode(name, data) for name in mine.fields}
        for i, row in enumerate(data):
            expected = message.decode(row[:message.length].tobytes(), decode_choices=False)
            for name, value in expected.items():
                got = columns[name][i]
                assert got == float(value) or np.isnan(got) and np.isnan(value), (message.name, name, value, got)
                compared += 1
    assert compared >= 200 * sum(len(message.signals) for message in theirs.messages)


def test_a_multiplexed_channel_is_exported(bench, tmp_path):
    """A temperature that shares its bytes with another: every second frame has it."""
    text = DBC.read_text()
    text = text.replace('SG_ BusVoltage :', 'SG_ Part M : 47|1@1+ (1,0) [0|0] "" Vector__XXX\n SG_ BusVoltage m0 :')
    text = text.replace("SG_ BusCurrent : 32|16@", "SG_ BusCurrent : 32|15@")
    (tmp_path / "m.dbc").write_text(text)
    frames = [replace(f, data=f.data[:5] + bytes([f.data[5] & 0x7F | (f.number % 2) << 7])) if f.name == "Supply" else f for f in bench[1]]
    export(write(tmp_path / "rec.log", frames), tmp_path, dbc=tmp_path / "m.dbc")
    got, _ = exported(tmp_path)
    assert np.ptp(got["bus_V"]) == pytest.approx(0.06, abs=1e-3) and got["bus_V"].min() == pytest.approx(24, abs=1e-3)


def test_wide_counters_count(bench, tmp_path):
    """63 and 64 bits, near their end: nothing wraps that does not wrap on the bus."""
    for bits in (63, 64):
        number = (2**bits - 5 + np.arange(10, dtype=object)) % 2**bits
        raw = np.array([list(int(x).to_bytes(8, "little")) for x in number], np.uint8)
        text = f'VERSION ""\nBU_: N\nBO_ 1 M: 8 N\n SG_ Counter : 0|{bits}@1+ (1,0) [0|0] "" N\n'
        (tmp_path / "c.dbc").write_text(text)
        message = Database.read(tmp_path / "c.dbc").by_name("M")
        counted = message.counter.raw(raw).astype(np.int64) & (1 << message.counter_bits) - 1
        assert follow(counted, message.counter_bits, np.arange(10) * 10**6).faults == []


LINES = """(1700000000.000001) can0 201#0011223344556677
(1700000000.500) vcan12 7FF#
(1700000001.123456789) can0 18FF0201#AB
(1700000001.2) can0 123##3{}
(1700000001.300000) can0 201#R
(1700000001.300000) can0 202#R4
(1700000001.400000) can0 20000080#0004000000000000
(1700000001.500000) can0 00000001#01
(1700000001.600000) can0 055#01ff R
(1700000001.600001) can0 056#02FE T
""".format("0123456789ABCDEF" * 2)


def test_lines_are_what_python_can_reads(tmp_path):
    path = tmp_path / "x.log"
    path.write_text(LINES)
    ours = record.read(path)
    theirs = [m for m in can.LogReader(str(path)) if not (m.is_error_frame or m.is_remote_frame)]
    assert ours.remote == 2 and ours.errors == 1 and len(theirs) == len(ours.line) == 7
    assert list(ours.line) == [1, 2, 3, 4, 8, 9, 10]
    for i, message in enumerate(theirs):
        assert abs(ours.time_ns[i] / 1e9 - message.timestamp) < 1e-6
        assert ours.sources[ours.source[i]] == message.channel
        assert (ours.identifier[i] & 0x1FFFFFFF, bool(ours.identifier[i] >> 31)) == (message.arbitration_id, message.is_extended_id)
        assert bytes(ours.data[i, :ours.length[i]]) == bytes(message.data)


def test_random_frames_are_what_python_can_reads(tmp_path):
    generator, lines = random.Random(3), []
    for k in range(3000):
        wide = generator.random() < 0.3
        identifier = generator.randrange(1 << 29 if wide else 1 << 11)
        data = generator.randbytes(generator.randint(0, 8))
        name = generator.choice(("can0", "can1", "vcan100"))
        lines.append(f"({1700000000 + k}.{generator.randrange(10**6):06d}) {name} {identifier:0{8 if wide else 3}X}#{data.hex()}\n")
    path = tmp_path / "x.log"
    path.write_text("".join(lines))
    ours = record.read(path)
    for i, message in enumerate(can.LogReader(str(path))):
        assert bytes(ours.data[i, :ours.length[i]]) == bytes(message.data)
        assert ours.identifier[i] & 0x1FFFFFFF == message.arbitration_id and ours.line[i] == i + 1
        assert ours.sources[ours.source[i]] == message.channel
    assert i + 1 == len(ours.line) == 3000


# ---- the recording ------------------------------------------------------------------------


def test_export_is_the_twins_recording(bench, tmp_path):
    recording, frames = bench
    words = export(write(tmp_path / "rec.log", frames), tmp_path)
    got, told = exported(tmp_path)
    assert len(got) == len(recording) and told["complete"] and told["faults"] == []
    assert told["columns"][:5] == list(recording.dtype.names[1:]) and "samples in " in words
    instants = got["time_s"] + (told["zero_ns"] - BEGIN_NS) / 1e9 - recording["time_s"]
    assert np.ptp(instants) < 20e-6 and 39e-6 < instants.min() < 60e-6  # frames leave 40 us after their tick, or later
    for joint in ("knee", "ankle"):
        assert got[f"{joint}_motor_rad"] == pytest.approx(recording[f"{joint}_motor_rad"], abs=2 * np.pi / 16384)
        assert got[f"{joint}_current_A"] == pytest.approx(recording[f"{joint}_current_A"], abs=0.00026 + 1e-5)
    assert got["ankle_joint_rad"] == pytest.approx(recording["ankle_joint_rad"], abs=1e-6)
    assert np.ptp(got["bus_V"]) == pytest.approx(0.06, abs=1e-3) and got["knee_temp_C"][-1] == pytest.approx(25.99, abs=0.02)
    assert told["encoders"]["knee"]["zero_count"] == pytest.approx(60_001, abs=0.5)
    assert told["encoders"]["ankle"]["zero_count"] == pytest.approx(12_345, abs=0.5)


def test_every_program_reads_it(bench, tmp_path):
    export(write(tmp_path / "rec.log", bench[1]), tmp_path)
    run("talus-predict", "--model", MODEL, "--out", tmp_path / "p.csv", tmp_path / "rec.csv")
    assert (tmp_path / "p.csv").read_text().count("\n") == len(bench[0]) + 1


def test_an_even_grid_of_another_rate(bench, tmp_path):
    recording, frames = bench
    export(write(tmp_path / "rec.log", frames), tmp_path, "--rate", 250)
    got, _ = exported(tmp_path)
    assert np.diff(got["time_s"]) == pytest.approx(0.004, abs=1.1e-7) and len(got) == len(recording) // 4
    assert got["knee_motor_rad"] == pytest.approx(recording["knee_motor_rad"][::4], abs=0.01)


def test_compressed_in_and_out(bench, tmp_path):
    text = "".join(frame.line for frame in bench[1])
    (tmp_path / "rec.log.gz").write_bytes(gzip.compress(text.encode()))
    run("talus-acquire-export", "--dbc", DBC, "--model", MODEL, "--out", tmp_path / "rec.csv.gz", tmp_path / "rec.log.gz")
    assert len(np.genfromtxt(tmp_path / "rec.csv.gz", delimiter=",", names=True)) == len(bench[0])


def test_clocks_of_the_side_file(bench, tmp_path):
    """Stamps of a clock that is set forward by 2 ms in the middle come out even again."""
    recording, frames = bench
    shifted = [replace(f, t_ns=f.t_ns + 2_000_000 * (f.t_ns > BEGIN_NS + 5 * 10**9)) for f in frames]
    clocks = []
    for k in range(12):
        for late in (0, 1) if k == 5 else (0,):  # read just before and just after the clock was set
            t = k * 10**9 + late * 1000
            jump = 2_000_000 * (k > 5 or bool(late))
            clocks.append({"type": "clock", "mono_ns": 5 * 10**9 + t, "real_ns": BEGIN_NS + t + jump, "raw_ns": t, "width_ns": 50})
    path = write(tmp_path / "rec.log", shifted)
    (tmp_path / "rec.jsonl").write_text("".join(json.dumps(clock) + "\n" for clock in [*clocks, {"type": "new in 2030"}]))
    export(path, tmp_path)
    got, told = exported(tmp_path)
    assert told["clock"] == "CLOCK_MONOTONIC" and abs(told["zero_ns"] - 5 * 10**9) < 10**6
    assert np.ptp(got["time_s"] - (recording["time_s"] - recording["time_s"][0])) < 20e-6


def test_an_adapters_own_clock(bench, tmp_path):
    """Stamps of a clock that began at another time and runs 80 ppm fast."""
    recording, frames = bench
    path = write(tmp_path / "rec.log", [replace(f, t_ns=1000 + round((f.t_ns - BEGIN_NS) * (1 + 80e-6))) for f in frames])
    lines = [{"type": "header", "sources": [{"name": "can0", "kind": "can", "stamps": "hardware"}]}]
    for k in range(12):
        t = k * 10**9
        lines.append({"type": "clock", "mono_ns": 7 * 10**9 + t, "real_ns": BEGIN_NS + t})
        lines.append({"type": "hardware_clock", "source": "can0", "hw_ns": 1000 + round(t * (1 + 80e-6)), "real_ns": BEGIN_NS + t})
    lines.append({"type": "edge", "source": "sync", "value": 1, "mono_ns": 9 * 10**9, "sequence": 1})
    (tmp_path / "rec.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    export(path, tmp_path)
    got, told = exported(tmp_path)
    assert np.ptp(got["time_s"] - recording["time_s"]) < 20e-6
    assert told["clock"] == "CLOCK_MONOTONIC" and told["marks"][0]["time_s"] == pytest.approx(2 - recording["time_s"][0], abs=100e-6)
    (tmp_path / "rec.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines if line["type"] != "hardware_clock"))
    export(path, tmp_path)
    assert exported(tmp_path)[1]["clock"] == "the stamps' clock"  # nothing relates it to any other


def test_ticks_of_a_clock_that_drifts(bench):
    """Stamps that are late by 30 us on average, and now and then by 50 ms for a while."""
    generator = np.random.default_rng(4)
    tick = np.arange(120_000)
    true = tick * 1e6 * (1 + 30e-6) + 3e5 * np.sin(tick / 20_000)  # [ns]
    late = generator.exponential(30e3, len(tick)) + 20e3
    for begin in generator.integers(0, len(tick), 60):
        late[begin:begin + 50] += 50e6 - 1e6 * np.arange(len(late[begin:begin + 50]))
    stamp = 10**18 + np.rint(true + late).astype(np.int64)
    got, zero = tick_times(tick, stamp, 0.001)
    error = got + (zero - 10**18) - true
    assert 0 < error.min() and error.max() < 45e3 and abs(np.median(error) - 21e3) < 5e3


def test_ticks_of_a_sender_that_was_late_for_seconds():
    """On time for the first half of a minute, then late by up to 3 s for 20 s, then on time again: the clocks cannot
    have drifted so far, so the instants stay where they were."""
    generator = np.random.default_rng(5)
    tick = np.arange(60_000)
    true = tick * 1e6 * (1 - 40e-6)
    late = generator.exponential(30e3, len(tick)) + 20e3
    late[30_000:50_000] += 3e9 * np.sin(np.pi * np.arange(20_000) / 20_000) + 1e6
    got, zero = tick_times(tick, 10**18 + np.rint(true + late).astype(np.int64), 0.001)
    error = got + (zero - 10**18) - true
    on_time = np.append(error[:25_000], error[55_000:])
    assert on_time.min() > 0 and on_time.max() < 40e3
    assert np.abs(error).max() < 7e6 and (np.diff(got) > 0.999e6).all()


def test_zero_where_the_joint_rests_most_of_the_time(tmp_path):
    recording = twin(tmp_path, "--excitation", "ramps", duration=50)
    assert (np.diff(recording["knee_motor_rad"]) == 0).mean() > 0.4
    export(write(tmp_path / "rec.log", frames_of(recording)), tmp_path)
    for joint, zero in (("knee", 60_001), ("ankle", 12_345)):
        assert exported(tmp_path)[1]["encoders"][joint]["zero_count"] == pytest.approx(zero, abs=0.5)


def test_a_motor_encoder_without_an_absolute_one(bench, tmp_path):
    recording, frames = bench
    dbc = tmp_path / "x.dbc"
    dbc.write_text(DBC.read_text().replace('BA_ "Channel" SG_ 513 JointCount "knee_joint_rad";\n', ""))
    words = export(write(tmp_path / "rec.log", frames), tmp_path, dbc=dbc)
    assert "knee: no absolute encoder; knee_motor_rad is 0 at the first sample" in words
    got, _ = exported(tmp_path)
    knee = recording["knee_motor_rad"]
    assert got["knee_motor_rad"] == pytest.approx(knee - knee[0], abs=1e-5)


def test_channels_by_hand(bench, tmp_path):
    dbc = tmp_path / "x.dbc"
    dbc.write_text(re.sub(r'BA_ "Channel".*\n', "", DBC.read_text()))
    path = write(tmp_path / "rec.log", bench[1])
    assert "no signal has the attribute Channel" in refused(path, tmp_path, dbc=dbc)
    channels = [f"{joint}_{column}={joint.capitalize()}State.{signal}" for joint in ("knee", "ankle")
                for column, signal in (("motor_rad", "MotorCount"), ("joint_rad", "JointCount"), ("current_A", "Current"))]  # fmt: skip
    export(path, tmp_path, *(word for channel in channels for word in ("--channel", channel)), dbc=dbc)
    got, _ = exported(tmp_path)
    assert got["ankle_motor_rad"] == pytest.approx(bench[0]["ankle_motor_rad"], abs=2 * np.pi / 16384)


# ---- faults ---------------------------------------------------------------------------------


def found(told):
    return sorted((f["kind"], f["message"], f["counter"], f["count"], f["line"]) for f in told["faults"] if f["kind"] != "late")


@pytest.mark.parametrize("seed", range(4))
def test_injected_faults_are_found_and_none_invented(bench, tmp_path, seed):
    """Four times 300: each with its kind, counter, number of frames and line."""
    recording, frames = bench
    made, put_in = injected(frames, 300, seed)
    export(write(tmp_path / "rec.log", made), tmp_path, status=1)
    got, told = exported(tmp_path)
    assert found(told) == put_in
    lost = {name: set() for name in ("KneeState", "AnkleState")}
    for kind, name, counter, count, _ in put_in:
        if kind == "lost" and name in lost:
            lost[name].update((counter - 65_000) % 65_536 + i for i in range(count))
    gone = lost["KneeState"] | lost["AnkleState"]
    assert told["left_out"] == len(gone) and len(got) == len(recording) - len(gone)
    kept = np.delete(recording, sorted(gone))  # no row was made up, and none is out of its place
    assert got["knee_motor_rad"] == pytest.approx(kept["knee_motor_rad"], abs=2 * np.pi / 16384)
    assert got["ankle_current_A"] == pytest.approx(kept["ankle_current_A"], abs=0.00027)
    assert np.ptp(got["time_s"] - kept["time_s"]) < 20e-6


def test_payloads_exchanged_under_their_stamps(bench, tmp_path):
    """As a queue below the stamps would do it: the stamps still rise."""
    recording, frames = bench
    own = [i for i, frame in enumerate(frames) if frame.name == "AnkleState"]
    made, put_in = list(frames), []
    for k in range(50, len(own) - 50, 97):
        a, b = own[k], own[k + 1]
        made[a], made[b] = replace(frames[b], t_ns=frames[a].t_ns), replace(frames[a], t_ns=frames[b].t_ns)
        put_in.append(("swapped", "AnkleState", frames[a].number % 65536, 1, b + 1))
    export(write(tmp_path / "rec.log", made), tmp_path)
    got, told = exported(tmp_path)
    assert found(told) == sorted(put_in) and len(got) == len(recording)
    assert np.ptp(got["time_s"] - recording["time_s"]) < 20e-6


def test_what_the_words_say(bench, tmp_path):
    frames = [frame for frame in bench[1] if not (frame.name == "KneeState" and 70_000 <= frame.number < 70_003)]
    words = export(write(tmp_path / "rec.log", frames), tmp_path, status=1)
    line = next(i for i, frame in enumerate(frames) if frame.name == "KneeState" and frame.number == 70_003) + 1
    before = next(i for i, frame in enumerate(frames) if frame.name == "KneeState" and frame.number == 69_999) + 1
    assert f"KneeState on can0: 3 frames lost: counter 4464 and 2 more between lines {before} and {line}\n" in words
    assert "; 3 samples left out, where a frame was missing" in words


def test_late_frames(bench, tmp_path):
    late = [replace(f, t_ns=f.t_ns + 2_500_000) if f.name == "KneeState" and f.number in (68_000, 69_000) else f for f in bench[1]]
    words = export(write(tmp_path / "rec.log", sorted(late, key=lambda f: f.t_ns)), tmp_path)
    assert re.search(r"note: KneeState on can0: 2 frames out of order", words)
    assert re.search(r"note: KneeState on can0: 2 frames late by more than a period: line \d+; line \d+\n", words)


def test_contradiction_and_silence(bench, tmp_path):
    recording, frames = bench
    own = [i for i, frame in enumerate(frames) if frame.name == "KneeState"]
    twice = replace(frames[own[4000]], data=frames[own[4000]].data[:7] + b"\x55")
    made = [*frames[:own[4000] + 1], twice, *frames[own[4000] + 1:]]
    words = export(write(tmp_path / "rec.log", made), tmp_path, status=1)
    assert f"1 frame with a number that came before, but other content: line {own[4000] + 2}\n" in words

    made = [f for f in frames if not (f.name == "AnkleState" and f.number >= 71_000)]
    words = export(write(tmp_path / "rec.log", made), tmp_path, status=1)
    assert re.search(r"AnkleState on can0: about \d{4} frames missing while its sender went on", words)
    assert len(exported(tmp_path)[0]) == 6_000


def test_a_record_that_stalls_is_not_silence(bench, tmp_path):
    """Frames in turn, with a second between the last ones of two messages, and a message that is slower than its DBC."""
    recording, frames = bench
    order = [f for f in frames if f.name != "KneeStatus" or f.number % 10 == 0]
    slow = [replace(f, data=(f.number // 10).to_bytes(2, "little") + f.data[2:], number=f.number // 10)
            if f.name == "KneeStatus" else f for f in order]  # fmt: skip
    last = max(i for i, frame in enumerate(slow) if frame.name == "KneeState")
    stalled = [replace(f, t_ns=f.t_ns + 10**9 * (i > last)) for i, f in enumerate(slow)]
    export(write(tmp_path / "rec.log", stalled), tmp_path)
    assert found(exported(tmp_path)[1]) == []


def test_a_loss_longer_than_the_counter(tmp_path):
    """What 16 bits cannot tell, the stamps do."""
    tick = np.delete(np.arange(200_000), np.arange(100, 100 + 65_536))
    whole = follow(tick % 65_536, 16, tick * 1_000_000, 0.001)
    assert [(f.kind, f.index, f.number, f.count) for f in whole.faults] == [("lost", 100, 100, 65_536)]
    assert follow(tick % 65_536, 16, tick * 1_000_000).faults == []  # as the documentation says


def test_one_foreign_first_frame(bench, tmp_path):
    """What an adapter still had of yesterday: another counter, or another day. It is named, and the rest exported."""
    recording, frames = bench
    state = next(frame for frame in frames if frame.name == "KneeState")
    for foreign in (replace(state, data=(500).to_bytes(2, "little") + state.data[2:]),
                    replace(state, t_ns=state.t_ns - 86_400 * 10**9, data=(64_999).to_bytes(2, "little") + state.data[2:])):  # fmt: skip
        words = export(write(tmp_path / "rec.log", [foreign, *frames]), tmp_path, status=1)
        assert "KneeState on can0: 1 frame where" in words
        got, _ = exported(tmp_path)
        assert len(got) == len(recording) and np.ptp(got["time_s"] - recording["time_s"]) < 20e-6


def test_ticks_that_lie_far_apart_cost_nothing():
    """A frame of 300 years later whose stamp fits its counter."""
    tick = np.append(np.arange(5000), 10**13)
    tracemalloc.start()
    time_ns, _ = tick_times(tick, tick * 1_000 + 50, 1e-6)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10e6 and time_ns[:5000] == pytest.approx(tick[:5000] * 1000.0, abs=60)


def test_a_doubled_record(bench, tmp_path):
    """Said in a line each, in time that rises with its length and not with its square."""
    frames = bench[1] * 4
    words = export(write(tmp_path / "rec.log", frames), tmp_path)
    assert f"KneeState on can0: {3 * len(bench[0])} frames repeated" in words
    assert len(exported(tmp_path)[0]) == len(bench[0])
    calls = []
    counter = np.tile(np.arange(5000), 40)
    again = follow(counter, 16, np.arange(len(counter)) * 10**6, 0.0, lambda a, b: calls.append(a) or True)
    assert len(calls) == 39 * 5000 and len(again.faults) == 39


def test_interfaces_without_number(bench, tmp_path):
    """300 of them are read, thousands refused."""
    for count, words in ((300, "is on"), (1100, "more than 1000 interfaces")):
        lines = [replace(frame, interface=f"can{k % count}").line for k, frame in enumerate(bench[1])]
        (tmp_path / "rec.log").write_text("".join(lines))
        assert words in refused(tmp_path / "rec.log", tmp_path)


@pytest.mark.parametrize("text", [b"\0" * (1 << 28), b"x" * (1 << 26)], ids=["NUL", "one line"])
def test_a_bomb_is_refused_in_little_memory(tmp_path, text):
    """256 MiB of NUL in a quarter of a megabyte of gzip; a line of 64 MiB."""
    (tmp_path / "rec.log.gz").write_bytes(gzip.compress(text, 1))
    del text
    tracemalloc.start()
    refused(tmp_path / "rec.log.gz", tmp_path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 30e6


def test_a_clock_that_was_set_is_no_loss():
    """Forward by 40 s, more than half of what the counter holds."""
    tick = np.arange(2000)
    jump = follow(tick, 16, tick * 1_000_000 + 40 * 10**9 * (tick > 1000), 0.001)
    assert [(fault.kind, fault.index) for fault in jump.faults] == [("jumped", 1001)] and list(jump.number) == list(tick)


def test_a_counter_that_does_not_count():
    """All faults there are, in seconds and not in hours."""
    counter = np.random.default_rng(1).integers(0, 65_536, 20_000)
    chaos = follow(counter, 16, np.arange(20_000) * 1_000_000, 0.001, lambda a, b: False)
    assert len(chaos.faults) > 20_000
    assert {fault.kind for fault in follow(np.zeros(500, int), 16, np.arange(500)).faults} == {"repeated"}


# ---- a record as it may be ----------------------------------------------------------------------


def test_a_record_that_was_cut_off(bench, tmp_path):
    text = "".join(frame.line for frame in bench[1])
    for cut in (text[:-10], text + "(17000", text + "\0" * 500):
        (tmp_path / "rec.log").write_bytes(cut.encode())
        words = export(tmp_path / "rec.log", tmp_path)
        assert ("is cut off and was left out" in words) == ("\0" not in cut)
        assert len(exported(tmp_path)[0]) >= len(bench[0]) - 1


def test_a_recorder_that_was_killed_or_lost_something(bench, tmp_path):
    path = write(tmp_path / "rec.log", bench[1])
    side = tmp_path / "rec.jsonl"
    side.write_text('{"type":"header","log":"rec.log"}\n{"type":"clock","mono_ns":1,"real_n')
    assert "rec.jsonl has no end: the recorder was killed" in export(path, tmp_path)
    side.write_text('{"type":"drop","source":"can0","where":"socket","lost":17,"after":400,"real_ns":1}\n{"type":"end"}\n')
    words = export(path, tmp_path, status=1)
    assert "can0: 17 frames lost at the socket, behind its frame 400\n" in words
    assert exported(tmp_path)[1]["dropped"] == {"recorder": 17, "candump": 0}
    side.write_text('{"type":"vanished","source":"can0","lost":5,"perhaps_lost":2,"known":false,"after":9,"real_ns":1}\n{"type":"end"}\n')
    words = export(path, tmp_path, status=1)
    assert "can0: 5 frames lost at the interface, behind its frame 9\n" in words
    assert "perhaps 2 more frames lost" in words and "an interface vanished 1 times" in words
    side.write_text('{"type":"clock"}\n')
    (tmp_path / "rec.csv").unlink()
    assert "rec.jsonl:1: " in refused(path, tmp_path)


def test_candumps_own_word_about_drops(bench, tmp_path):
    text = [frame.line for frame in bench[1]]
    text.insert(1000, "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n")
    (tmp_path / "rec.log").write_text("".join(text))
    assert "line 1001: candump dropped 3 frames\n" in export(tmp_path / "rec.log", tmp_path, status=1)


def test_short_frames(bench, tmp_path):
    frames = list(bench[1])
    own = [i for i, frame in enumerate(frames) if frame.name == "KneeState"]
    frames[own[700]] = replace(frames[own[700]], data=frames[own[700]].data[:5])  # the counter is there
    frames[own[900]] = replace(frames[own[900]], data=b"\x01")  # it is not
    words = export(write(tmp_path / "rec.log", frames), tmp_path, status=1)
    assert f"2 frames shorter than the DBC says: line {own[700] + 1}; line {own[900] + 1}\n" in words
    got, told = exported(tmp_path)
    assert told["left_out"] == 2 and np.abs(got["knee_motor_rad"]).min() < 1
    kept = np.delete(bench[0], [700, 900])
    assert got["knee_motor_rad"] == pytest.approx(kept["knee_motor_rad"], abs=2 * np.pi / 16384)


def with_float_current(folder):
    """A DBC whose knee's current is a floating-point number of 16 bits."""
    knee = DBC.read_text().index("BO_ 513")
    text = DBC.read_text()[:knee] + DBC.read_text()[knee:].replace("Current : 48|16@1- (0.0005,0)", "Current : 48|16@1- (1,0)", 1)
    (folder / "f.dbc").write_text(text + "\nSIG_VALTYPE_ 513 Current : 1;\n")
    return folder / "f.dbc"


def with_words(frames, word_of):
    """Frames of the knee whose current is word_of(number), as 16 bits."""
    return [replace(f, data=f.data[:6] + word_of(f.number).to_bytes(2, "little")) if f.name == "KneeState" else f for f in frames]


@pytest.mark.parametrize("word", [0x7C01, 0x7E00, 0x7C00, 0xFC00], ids=["signalling", "quiet", "infinite", "below all"])
@pytest.mark.filterwarnings("error")
def test_a_signal_that_is_no_number(bench, tmp_path, word):
    """Said, and its row left out: no recording may hold it."""
    odd, usual = (65_700, 65_900), int(np.float16(1.5).view(np.uint16))
    path = write(tmp_path / "rec.log", with_words(bench[1], lambda number: word if number in odd else usual))
    words = export(path, tmp_path, dbc=with_float_current(tmp_path), status=1)
    places = [i + 1 for i, f in enumerate(bench[1]) if f.name == "KneeState" and f.number in odd]
    assert f"KneeState on can0: 2 values that are no number, or beyond 1e9: line {places[0]}; line {places[1]}\n" in words
    got, told = exported(tmp_path)
    assert told["left_out"] == 2 and len(got) == len(bench[0]) - 2 and (got["knee_current_A"] == 1.5).all()
    assert [(one["kind"], one["line"]) for one in told["faults"]] == [("unusable", line) for line in places]
    run("talus-predict", "--model", MODEL, "--out", tmp_path / "p.csv", tmp_path / "rec.csv")


def test_a_signal_that_is_never_a_number(bench, tmp_path):
    """The recording does without it, or there is none."""
    path = write(tmp_path / "rec.log", with_words(bench[1], lambda number: 0x7E00))
    assert "knee_current_A: none of its frames holds a number up to 1e+09" in refused(path, tmp_path, dbc=with_float_current(tmp_path))
    text = DBC.read_text().replace("BusVoltage : 16|16@1+ (0.001,0)", "BusVoltage : 16|16@1+ (1,0)") + "\nSIG_VALTYPE_ 784 BusVoltage : 1;\n"
    (tmp_path / "f.dbc").write_text(text)
    frames = [replace(f, data=f.data[:2] + b"\0\x7E" + f.data[4:]) if f.name == "Supply" else f for f in bench[1]]
    words = export(write(tmp_path / "rec.log", frames), tmp_path, dbc=tmp_path / "f.dbc", status=1)
    assert "note: no bus_V: none of its frames holds a number" in words and "bus_V" not in exported(tmp_path)[1]["columns"]


def test_what_is_not_in_the_dbc(bench, tmp_path):
    lines = [frame.line for frame in bench[1]]
    lines.insert(10, f"({BEGIN_NS // 10**9}.200000) can0 7FE#01\n")
    lines.insert(20, f"({BEGIN_NS // 10**9}.200000) can0 18FF0201#0102\n")
    (tmp_path / "rec.log").write_text("".join(lines))
    words = export(tmp_path / "rec.log", tmp_path)
    assert "note: not in the DBC: 0x7FE on can0 (1 frames, the first in line 11), 0x18FF0201 on can0" in words


def test_two_interfaces(bench, tmp_path):
    both = [g for f in bench[1] for g in (f, replace(f, interface="can1"))]
    path = write(tmp_path / "rec.log", both)
    assert "KneeState is on can0 and can1: --interface says which" in refused(path, tmp_path)
    assert "--interface: can7 is not in" in refused(path, tmp_path, "--interface", "can7")
    export(path, tmp_path, "--interface", "can1")
    assert len(exported(tmp_path)[0]) == len(bench[0])


@pytest.mark.parametrize(("text", "words"), [
    ("", "holds no frame"), ("hello\n", "rec.log:1: no line of candump's log format: 'hello'"),
    ("(1.0) can0 201#00\n(1.0) can0 201#0\n", "rec.log:2: no line"),
    ("(1.0) can0 20#00\n", "rec.log:1: no line"), ("(x.0) can0 201#00\n", "rec.log:1: no line"),
    ("(1.0) can0 201#00112233445566778899\n", "rec.log:1: no line"),
    ("(1.0) can0 7FE#00\n", "none of its frames is in"),
    ("(1.0) can0 310#000000000000\n", "has no whole frame KneeState (0x201), which holds knee_motor_rad"),
    ("(1.0) can0 201#0000\n", "has no whole frame KneeState"),
    ("(1.0) can0 201#0000000000000000\n(1.0) can0 202#0000000000000000\n", "gives 1 samples, fewer than 100"),
])  # fmt: skip
def test_records_that_are_none(tmp_path, text, words):
    (tmp_path / "rec.log").write_text(text)
    assert words in refused(tmp_path / "rec.log", tmp_path)


def test_bad_files(bench, tmp_path):
    path = write(tmp_path / "rec.log", bench[1])
    assert "no.log: cannot be read" in refused(tmp_path / "no.log", tmp_path)
    assert "no.dbc: cannot be read" in refused(path, tmp_path, dbc=tmp_path / "no.dbc")
    assert "no.yaml: cannot be read" in refused(path, tmp_path, model=tmp_path / "no.yaml")
    bad = tmp_path / "bad.dbc"
    bad.write_text("BO_ nonsense")
    assert "bad.dbc: does not parse as a DBC: " in refused(path, tmp_path, dbc=bad)
    model = tmp_path / "m.yaml"
    model.write_text((REPOSITORY / "models/leg.yaml").read_text())
    assert "m.yaml: bus: missing key" in refused(path, tmp_path, model=model)
    model.write_text(MODEL.read_text().replace("sign: -1}", "sign: 2}"))
    assert "expected 1 or -1, found '2'" in refused(path, tmp_path, model=model)
    model.write_text("plant: leg\n")
    assert "m.yaml: " in refused(path, tmp_path, model=model)


def test_a_bus_section_of_another_bench(bench, tmp_path):
    """A wrong sign is no recording with a strange angle."""
    path, model = write(tmp_path / "rec.log", bench[1]), tmp_path / "m.yaml"
    text = MODEL.read_text()
    knee = "motor: {counts_per_turn: 16384, sign: 1}"
    model.write_text(text.replace(knee, knee.replace("sign: 1", "sign: -1")))
    assert "knee_motor_rad: motor and joint encoder contradict each other" in refused(path, tmp_path, model=model)


@pytest.mark.parametrize(("options", "words"), [
    (["--rate", "fast"], "--rate: expected a number"), (["--rate", "0"], "--rate: expected a number"),
    (["--rate", "1e6"], "expected at most 16 for each"), (["--rate", "1e7"], "--rate: expected a number"),
    (["--channel", "knee_motor_rad"], "--channel: expected COLUMN=MESSAGE.SIGNAL"),
    (["--channel", "wings=A.B"], "'wings' is no column"),
    (["--channel", "knee_motor_rad=A.B"], "has no signal A.B"),
    (["--side", "no.jsonl"], "--side: there is no no.jsonl"),
    (["--wind", "3"], "option --wind not recognized"), (["more.log"], "expected one record, found 2"),
])  # fmt: skip
def test_bad_usage(bench, tmp_path, options, words):
    assert words in refused(write(tmp_path / "rec.log", bench[1][:5000]), tmp_path, *options)


def test_outputs_are_whole_or_not_there(bench, tmp_path):
    path = write(tmp_path / "rec.log", bench[1][:5000])
    for option in ("--dbc", "--model", "--out"):
        files = {"--dbc": DBC, "--model": MODEL, "--out": tmp_path / "rec.csv"}
        files.pop(option)
        done = run("talus-acquire-export", *(w for pair in files.items() for w in pair), path, status=2)
        assert f"{option} is missing" in done.stderr
    args = ["--dbc", DBC, "--model", MODEL, path]
    assert "cannot be written" in run("talus-acquire-export", *args, "--out", tmp_path / "no" / "x.csv", status=1).stderr
    assert "is an input and an output" in run("talus-acquire-export", *args, "--out", path, status=2).stderr
    assert "cannot be written" in run("talus-acquire-export", *args, "--out", "/dev/full", status=1).stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["rec.log"]


def test_help_and_version():
    assert "--channel" in run("talus-acquire-export", "--help").stdout
    assert re.fullmatch(r"talus-acquire-export \d+\.\d+\.\d+\n", run("talus-acquire-export", "--version").stdout)


def test_a_minute_of_a_full_bus_takes_seconds(tmp_path):
    """540,000 frames, nine each millisecond."""
    generator = np.random.default_rng(1)
    noise = generator.integers(0, 256, (60_000, 7, 8), np.uint8)
    joint = BUS["knee"]["joint"]["zero_count"], BUS["ankle"]["joint"]["zero_count"]
    with open(tmp_path / "rec.log", "w") as file:
        for k in range(60_000):
            stamp = f"({1_700_000_000 + k // 1000}.{k % 1000:03d}"
            for i in range(2):
                data = b"".join(x.to_bytes(2, "little") for x in (k % 65536, 7, joint[i], k % 1000))
                file.write(f"{stamp}{i * 111:03d}) can0 {0x201 + i:03X}#{data.hex()}\n")
            for i in range(7):
                file.write(f"{stamp}{i * 111 + 222:03d}) can0 {0x401 + i:03X}#{noise[k, i].tobytes().hex()}\n")
    before = resource.getrusage(resource.RUSAGE_SELF)
    export(tmp_path / "rec.log", tmp_path)
    after = resource.getrusage(resource.RUSAGE_SELF)
    assert exported(tmp_path)[1]["rows"] == 60_000
    assert after.ru_utime - before.ru_utime < 15  # about 2 s here
