"""Playing a trajectory on a real CAN interface: no set-point missing or twice, and nothing at all when a limit breaks."""

import math
import tempfile
import time
from pathlib import Path

import cantools
import pytest
from recording import Recording, ip, read_lines
from support import REPOSITORY, run
from trajectory import LIMITS, PATIENT, write_trajectory

pytestmark = [pytest.mark.rig, pytest.mark.release]

DATABASE = cantools.database.load_file(REPOSITORY / "models/leg.dbc")


@pytest.fixture
def tmp_path():
    """A folder in memory: in the guest the machine's disk can hold up everything for longer than a set-point may be late."""
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        yield Path(folder)


def commands(log, identifier):
    """[(seconds, decoded signals)] of one message of a record."""
    return [(float(seconds), DATABASE.decode_message(identifier, bytes.fromhex(data)))
            for seconds, _, name, data in read_lines(log) if int(name, 16) == identifier]  # fmt: skip


def test_every_set_point_once_in_order_with_its_value(vcan, tmp_path, capsys):
    (name,) = vcan()
    rows = write_trajectory(tmp_path / "t.csv")
    with Recording(tmp_path / "p", "--play", tmp_path / "t.csv", *PATIENT, "--limits", LIMITS, name) as recording:
        printed = recording.wait()
    (told,) = recording.events("play")
    assert told["rows"] == told["sent"] == rows == sum(told["late_below_us"].values()) and told["end"] == "done"
    assert recording.end()["reason"] == "trajectory played"
    assert recording.end()["loop"] == {"page_faults_minor": 0, "page_faults_major": 0, "allocations": 0}
    for identifier, amplitude in ((0x101, 0.3), (0x102, 0.15)):
        sent = commands(recording.log, identifier)
        assert [one["Counter"] for _, one in sent] == list(range(rows))
        for k, (_, one) in enumerate(sent):
            assert abs(one["Position"] - amplitude * math.sin(2 * math.pi * k / 1000)) < 2.6e-6
            assert abs(one["Velocity"] - 2 * math.pi * amplitude * math.cos(2 * math.pi * k / 1000)) < 1.1e-3
        seconds = [stamp for stamp, _ in sent]
        first = sorted(stamp - k / 1000 for k, stamp in enumerate(seconds))[0]
        late = [stamp - k / 1000 - first for k, stamp in enumerate(seconds)]
        assert -2e-6 < min(late) and max(late) <= 1e-9 * told["worst_late_ns"] + 0.5
    modes = [one["Mode"] for _, one in commands(recording.log, 0x010)]
    assert len(modes) >= rows / 10 and {str(mode) for mode in modes[:-1]} == {"Follow"} and str(modes[-1]) == "Hold"
    with capsys.disabled():
        print("\n" + "\n".join(line for line in printed.splitlines() if "us" in line or "played" in line))


@pytest.mark.parametrize(("change", "words"), [
    ({"amplitude": 0.95, "limits": LIMITS.replace("speed=5", "speed=9")}, "knee.position is 0.9"),
    ({"limits": LIMITS + ",knee.acceleration=1"}, "knee.acceleration is "),
    ({"limits": LIMITS.replace("ankle.speed=5", "ankle.speed=0.9")}, "ankle.speed is 0.9"),
    ({"amplitude": 100.0, "limits": "knee.position=-999:999,knee.speed=9999,ankle.position=-999:999,ankle.speed=9999"},
     "does not fit into its field"),
])  # fmt: skip
def test_a_broken_limit_sends_nothing(vcan, tmp_path, change, words):
    (name,) = vcan()
    write_trajectory(tmp_path / "t.csv", amplitude=change.get("amplitude", 0.3))
    with Recording(tmp_path / "other", name) as other:
        arguments = ("--play", tmp_path / "t.csv", "--limits", change.get("limits", LIMITS), name)
        complained = run("talus-acquire", "--out", tmp_path / "p", *arguments, status=2).stderr
        time.sleep(0.2)
        other.stop()
    assert words in complained and "nothing is sent" in complained and len(complained.splitlines()) == 1
    assert read_lines(other.log) == [] and not (tmp_path / "p.log").exists()


def test_ctrl_c_while_playing_holds(vcan, tmp_path):
    (name,) = vcan()
    write_trajectory(tmp_path / "t.csv", rows=20000)
    with Recording(tmp_path / "p", "--play", tmp_path / "t.csv", *PATIENT, "--limits", LIMITS, name) as recording:
        time.sleep(1.5)
        recording.stop()
    (told,) = recording.events("play")
    assert told["end"] == "stopped" and 0 < told["sent"] < 20000
    knee, ankle = (len(commands(recording.log, identifier)) for identifier in (0x101, 0x102))
    assert ankle == told["sent"] and knee - ankle in (0, 1)  # it may end between a row's two frames
    assert str(commands(recording.log, 0x010)[-1][1]["Mode"]) == "Hold"
    assert int(read_lines(recording.log)[-1][2], 16) == 0x010


def test_an_interface_that_is_down_at_the_start(vcan, tmp_path):
    """Nothing is sent, and that is said: of the emergency stop, of the set-points, and of the last word to the drives."""
    (name,) = vcan()
    ip("set", name, "down")
    write_trajectory(tmp_path / "t.csv", rows=100)
    play = ("--play", tmp_path / "t.csv", *PATIENT, "--limits", LIMITS)
    with Recording(tmp_path / "p", *play, "--stop", name, name) as recording:
        printed = recording.wait(status=1)
    assert f"an emergency stop CANNOT BE SENT on {name} now: Network is down" in printed
    assert f"{tmp_path / 't.csv'}: playing ended at set-point 0: refused by the kernel" in printed
    (told,) = recording.events("play")
    assert (told["sent"], told["held"]) == (0, False) and read_lines(recording.log) == []
