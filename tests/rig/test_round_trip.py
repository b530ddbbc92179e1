"""The twin on a real CAN interface: recorded, exported, identified, and compared with what the twin itself wrote."""

import json
import os
import re
import subprocess
import time

import can
import cantools
import numpy as np
import pytest
import yaml
from recording import Recording
from support import REPOSITORY, program, run

pytestmark = [pytest.mark.rig, pytest.mark.release]

DBC = REPOSITORY / "models/leg.dbc"
MODEL = REPOSITORY / "models/leg_bench.yaml"
GUESS = REPOSITORY / "models/leg_cad.yaml"
DATABASE = cantools.database.load_file(str(DBC))
BUS = yaml.safe_load(MODEL.read_text())["bus"]
SECONDS = min(int(os.environ.get("TALUS_RIG_SECONDS", "60")) * 3, 60)  # shorter motion tells too little of the leg
MOTOR_STEP, CURRENT_STEP = 2 * np.pi / 16384, 0.0005


def twin(folder, interface, *options, model=MODEL, duration=SECONDS):
    """The twin as a process that runs on the bus, with its files in `folder`."""
    command = [program("talus-sim"), "--model", model, "--can", interface, "--out", folder / "twin.csv",
               "--truth", folder / "truth.json", "--duration", duration, *options]  # fmt: skip
    return subprocess.Popen([str(word) for word in command], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def record(folder, interface, *options, meanwhile=lambda: None, **more):
    """The words of a twin that was recorded from before its first frame to behind its last one."""
    with Recording(folder / "rec", interface) as recording:
        process = twin(folder, interface, *options, **more)
        try:
            meanwhile()
            words = process.communicate(timeout=300)[1]
        finally:
            process.kill()
            process.wait()
        time.sleep(0.3)
        recording.stop()
    assert process.returncode == 0, words
    return words


def export(folder, status=0):
    run("talus-acquire", "export", folder / "rec.log", "--dbc", DBC, "--model", MODEL, "--out", folder / "rec.csv",
        "--report", folder / "rec.json", status=status)  # fmt: skip
    told = json.loads((folder / "rec.json").read_text())
    return np.genfromtxt(folder / "rec.csv", delimiter=",", names=True), told


def written(folder):
    """(the twin's own log, its truth)."""
    log = np.genfromtxt(folder / "twin.csv", delimiter=",", names=True)
    return log, json.loads((folder / "truth.json").read_text())


def check_equal(got, told, log):
    """To encoder resolution and 100 us."""
    assert len(got) == len(log) and told["complete"]
    assert np.ptp(got["time_s"] - log["time_s"]) < 100e-6
    for joint in ("knee", "ankle"):
        assert got[f"{joint}_motor_rad"] == pytest.approx(log[f"{joint}_motor_rad"], abs=MOTOR_STEP)
        assert got[f"{joint}_current_A"] == pytest.approx(log[f"{joint}_current_A"], abs=0.52 * CURRENT_STEP + 1e-5)
    assert got["ankle_joint_rad"] == pytest.approx(log["ankle_joint_rad"], abs=2 * np.pi / 65536)


def test_round_trip(vcan, tmp_path, capsys):
    words = record(tmp_path, *vcan(1))
    got, told = export(tmp_path)
    log, truth = written(tmp_path)
    check_equal(got, told, log)
    bus = truth["bus"]
    assert bus["frames_refused"] == 0 and bus["ticks"] == 1000 * SECONDS == len(log)
    assert sum(message["frames"] for message in told["messages"]) == bus["frames_sent"]
    fitted = tmp_path / "fitted.json"
    run("talus-identify", "--model", GUESS, "--out", tmp_path / "fitted.yaml", "--report", fitted, tmp_path / "rec.csv")
    found = json.loads(fitted.read_text())["base_parameters"]
    off = {name: found[name]["value"] / true - 1 for name, true in truth["base_parameters"].items()}
    with capsys.disabled():
        print(f"\n  {words.splitlines()[0]}\n  instants {1e6 * np.ptp(got['time_s'] - log['time_s']):.1f} us, "
              f"combinations at most {100 * max(map(abs, off.values())):.2f} % off ({max(off, key=lambda k: abs(off[k]))})")  # fmt: skip
    assert max(map(abs, off.values())) < 0.02, off


def test_record_opens_in_python_can_and_decodes_in_cantools(vcan, tmp_path):
    """Every frame of the twin, field by field, read by nothing of ours."""
    record(tmp_path, *vcan(1), duration=10)
    log, truth = written(tmp_path)
    fields = {}
    for message in can.LogReader(str(tmp_path / "rec.log")):
        entry = DATABASE.get_message_by_frame_id(message.arbitration_id)
        assert message.dlc == entry.length
        fields.setdefault(entry.name, []).append(entry.decode(bytes(message.data), decode_choices=False))
    assert sum(map(len, fields.values())) == truth["bus"]["frames_sent"]
    for name, decoded in fields.items():
        assert [values["Counter"] for values in decoded] == [k % 65536 for k in range(len(decoded))], name
    zeros = dict(zip(("knee", "ankle"), truth["bus"]["motor_zero_count"], strict=True))
    for joint, zero in zeros.items():
        decoded, bus = fields[f"{joint.capitalize()}State"], BUS[joint]
        counts = zero + bus["motor"]["sign"] * np.rint(log[f"{joint}_motor_rad"] / MOTOR_STEP)
        assert [values["MotorCount"] for values in decoded] == [int(x) % 65536 for x in counts]
        current = np.array([values["Current"] for values in decoded]) * bus["current"]["sign"]
        assert current == pytest.approx(log[f"{joint}_current_A"], abs=0.52 * CURRENT_STEP + 1e-5)
    absolute = 47000 - np.rint(log["ankle_joint_rad"] / (2 * np.pi / 65536))
    assert [values["JointCount"] for values in fields["AnkleState"]] == [int(x) % 65536 for x in absolute]
    assert {values["BusVoltage"] for values in fields["Supply"]} == {24.0}


def test_instants_in_absolute_time(vcan, tmp_path):
    """The export's time 0 against the twin's first deadline, on the same clock."""
    record(tmp_path, *vcan(1), duration=5)
    got, told = export(tmp_path)
    log, truth = written(tmp_path)
    check_equal(got, told, log)
    clocks = [json.loads(line) for line in (tmp_path / "rec.jsonl").read_text().splitlines() if '"clock"' in line]
    clock = next(entry for entry in clocks if entry["type"] == "clock")
    begin_ns = truth["bus"]["begin_real_ns"] - clock["real_ns"] + clock["mono_ns"]
    assert told["clock"] == "CLOCK_MONOTONIC" and 0 < (told["zero_ns"] - begin_ns) / 1e9 < 500e-6


def test_effects_act_on_the_bus_too(vcan, tmp_path):
    model = tmp_path / "m.yaml"
    model.write_text(MODEL.read_text() + """effects:
  - {effect: stribeck, joint: ankle, parameters: {extra_Nm: 0.4, speed_rad_s: 0.1, exponent: 2}}
  - {effect: current_offset, joint: knee, parameters: {torque_Nm: 0.02}}
""")
    record(tmp_path, *vcan(1), model=model, duration=10)
    got, told = export(tmp_path)
    log, _ = written(tmp_path)
    check_equal(got, told, log)
    run("talus-sim", "--model", MODEL, "--out", tmp_path / "plain.csv", "--rate", 1000, "--jitter", 0, "--duration", 10)
    plain = np.genfromtxt(tmp_path / "plain.csv", delimiter=",", names=True)
    assert (got["knee_current_A"] - plain["knee_current_A"]).mean() == pytest.approx(0.02 / 0.1031, rel=0.02)


# ---- set-points from the bus --------------------------------------------------------------


def command(joint, counter, position, velocity=0.0, torque=0.0):
    name = f"{joint.capitalize()}Command"
    values = {"Counter": counter % 65536, "Position": position, "Velocity": velocity, "TorqueFeedforward": torque}
    message = DATABASE.get_message_by_name(name)
    return can.Message(arbitration_id=message.frame_id, is_extended_id=False, data=message.encode(values))


def play(interface, seconds, motion, rate=200):
    """Set-points of motion(t) = {joint: (position, velocity, torque)}, and at the end what `motion` sends then."""
    with can.Bus(interface=("socketcan"), channel=interface) as bus:
        begin = time.monotonic()
        for k in range(int(seconds * rate)):
            time.sleep(max(begin + k / rate - time.monotonic(), 0))
            for joint, values in motion(k / rate).items():
                bus.send(command(joint, k, *values))


def test_set_points_from_the_bus(vcan, tmp_path):
    (name,) = vcan(1)

    def motion(t):
        w = 2 * np.pi * 0.5
        return {"knee": (0.2 * (1 - np.cos(w * t)), 0.2 * w * np.sin(w * t)), "ankle": (0.1 * np.sin(w * t), 0.1 * w * np.cos(w * t))}

    words = record(tmp_path, name, "--excitation", "bus", duration=10, meanwhile=lambda: (time.sleep(0.5), play(name, 4, motion)))
    assert re.search(r"1600 set-points taken; \d+ ticks without a new one, 0 set-points beyond a position limit", words)
    got, told = export(tmp_path)
    log, _ = written(tmp_path)
    check_equal(got, told, log)
    knee = got["knee_motor_rad"] / 51
    assert np.abs(knee[:300]).max() < 1e-3 and knee.max() == pytest.approx(0.4, abs=0.03)
    assert np.abs(knee[-500:]).max() < 0.03  # holds where the last set-point was


def test_feedforward_from_the_bus(vcan, tmp_path):
    """A torque in the set-point is a current in the drive, at once."""
    (name,) = vcan(1)
    words = record(tmp_path, name, "--excitation", "bus", "--ideal", duration=6,
                   meanwhile=lambda: (time.sleep(0.5), play(name, 1, lambda t: {"knee": (0.0, 0.0, 0.015 * (t > 0.3)), "ankle": (0.0, 0.0)})))  # fmt: skip
    got, _ = export(tmp_path)
    current = got["knee_current_A"]
    first = int(np.argmax(np.abs(current) > 0.02))
    assert "400 set-points taken" in words
    assert current[first] == pytest.approx(0.015 / 0.1031, abs=0.01)  # friction (1.2 Nm / 51) holds: it does not move
    assert np.abs(got["knee_motor_rad"]).max() < 2 * MOTOR_STEP
    assert np.abs(current[-500:]).max() < 0.01  # holding, without it


def test_a_stop_frame_lets_the_drives_go(vcan, tmp_path):
    (name,) = vcan(1)

    def stop():
        time.sleep(2)
        with can.Bus(interface="socketcan", channel=name) as bus:
            message = DATABASE.get_message_by_name("Stop")
            bus.send(can.Message(arbitration_id=message.frame_id, is_extended_id=False,
                                 data=message.encode({"Counter": 0, "Reason": 1, "Source": 0})))  # fmt: skip

    words = record(tmp_path, name, "--noise", "0,0", duration=8, meanwhile=stop)
    assert "a stop frame came: the drives let go" in words
    got, _ = export(tmp_path)
    assert np.abs(got["knee_current_A"][:1000]).max() > 0.1
    assert np.abs(got["knee_current_A"][-1000:]).max() < CURRENT_STEP
    states = [DATABASE.decode_message(m.arbitration_id, m.data) for m in can.LogReader(str(tmp_path / "rec.log")) if m.arbitration_id == 0x301]
    assert states[0]["State"] == "Follow" and states[-1]["State"] == "Stopped"


def test_no_such_interface(vcan, tmp_path):
    vcan(1)
    out = ["--out", tmp_path / "x.csv"]
    assert "there is no interface 'can77'" in run("talus-sim", "--model", MODEL, *out, "--can", "can77", status=2).stderr
    assert "'lo' is no CAN interface" in run("talus-sim", "--model", MODEL, *out, "--can", "lo", status=2).stderr
    assert not (tmp_path / "x.csv").exists()
