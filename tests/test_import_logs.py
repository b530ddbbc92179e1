"""talus-import of robots' logs and binary tables by other writers (import_logs.py): right against the closed form, or doubted aloud."""

import contextlib
import io

import h5py
import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
import scipy.io
import talus
from import_files import N, truth
from import_logs import DYNAMIC, JOINT_STATE, dynamic_states, joint_states, stamps, write_bag_folder, write_db3, write_matlab73, write_mcap
from talus.importing import command

X, SPIN = truth(), truth(turns=2.0)
RIGHT = {"time_s": X.t, "joint_rad": X.q, "joint_velocity_rad_s": X.v, "joint_torque_Nm": X.i}
FIVES = np.arange(N).reshape(-1, 5)[:, [1, 0, 2, 4, 3]].ravel()
TWICE = np.sort(np.concatenate([np.arange(N), np.arange(100, 200)]))
LOGS = {"log.mcap": write_mcap, "log.db3": write_db3, "bag": write_bag_folder}


def imported(folder, *arguments, status=0):
    """(columns, words) of a run in this process: a start takes a second."""
    out = folder / "rec.csv"
    with contextlib.redirect_stderr(io.StringIO()) as said:
        ended = command.main(["--out", str(out), *map(str, arguments)])
    assert ended == status, said.getvalue()
    return talus.Recording.read(out).columns if status == 0 else None, said.getvalue()


def static(messages):
    return {"/joint_states": ("sensor_msgs/msg/JointState", JOINT_STATE, messages)}


def dynamic(series):
    return {"/dynamic_joint_states": ("control_msgs/msg/DynamicJointState", DYNAMIC, dynamic_states(series))}


def check(got, expected, tolerance=1e-9):
    assert sorted(got) == sorted(expected)
    for name, values in expected.items():
        assert got[name] == pytest.approx(values, abs=tolerance), name


# ---- robots' logs ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", LOGS)
@pytest.mark.parametrize("kind", ["JointState", "DynamicJointState"])
def test_joint_states_of_other_writers(tmp_path, name, kind):
    """A rosbag2 in SQLite has no definition of its messages, and control_msgs is not among ROS's own."""
    series = {"arm": {"position": X.q, "velocity": X.v, "effort": X.i}}
    LOGS[name](tmp_path / name, static(joint_states(X.q, X.v, X.i)) if kind == "JointState" else dynamic(series))
    got, said = imported(tmp_path, tmp_path / name)
    assert "unsure" not in said
    check(got, RIGHT)


def test_interfaces_of_a_drive_beside_position_are_taken_and_their_units_doubted(tmp_path):
    series = {"arm": {"position": X.q, "velocity": X.v, "motor_current": X.i, "temperature": 30 + X.t}}
    write_mcap(tmp_path / "log.mcap", dynamic(series))
    got, said = imported(tmp_path, "--suggest", tmp_path / "log.mcap")
    assert "unsure: joint_current_A: arm.motor_current: its header has no unit; taken for A" in said and "unsure: joint_temp_C" in said
    check(got, {"time_s": X.t, "joint_rad": X.q, "joint_velocity_rad_s": X.v, "joint_current_A": X.i, "joint_temp_C": 30 + X.t})


def test_one_joint_of_several_is_taken_by_its_name(tmp_path):
    series = {"hip": {"position": -X.q}, "knee joint": {"position": X.q, "effort": X.i}}
    write_db3(tmp_path / "log.db3", dynamic(series))
    maps = ["--map", "time_s=stamp", "--map", "joint_rad=knee joint.position", "--map", "joint_torque_Nm=knee joint.effort"]
    got, _ = imported(tmp_path, "--plant", "pendulum", *maps, tmp_path / "log.db3")
    check(got, {name: RIGHT[name] for name in ("time_s", "joint_rad", "joint_torque_Nm")})


def test_of_two_topics_the_other_is_named(tmp_path):
    series = {"arm": {"position": X.q, "velocity": X.v, "effort": X.i}}
    write_mcap(tmp_path / "log.mcap", static(joint_states(X.q, X.v, X.i)) | dynamic(series))
    got, said = imported(tmp_path, tmp_path / "log.mcap")
    assert "/dynamic_joint_states is read; there is also /joint_states" in said
    check(got, RIGHT)


def test_messages_without_a_stamp_have_the_logs_times(tmp_path):
    write_mcap(tmp_path / "log.mcap", static(joint_states(X.q, X.v, X.i, sent=[0] * N)))
    got, said = imported(tmp_path, tmp_path / "log.mcap")
    assert f"{N} messages have no stamp; the time at which the log received them is taken" in said
    check(got, RIGHT)


def test_a_stamp_that_stands_still_is_told_and_the_first_message_kept(tmp_path):
    at = np.array(stamps(N))
    sent = at.copy()
    sent[300:340] = sent[300]
    write_mcap(tmp_path / "log.mcap", static(joint_states(X.q, X.v, X.i, at, sent)))
    got, said = imported(tmp_path, tmp_path / "log.mcap")
    kept = np.delete(np.arange(N), np.arange(301, 340))
    assert "39 messages repeat a stamp; the first of each is kept" in said
    check(got, {name: values[kept] for name, values in RIGHT.items()})


def test_messages_that_came_out_of_order_are_sorted_by_their_stamps(tmp_path):
    at = np.array(stamps(N))
    write_db3(tmp_path / "log.db3", static(joint_states(X.q[FIVES], X.v[FIVES], X.i[FIVES], at, at[FIVES])))
    got, said = imported(tmp_path, tmp_path / "log.db3")
    assert "time runs back 600 times; rows are sorted by it" in said
    check(got, RIGHT)


@pytest.mark.parametrize(
    ("q", "v", "effort", "words"),
    [(np.degrees(X.q), X.v, X.i, "joint_rad: arm.position says rad and holds -67.19 .. 68.73: degrees?"),
     (np.degrees(X.q), np.degrees(X.v), X.i, "joint_rad: arm.position says rad and holds -67.19 .. 68.73: degrees?"),
     (X.q, X.v, np.abs(X.i), "joint_torque_Nm: arm.effort is never below zero: its sign is missing"),
     (X.q, X.v, -X.i, "joint_torque_Nm: it works against the motion of joint_rad")],
)  # fmt: skip
@pytest.mark.parametrize("write", [write_mcap, write_db3])
def test_what_a_log_does_not_say_is_doubted_aloud(tmp_path, q, v, effort, words, write):
    write(tmp_path / "log", static(joint_states(q, v, effort)))
    assert f"unsure: {words}" in imported(tmp_path, "--suggest", tmp_path / "log")[1]
    _, said = imported(tmp_path, tmp_path / "log", status=2)  # without --suggest it is no recording
    assert words in said and len(said.splitlines()) == 1


def test_a_log_of_other_messages_gets_one_line(tmp_path):
    empty = {"/joint_states": ("sensor_msgs/msg/JointState", JOINT_STATE, [])}
    write_db3(tmp_path / "log.db3", {"/battery": ("sensor_msgs/msg/BatteryState", "", [])})
    assert "no JointState or DynamicJointState in it; found /battery (sensor_msgs/msg/BatteryState)" in imported(tmp_path, tmp_path / "log.db3", status=2)[1]
    write_db3(tmp_path / "empty.db3", empty)
    _, said = imported(tmp_path, tmp_path / "empty.db3", status=2)
    assert said == f"talus-import: {tmp_path}/empty.db3: no joint state in it\n"


def test_one_message_is_too_few_in_one_line(tmp_path):
    write_mcap(tmp_path / "log.mcap", static(joint_states(X.q[:1], X.v[:1], X.i[:1])))
    assert len(imported(tmp_path, tmp_path / "log.mcap", status=2)[1].splitlines()) == 1


# ---- tables ---------------------------------------------------------------------------------


def write_parquet(path, log):
    pyarrow.parquet.write_table(pyarrow.table(log), path)


def write_hdf5(path, log):
    with h5py.File(path, "w") as file:
        for name, values in log.items():
            file[f"log/{name}"] = values


TABLES = {
    "parquet": write_parquet,
    "h5": write_hdf5,
    "mat": lambda path, log: scipy.io.savemat(path, {"log": log}),
    "7.3": lambda path, log: write_matlab73(path, {"log": log, "note": "an arm on Tuesday", "same length": "x" * N}),
}
SURE = {"time_s": X.t, "angle_deg": np.degrees(X.q), "current_A": X.i}
ANGLE_AND_CURRENT = {"time_s": X.t, "joint_rad": X.q, "joint_current_A": X.i}
TURNED = {"time_s": SPIN.t, "joint_rad": SPIN.q, "joint_current_A": SPIN.i}
WORD = np.round(1000 * X.i).astype(np.int64)
COUNTS = np.floor(SPIN.q / (2 * np.pi) * 65536).astype(np.int64)
DISORDERS = {  # what stands in the file, what is right, how near, and what is said
    "none": (SURE, ANGLE_AND_CURRENT, 1e-9, ""),
    "degrees without a unit": (
        {"time_s": X.t, "angle": np.degrees(X.q), "current_A": X.i}, ANGLE_AND_CURRENT, 1e-9, "unsure: joint_rad: angle: its header has no unit; taken for deg"),
    "unsorted": ({name: values[FIVES] for name, values in SURE.items()}, ANGLE_AND_CURRENT, 1e-9, "time runs back 600 times; rows are sorted by it"),
    "repeated": ({name: values[TWICE] for name, values in SURE.items()}, ANGLE_AND_CURRENT, 1e-9, "100 rows repeat a time; the first of each is kept"),
    "unsigned current": (
        SURE | {"current_A": np.abs(X.i)}, ANGLE_AND_CURRENT | {"joint_current_A": np.abs(X.i)}, 1e-9, "unsure: joint_current_A: current is never below zero"),
    "words of 16 bits": (
        {"time_s": X.t, "angle_deg": np.degrees(X.q), "current_mA": WORD.astype(np.uint16)}, ANGLE_AND_CURRENT, 6e-4, "starts again every 65536 mA"),
    "words of 32 bits": (
        {"time_s": X.t, "angle_deg": np.degrees(X.q), "current_mA": WORD.astype(np.uint32)}, ANGLE_AND_CURRENT, 6e-4, "starts again every 4.29497e+09 mA"),
    "counts": ({"time_s": SPIN.t, "encoder": (COUNTS // 4 % 16384).astype(np.uint16), "current_A": SPIN.i}, TURNED, 5e-4, "unsure: joint_rad: encoder starts again"),
    "counts with a sign": ({"time_s": SPIN.t, "encoder": COUNTS.astype(np.int16), "current_A": SPIN.i}, TURNED, 2e-4, "taken for turn/65536"),
    "angles from 0 to 360": (
        {"time_s": SPIN.t, "angle_deg": (np.degrees(SPIN.q) % 360).astype(np.float32), "current_A": SPIN.i}, TURNED, 1e-6, "starts again every 360 deg"),
    "nanoseconds": ({"stamp_ns": np.array(stamps(N), dtype=np.uint64), "angle_deg": np.degrees(X.q), "current_A": X.i}, ANGLE_AND_CURRENT, 1e-9, ""),
}  # fmt: skip


def in_turn():
    """Every disorder in one format, formats in turn; all others in the long run."""
    for i, name in enumerate(DISORDERS):
        for k, kind in enumerate(TABLES):
            yield pytest.param(kind, name, marks=[] if i % len(TABLES) == k else pytest.mark.long)


@pytest.mark.parametrize("kind, name", in_turn())
def test_disorders_within_binary_tables(tmp_path, kind, name):
    log, expected, tolerance, words = DISORDERS[name]
    path = tmp_path / f"log.{'mat' if kind == '7.3' else kind}"
    TABLES[kind](path, log)
    got, said = imported(tmp_path, "--suggest", path)
    assert words in said.replace("log.", "")
    got["joint_rad"] = got["joint_rad"] - 2 * np.pi * np.round((got["joint_rad"] - expected["joint_rad"])[0] / (2 * np.pi))
    check(got, expected, tolerance)


@pytest.mark.parametrize("kind", TABLES)
def test_a_timer_that_overflows_gets_one_line(tmp_path, kind):
    path = tmp_path / f"log.{'mat' if kind == '7.3' else kind}"
    timer = (4000 * np.arange(N) + 2**32 - 3_000_000).astype(np.uint64).astype(np.uint32)
    TABLES[kind](path, {"time_us": timer, "angle_deg": np.degrees(X.q), "current_A": X.i})
    _, said = imported(tmp_path, "--suggest", path, status=2)
    assert "starts anew: two recordings in one file, or a clock that was set; cut it there" in said and len(said.splitlines()) == 1


def test_texts_and_what_is_empty_are_no_columns_of_matlab_73(tmp_path):
    """A text is kept there as numbers, one a letter; of an empty array its shape."""
    write_matlab73(tmp_path / "log.mat", {"log": SURE | {"comment": "x" * N}, "note": "an arm"})
    with h5py.File(tmp_path / "log.mat", "r+") as file:
        file.create_dataset("nothing", data=np.zeros(2, dtype=np.uint64)).attrs["MATLAB_empty"] = np.uint8(1)
    got, said = imported(tmp_path, tmp_path / "log.mat")
    assert "note" not in said and "nothing" not in said and "comment" not in said
    check(got, ANGLE_AND_CURRENT)
    _, said = imported(tmp_path, "--map", "time_s=log.time:s", "--map", "joint_rad=log.comment:rad", tmp_path / "log.mat", status=2)
    assert "no column 'log.comment'" in said
