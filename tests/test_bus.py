"""models/leg.dbc, the code made from it, apps/leg_bus/leg_bus.c and `bus:` of model files."""

import math
import random
import re
import subprocess
import sys

import cantools
import numpy as np
import pytest
import yaml
from bus_record import BUS, DATABASE, DBC, MODEL, twin
from support import BUILD, REPOSITORY, run

LEG = REPOSITORY / "models/leg.yaml"
COUNTER_BITS = 16


def ask(requests, model=MODEL):
    """The answers of tests/programs/leg_bus.c."""
    done = subprocess.run([BUILD / "tests/leg_bus", model], input="".join(f"{line}\n" for line in requests), check=True,
                          capture_output=True, text=True)  # fmt: skip
    answers = done.stdout.splitlines()
    assert len(answers) == len(requests)
    return answers


def decoded(answer):
    identifier, _, data = answer.partition("#")
    message = DATABASE.get_message_by_frame_id(int(identifier, 16))
    assert len(bytes.fromhex(data)) == message.length
    return message.name, message.decode(bytes.fromhex(data), decode_choices=False)


# ---- the DBC -----------------------------------------------------------------------


def test_generated_code_is_current(tmp_path):
    tool = REPOSITORY / "tools/dbc_code"
    subprocess.run([sys.executable, tool, DBC, tmp_path], check=True)
    for name in ("leg_dbc.c", "leg_dbc.h"):
        made, kept = (folder / name for folder in (tmp_path, REPOSITORY / "apps/leg_bus/generated"))
        assert made.read_text() == kept.read_text(), "run .venv/bin/python tools/dbc_code models/leg.dbc apps/leg_bus/generated"
        assert not re.search(r"\d\d:\d\d:\d\d", made.read_text())  # no date
        assert "The MIT License" in made.read_text() and "Erik Moqvist" in made.read_text()


def test_every_frame_has_a_counter_and_every_signal_its_place():
    for message in DATABASE.messages:
        counter = message.get_signal_by_name("Counter")
        assert (counter.start, counter.length, counter.is_signed) == (0, COUNTER_BITS, False), message.name
        assert message.length <= 8 and not message.is_extended_frame
        for signal in message.signals:  # the range is what the bits can hold
            low, high = (-(2 ** (signal.length - 1)), 2 ** (signal.length - 1) - 1) if signal.is_signed else (0, 2**signal.length - 1)
            scale = signal.conversion.scale
            if not (message.name == "HostHeartbeat" and signal.name == "Mode"
                    or message.name.endswith("Status") and signal.name == "State"):  # fmt: skip
                assert (signal.minimum, signal.maximum) == pytest.approx((low * scale, high * scale)), signal.name


def test_a_full_kilohertz_fits_the_bus():
    """With all stuff bits: 34 + 8 n bits can be stuffed, every fourth after the first; 13 follow that cannot."""
    load = 0
    for message in DATABASE.messages:
        stuffed = 34 + 8 * message.length
        bits = stuffed + (stuffed - 1) // 4 + 13
        load += bits * (1000 / message.cycle_time if message.cycle_time else 0)
    assert 0.5e6 < load < 0.6e6  # of 1 Mbit/s


def test_knee_and_ankle_are_packed_alike():
    """apps/leg_bus/leg_bus.c packs both with the knee's functions."""
    for kind in ("Command", "State", "Status"):
        knee, ankle = (DATABASE.get_message_by_name(joint + kind) for joint in ("Knee", "Ankle"))
        layout = [[(s.name, s.start, s.length, s.byte_order, s.is_signed, s.conversion.scale, s.conversion.offset) for s in m.signals]
                  for m in (knee, ankle)]  # fmt: skip
        assert layout[0] == layout[1] and knee.length == ankle.length


def test_channels_are_columns_of_a_leg():
    channels = {s.dbc.attributes["Channel"].value for m in DATABASE.messages for s in m.signals if "Channel" in s.dbc.attributes}
    needed = {f"{j}_{c}" for j in ("knee", "ankle") for c in ("motor_rad", "joint_rad", "current_A", "temp_C")} | {"bus_V"}
    assert channels == needed


def test_plain_dbc():
    """Nothing that only some readers know: no multiplexing, no extended or double values, ASCII."""
    text = DBC.read_bytes().decode("ascii")
    assert not re.search(r"SIG_VALTYPE_|SG_MUL_VAL_|^ SG_ \w+ (M|m\d+) ", text, re.MULTILINE)
    assert cantools.database.load_string(text, "dbc", strict=True).messages


# ---- frames from C ---------------------------------------------------------------------


def test_commands_decode_in_cantools():
    generator, requests, expected = random.Random(1), [], []
    for k in range(2000):
        joint, q, v, torque = k % 2, generator.uniform(-2.6, 2.6), generator.uniform(-16, 16), generator.uniform(-0.8, 0.8)
        requests.append(f"command {joint} {k % 65536} {q!r} {v!r} {torque!r}")
        expected.append((("KneeCommand", "AnkleCommand")[joint], k, q, v, torque))
    answers = ask(requests)
    for answer, (name, counter, q, v, torque) in zip(answers, expected, strict=True):
        got, values = decoded(answer)
        assert got == name and values["Counter"] == counter
        assert values["Position"] == pytest.approx(q, abs=2.5000001e-6) and values["Velocity"] == pytest.approx(v, abs=1.0001e-3)
        assert values["TorqueFeedforward"] == pytest.approx(torque, abs=5.0001e-5)
    back = ask([f"frame {answer}" for answer in answers])
    for answer, text in zip(answers, back, strict=True):
        word, joint, *numbers = text.split()
        name, values = decoded(answer)
        assert word == "command" and name.startswith(("Knee", "Ankle")[int(joint)])
        assert [float(x) for x in numbers] == list(values.values())


def test_a_set_point_that_does_not_fit_is_refused():
    wrong = ["command 0 1 2.63 0 0", "command 0 1 -2.63 0 0", "command 1 1 0 16.5 0", "command 1 1 0 0 0.82", "command 2 1 0 0 0",
             "command -1 1 0 0 0", "command 0 1 nan 0 0", "command 0 1 0 inf 0"]  # fmt: skip
    assert ask(wrong) == ["refused"] * len(wrong)


def test_the_other_frames():
    answers = ask(["stop 7 1 3", "host 65535 2", "state 1 9 65535 12345 -1.2345", "status 0 4 31.27 -5.5 2 129",
                   "supply 3 23.987 -1.5", "bench 2 70000 17 12.9", "state 0 1 2 3 99", "status 1 1 999 -999 0 0"])  # fmt: skip
    got = [decoded(answer) for answer in answers]
    assert got[0] == ("Stop", {"Counter": 7, "Reason": 1, "Source": 3})
    assert got[1] == ("HostHeartbeat", {"Counter": 65535, "Mode": 2})
    assert got[2] == ("AnkleState", {"Counter": 9, "MotorCount": 65535, "JointCount": 12345, "Current": -1.2345})
    status = {"Counter": 4, "MotorTemperature": 31.27, "DriveTemperature": -5.5, "State": 2, "Faults": 129}
    assert got[3] == ("KneeStatus", pytest.approx(status))
    assert got[4] == ("Supply", pytest.approx({"Counter": 3, "BusVoltage": 23.987, "BusCurrent": -1.5}))
    assert got[5] == ("BenchHeartbeat", {"Counter": 2, "LateTicks": 65535, "MissedCommands": 17, "Uptime": 12})
    assert got[6][1]["Current"] == pytest.approx(16.3835)  # what is shown stops at the field's end
    assert got[7][1]["MotorTemperature"] == pytest.approx(327.67) == -got[7][1]["DriveTemperature"]


def test_frames_that_are_something_else():
    whole = "0000000000000000"
    asked = [f"201#{whole[:14]}", f"101#{whole[:14]}", "001#000000", "010#0000", "010#000003", f"203#{whole}", f"7FF#{whole}"]
    assert ask([f"frame {text}" for text in asked]) == ["nothing"] * len(asked)
    assert ask(["frame 001#00000000", "frame 010#000002"]) == ["stop", "host 2"]
    assert ask(["frame 202#010002000300E803"]) == ["state 1 1 2 3 -0.5"]  # the ankle's current counts the other way


# ---- counts and angles ---------------------------------------------------------------------


def test_counts_of_angles():
    generator, requests, expected = random.Random(2), [], []
    for k in range(500):
        joint, q, motor, zero = k % 2, generator.uniform(-3, 3), generator.uniform(-60, 60), generator.randrange(65536)
        bus = BUS[("knee", "ankle")[joint]]
        absolute = bus["joint"]["zero_count"] + bus["joint"]["sign"] * q / math.tau * 65536
        relative = zero + bus["motor"]["sign"] * motor / math.tau * 16384
        requests.append(f"count {joint} {q!r} {motor!r} {zero}")
        expected.append((absolute, relative))
    for answer, exact in zip(ask(requests), expected, strict=True):
        for got, wanted in zip(map(int, answer.split()), exact, strict=True):
            assert abs((got - wanted + 32768) % 65536 - 32768) <= 0.5 + 1e-6


@pytest.mark.parametrize("joint", [0, 1])
def test_encoders_unrolled_and_zeroed(tmp_path, joint):
    """The twin's motor angle from counts that begin anywhere and wrap."""
    name = ("knee", "ankle")[joint]
    recording = twin(tmp_path, duration=10)
    motor = recording[f"{name}_motor_rad"]
    absolute = recording["ankle_joint_rad"] if joint else recording["knee_motor_rad"] / 51
    bus = BUS[name]
    counts = (50_000 + bus["motor"]["sign"] * np.rint(motor / math.tau * 16384).astype(int)) % 65536
    angles = (bus["joint"]["zero_count"] + bus["joint"]["sign"] * np.rint(absolute / math.tau * 65536).astype(int)) % 65536
    assert np.abs(np.diff(counts)).max() > 60_000  # it does wrap
    answers = ask([f"take {joint} {m} {a}" for m, a in zip(counts, angles, strict=True)])
    got = np.array([answer.split() for answer in answers], float)
    assert got[-1, 0] == pytest.approx(motor[-1], abs=math.tau / 16384)
    assert got[5000:, 0] == pytest.approx(motor[5000:], abs=2 * math.tau / 16384)
    assert got[:, 1] == pytest.approx(absolute, abs=math.tau / 65536)


# ---- the model file ----------------------------------------------------------------------------


def test_the_bench_is_the_leg():
    leg, bench = (yaml.safe_load(path.read_text()) for path in (LEG, MODEL))
    assert bench.pop("bus") and bench == leg


def copy(folder, text):
    path = folder / "m.yaml"
    path.write_text(text)
    done = subprocess.run([BUILD / "tests/model_copy", path, folder / "out.yaml"], check=False, capture_output=True, text=True)
    return done.stderr if done.returncode else yaml.safe_load((folder / "out.yaml").read_text())


def test_bus_is_read_and_written(tmp_path):
    assert copy(tmp_path, MODEL.read_text())["bus"] == BUS
    said = yaml.safe_load(MODEL.read_text())
    said["bus"]["knee"] = {"motor": {"counts_per_turn": 4000, "sign": -1},
                           "joint": {"counts_per_turn": 4096, "sign": -1, "zero_count": 17.25}, "current": {"sign": -1}}  # fmt: skip
    assert copy(tmp_path, yaml.safe_dump(said))["bus"] == said["bus"]
    assert "bus" not in copy(tmp_path, LEG.read_text())


def leaves(node, path=()):
    for key, value in node.items():
        yield (*path, key), value
        if isinstance(value, dict):
            yield from leaves(value, (*path, key))


@pytest.mark.parametrize("path", [path for path, _ in leaves(BUS)], ids=".".join)
def test_each_key_missing_misspelt_and_of_another_kind(tmp_path, path):
    wrong = {"sign": [0, 2, -1.5, "up"], "counts_per_turn": [1, 0, -4, 1000.5, 1e7], "zero_count": [-1, 65536, "x"]}
    for change in ("missing", "misspelt", *wrong.get(path[-1], [3, []])):
        said = yaml.safe_load(MODEL.read_text())
        node = said["bus"]
        for key in path[:-1]:
            node = node[key]
        value = node.pop(path[-1])
        if change == "misspelt":
            node[path[-1] + "x"] = value
        elif change != "missing":
            node[path[-1]] = change
        message = copy(tmp_path, yaml.safe_dump(said))
        assert isinstance(message, str), (path, change)
        assert re.search(r"m\.yaml:\d+: bus\.", message) and len(message.splitlines()) == 1
        assert ".".join(path[:-1]) in message and path[-1] in message


def test_only_a_leg_has_one(tmp_path):
    text = (REPOSITORY / "models/pendulum.yaml").read_text() + MODEL.read_text()[MODEL.read_text().index("bus:"):]
    assert "bus: unknown key" in copy(tmp_path, text)


# ---- the twin, before it is on a bus -------------------------------------------------------------


@pytest.mark.parametrize(("options", "words"), [
    (["--excitation", "bus"], "--excitation bus: needs --can"),
    (["--can", "can77"], "--can: there is no interface 'can77'"),
    (["--can", "can77", "--rate", "500"], "--rate: not with --can"),
    (["--can", "can77", "--jitter", "0"], "--jitter: not with --can"),
    (["--can", "can77", "--encoder-bits", "12"], "--encoder-bits: not with --can"),
    (["--can", "can77", "--ankle-bits", "12"], "--ankle-bits: not with --can"),
    (["--can", "can77", "--excitation", "bus", "--speed", "2"], "--excitation bus: the motion is the bus's"),
    (["--can", "can77", "--excitation", "bus", "--fit"], "--excitation bus: the motion is the bus's"),
    (["--can", "can77", "--model", LEG], "leg.yaml: bus: missing key, --can needs it"),
    (["--can", "can77", "--model", REPOSITORY / "models/slider.yaml"], "--can: only a leg has a bus"),
])  # fmt: skip
def test_a_bus_that_cannot_be(tmp_path, options, words):
    done = run("talus-sim", "--model", MODEL, "--out", tmp_path / "x.csv", *options, status=2)
    assert words in done.stderr and len(done.stderr.splitlines()) == 1 and not [*tmp_path.iterdir()]
