"""talus-import: files as people have them (import_files.py) against the closed form that they were made from, bad input, the map."""

import contextlib
import io
import shlex
import sys

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
import scipy.io
import talus
from import_files import N, cases, table, truth, write_bag, write_mdf
from support import REPOSITORY, run
from talus.importing import assemble, clock, command, formats, guess, headers, suggest
from talus.importing.table import Column
from talus.refused import Refused

# Not to be had from the file alone; each must be doubted aloud or refused in one line.
NOT_IN_THE_FILE = {"headless", "two_clocks_apart", "clock_starts_anew", "unsigned_current", "turned_sign", "degrees_said_to_be_rad",
                   "currents_of_phases", "rotor_alone"}  # fmt: skip
LEAST_RIGHT = 39


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    """{case: (right, refused or doubted, its words)} of --suggest, without a hand."""
    folder = tmp_path_factory.mktemp("import")
    return {case.name: outcome(case, folder / f"{case.name}.out.csv") for case in cases(folder)}


def within(*arguments):
    """(status, printed, said) of the program within this process: a start takes half a second. Some of each kind are started: what a
    library writes past Python is seen from outside alone."""
    with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.redirect_stderr(io.StringIO()) as said:
        status = command.main([str(argument) for argument in arguments])
    return status, printed.getvalue(), said.getvalue()


def imported(*arguments):
    """(printed, said) of what goes well."""
    status, *words = within(*arguments)
    assert status == 0, words
    return words


def outcome(case, out):
    status, _, said = within("--suggest", "--out", out, *case.paths)
    assert status in (0, 2)
    if status == 2:
        assert len(said.splitlines()) == 1 and said.startswith("talus-import: ") and not out.exists()
        return False, True, said
    wrong = wrong_columns(talus.Recording.read(out), case)
    doubted = all(f"unsure: {name}" in said for name in wrong)
    return not wrong, doubted and bool(wrong), f"wrong: {wrong}\n{said}"


def wrong_columns(recording, case):
    """Which columns are not what the file was made from; time counts from the first row on, where the file's clock is Unix."""
    got = dict(recording.columns)
    if set(got) != set(case.columns) or len(got["time_s"]) != len(case.columns["time_s"]):
        return sorted(set(got) ^ set(case.columns)) or ["time_s"]
    got["time_s"] = got["time_s"] - got["time_s"][0] + case.columns["time_s"][0]
    return [n for n, x in case.columns.items() if np.abs(got[n] - x).max() > case.tolerance * max(1, np.abs(x).max())]


def test_most_files_are_right_without_a_hand_and_none_is_silently_wrong(outcomes):
    right = [name for name, (ok, _, _) in outcomes.items() if ok]
    silent = {name: words for name, (ok, said, words) in outcomes.items() if not ok and not said}
    print(f"\n{len(outcomes)} files: {len(right)} right without a hand, {len(outcomes) - len(right) - len(silent)} refused or doubted, {len(silent)} silently wrong")
    assert silent == {}
    assert len(outcomes) >= 40 and len(right) >= LEAST_RIGHT
    assert set(outcomes) - set(right) == NOT_IN_THE_FILE, {n: outcomes[n][2] for n in set(outcomes) - set(right) - NOT_IN_THE_FILE}


def test_what_the_headers_say_needs_no_suggestion(tmp_path):
    x = truth()
    (tmp_path / "sure.csv").write_text(table(["Zeit [ms]", "Winkel [°]", "Strom [mA]"], [1000 * x.t, np.degrees(x.q), 1000 * x.i], ";", ","))
    run("talus-import", "--out", tmp_path / "rec.csv", tmp_path / "sure.csv")
    got = talus.Recording.read(tmp_path / "rec.csv").columns
    for name, expected in (("time_s", x.t), ("joint_rad", x.q), ("joint_current_A", x.i)):
        assert got[name] == pytest.approx(expected, abs=1e-8)
    (tmp_path / "unsure.csv").write_text(table(["Zeit", "Winkel", "Strom"], [x.t, x.q, x.i]))
    done = run("talus-import", "--out", tmp_path / "no.csv", tmp_path / "unsure.csv", status=2)
    assert "unsure: time_s" in done.stderr and "(and 2 more)" in done.stderr and not (tmp_path / "no.csv").exists()


def test_map_by_hand(tmp_path):
    """Sign, zero, wrap, unit expressions and an offset between clocks, against the closed form."""
    x = truth(turns=1.0)
    counts = (8211 - np.round(x.q / 2 / np.pi * 4096).astype(int)) % 4096
    (tmp_path / "a.csv").write_text(table(["tick", "enc: raw"], [x.t, counts], "\t"))
    (tmp_path / "b.csv").write_text(table(["tick", "iq"], [x.t + 7.5, -10 * x.i], ";"))
    (tmp_path / "map.yaml").write_text(
        "plant: pendulum\ncolumns:\n  time_s: {source: tick, unit: s}\n"
        "  joint_rad: {source: 'enc: raw', unit: turn/4096, sign: -1, zero: 8211, wrap: 4096}\n"
        "  joint_current_A: {source: iq, unit: 0.1 A, sign: -1, file: 2}\nclocks: {2: {offset_s: -7.5}}\n"
    )
    run("talus-import", "--map", tmp_path / "map.yaml", "--out", tmp_path / "rec.csv.gz", tmp_path / "a.csv", tmp_path / "b.csv")
    got = talus.Recording.read(tmp_path / "rec.csv.gz").columns
    turns = np.round((got["joint_rad"] - x.q) / 2 / np.pi)  # where a wrapped encoder begins is anybody's guess
    assert np.ptp(turns) == 0 and got["joint_rad"] - 2 * np.pi * turns == pytest.approx(x.q, abs=np.pi / 4096 * 1.01)
    assert got["joint_current_A"] == pytest.approx(x.i, abs=1e-7)


def test_a_suggested_map_is_taken_back(tmp_path):
    x = truth()
    (tmp_path / "log.csv").write_text(table(["Zeit", "Winkel", "Strom"], [1000 * x.t, np.degrees(x.q), 1000 * x.i], ";", ","))
    done = run("talus-import", "--suggest", tmp_path / "log.csv")
    (tmp_path / "map.yaml").write_text(done.stdout)
    assert done.stdout.count("# unsure: ") == done.stderr.count("unsure: ") == 3
    imported("--map", tmp_path / "map.yaml", "--out", tmp_path / "a.csv", tmp_path / "log.csv")
    imported("--suggest", "--out", tmp_path / "b.csv", tmp_path / "log.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


@pytest.mark.parametrize("kind", ["csv", "mat", "h5", "parquet", "mf4"])
def test_identified_from_the_import_is_identified_from_the_original(tmp_path, kind):
    """Bar: 1e-9 relative for what loses nothing. Import writes every digit, so that the model file is the same byte by byte."""
    import h5py
    import pyarrow.parquet
    import scipy.io

    model = REPOSITORY / "models/pendulum.yaml"
    run("talus-sim", "--model", model, "--out", tmp_path / "arm.csv", "--duration", 10)
    columns = talus.Recording.read(tmp_path / "arm.csv").columns
    path = tmp_path / f"again.{kind}"
    if kind == "csv":
        path.write_text(table(list(columns), list(columns.values()), ";", ",", digits=17))
    elif kind == "mat":
        scipy.io.savemat(path, columns)
    elif kind == "h5":
        with h5py.File(path, "w") as file:
            for name, values in columns.items():
                file[name] = values
    elif kind == "parquet":
        pyarrow.parquet.write_table(pyarrow.table(columns), path)
    else:
        write_mdf(path, [[(name, "", columns["time_s"], values) for name, values in columns.items() if name != "time_s"]])
    imported("--out", tmp_path / "rec.csv", path)
    for name in ("arm", "rec"):
        run("talus-identify", "--model", model, "--out", tmp_path / f"{name}.yaml", tmp_path / f"{name}.csv")
    one, other = (talus.Model.read(tmp_path / f"{name}.yaml").parameters for name in ("arm", "rec"))
    for name, value in one.items():
        assert other[name] == pytest.approx(value, rel=1e-9, abs=1e-15)


def test_the_line_that_a_program_advises_makes_a_recording_that_it_reads(tmp_path):
    x = truth()
    (tmp_path / "rec 1.csv").write_text(table(["Zeit [s]", "Weg [mm]", "Kraft [N]"], [x.t, 100 * x.q, 40 * x.i], ";", ","), encoding="utf-16")
    predict = ["talus-predict", "--model", REPOSITORY / "models/slider.yaml", "--out", tmp_path / "p.csv"]
    advice = run(*predict, "rec 1.csv", status=2, cwd=tmp_path).stderr.partition("; try: ")[2]
    name, *arguments = shlex.split(advice)
    run(name, *arguments, cwd=tmp_path)
    assert talus.Recording.read(tmp_path / "recording.csv").columns["slider_m"] == pytest.approx(0.1 * x.q, abs=1e-9)
    run(*predict, "recording.csv", cwd=tmp_path)


@pytest.mark.parametrize("program", ["talus-predict", "talus-identify", "talus-gap"])
def test_a_robots_log_that_is_a_folder_gets_such_a_line_too(tmp_path, program):
    write_bag(tmp_path / "bag", "mcap", truth())
    given = [program, "--model", REPOSITORY / "models/pendulum.yaml", "--report" if program == "talus-gap" else "--out", tmp_path / "out", "bag"]
    said = run(*given, status=2, cwd=tmp_path).stderr
    assert "bag: is a directory, expected a file; try: talus-import" in said and said.count("\n") == 1
    name, *arguments = shlex.split(said.partition("; try: ")[2])
    run(name, *arguments, cwd=tmp_path)
    assert talus.Recording.read(tmp_path / "recording.csv").columns["joint_rad"] == pytest.approx(truth().q, abs=1e-9)


@pytest.mark.parametrize("suffix", [".parquet", ".mat"])
def test_an_element_of_a_list_or_a_matrix_is_taken_by_its_number(tmp_path, suffix):
    """As LeRobot's tables and MATLAB's logs have them: torque first here, the angle second."""
    x, path = truth(), tmp_path / f"log{suffix}"
    state = np.stack([x.i, x.q], axis=1)
    if suffix == ".parquet":
        pyarrow.parquet.write_table(pyarrow.table({"timestamp": x.t, "observation.state": list(state)}), path)
    else:
        scipy.io.savemat(path, {"timestamp": x.t, "observation": {"state": state}})
    maps = ["--map", "time_s=timestamp:s", "--map", "joint_current_A=observation.state[0]:A"]
    imported("--plant", "pendulum", *maps, "--map", "joint_rad=observation.state[1]:rad", "--out", tmp_path / "r.csv", path)
    got = talus.Recording.read(tmp_path / "r.csv").columns
    assert got["joint_rad"] == pytest.approx(x.q, abs=1e-12) and got["joint_current_A"] == pytest.approx(x.i, abs=1e-12)
    bare = run("talus-import", "--plant", "pendulum", *maps, "--map", "joint_rad=observation.state:rad", "--out", tmp_path / "b.csv", path, status=2)
    assert bare.stderr == "talus-import: joint_rad: 'observation.state' is more than one column; expected one of observation.state[0], observation.state[1]\n"
    assert not (tmp_path / "b.csv").exists()


def test_a_name_that_stands_twice_is_told_apart_by_its_unit_or_its_number(tmp_path):
    """And a column may be called as its header writes it."""
    x, out = truth(), tmp_path / "r.csv"
    (tmp_path / "log.csv").write_text(table(["time_s", "angle_deg", "angle_rad", "current_A"], [x.t, np.degrees(x.q) + 7, x.q, x.i], digits=15))
    rest = ["--map", "joint_current_A=current_A:A", "--out", out, tmp_path / "log.csv"]
    refused_within("joint_rad: 'angle' is more than one column; expected one of angle (1) [deg], angle (2) [rad]", "--map", "time_s=time_s:s", "--map", "joint_rad=angle:rad", *rest)
    assert not out.exists()
    for name in ("angle_rad", "angle [rad]", "angle (2)", "angle (2) [rad]"):
        imported("--map", "time_s=time:s", "--map", f"joint_rad={name}:rad", *rest)
        assert talus.Recording.read(out).columns["joint_rad"] == pytest.approx(x.q, abs=1e-12)
    _, said = imported("--suggest", "--out", out, tmp_path / "log.csv")
    assert "unsure: joint_rad: angle (1) is taken, the first that fits; it may be angle (2)" in said


def test_lists_of_a_table_keep_their_names_and_their_holes(tmp_path):
    """Of a fixed length, of one number, without any in some rows; a unit that stands beside the field."""
    x, hole = truth(), 700
    state = [None if k == hole else [i, q] for k, (i, q) in enumerate(zip(x.i.tolist(), np.degrees(x.q).tolist(), strict=True))]
    kind = pyarrow.list_(pyarrow.float64(), 2)
    fields = [pyarrow.field("timestamp", pyarrow.float64()), pyarrow.field("state", kind, metadata={"unit": "deg"}), pyarrow.field("effort", pyarrow.list_(pyarrow.float64()))]
    columns = [pyarrow.array(x.t), pyarrow.array(state, kind), pyarrow.array([[i] for i in x.i])]
    pyarrow.parquet.write_table(pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(fields)), tmp_path / "log.parquet")
    maps = ["--map", "time_s=timestamp:s", "--map", "joint_rad=state[1]", "--map", "joint_current_A=effort[0]:A"]
    imported(*maps, "--out", tmp_path / "r.csv", tmp_path / "log.parquet")
    there, got = np.arange(N) != hole, talus.Recording.read(tmp_path / "r.csv").columns
    assert got["time_s"] == pytest.approx(x.t[there], abs=1e-12) and got["joint_rad"] == pytest.approx(x.q[there], abs=1e-12)
    assert got["joint_current_A"] == pytest.approx(x.i[there], abs=1e-12)


@pytest.mark.parametrize("suffix", [".parquet", ".mat", ".h5"])
def test_what_is_drafted_of_a_list_or_a_matrix_is_doubted_and_taken_back(tmp_path, suffix):
    import h5py

    x, path = truth(), tmp_path / f"log{suffix}"
    angles = np.stack([x.q, 0.3 * x.q + 0.1], axis=1)
    if suffix == ".parquet":
        pyarrow.parquet.write_table(pyarrow.table({"timestamp": x.t, "position_rad": list(angles), "current_A": x.i}), path)
    elif suffix == ".mat":
        scipy.io.savemat(path, {"timestamp": x.t, "position_rad": angles, "current_A": x.i})
    else:
        with h5py.File(path, "w") as file:
            file["timestamp"], file["position"], file["current_A"] = x.t, angles.T, x.i  # as MATLAB 7.3 lays a matrix
            file["position"].attrs["unit"] = "rad"
    printed, said = imported("--suggest", path)
    assert "unsure: joint_rad: position[0] is taken, the first that fits; it may be position[1]" in said
    assert "source: position[0]\n    unit: rad" in printed and "joint_rad: position[0]: its header has no unit" not in said
    for number in (0, 1):
        (tmp_path / "map.yaml").write_text(printed.replace("source: position[0]", f"source: position[{number}]"))
        imported("--map", tmp_path / "map.yaml", "--out", tmp_path / "r.csv", path)
        assert talus.Recording.read(tmp_path / "r.csv").columns["joint_rad"] == pytest.approx(angles[:, number], abs=1e-12)


def test_lists_whose_name_says_nothing_are_named_in_one_line(tmp_path):
    x = truth()
    pyarrow.parquet.write_table(pyarrow.table({"timestamp": x.t, "observation.state": list(np.stack([x.q, x.i], axis=1))}), tmp_path / "log.parquet")
    refused("observation.state[0], observation.state[1]; --map 'joint_rad=COLUMN:UNIT' says which", "--suggest", tmp_path / "log.parquet")


# ---- parts -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("Winkel [°]", "Winkel", "°"), ("pos (deg)", "pos", "deg"), ("Strom / mA", "Strom", "mA"), ("t in ms", "t", "ms"),
        ("joint_velocity_rad_s", "joint_velocity", "rad_s"), ("timeMs", "time", "ms"), ("knee_current_A", "knee_current", "A"),
        ("torque_Nm", "torque", "Nm"), ("state[0]", "state[0]", None), ("state[0] [rad]", "state[0]", "rad"), ("angle_deg[2]", "angle[2]", "deg"), ("q_1", "q_1", None), ("joint 1", "joint 1", None), ("temp, °C", "temp", "°C"), ("i", "i", None),
    ],
)  # fmt: skip
def test_names_and_units_of_headers(header, name, unit):
    assert headers.split(header) == (name, unit)


@pytest.mark.parametrize(
    ("unit", "column", "factor", "offset"),
    [
        ("°", "joint_rad", np.pi / 180, 0), ("turn/4096", "joint_rad", 2 * np.pi / 4096, 0), ("U/min", "joint_velocity_rad_s", np.pi / 30, 0),
        ("mA", "joint_current_A", 1e-3, 0), ("N*cm", "joint_torque_Nm", 0.01, 0), ("K", "joint_temp_C", 1, -273.15),
        ("°F", "joint_temp_C", 5 / 9, -160 / 9), ("mm", "slider_m", 1e-3, 0), ("kN", "slider_force_N", 1e3, 0),
    ],
)  # fmt: skip
def test_units(unit, column, factor, offset):
    assert headers.conversion(unit, column) == pytest.approx((factor, offset), rel=1e-12, abs=1e-9)


@pytest.mark.parametrize(("unit", "column"), [("count", "joint_rad"), ("A", "joint_rad"), ("s", "joint_current_A"), ("bogus", "joint_rad"), ("((", "joint_rad")])
def test_a_unit_of_something_else_is_refused(unit, column):
    with pytest.raises(Refused, match="is no unit for it"):
        headers.conversion(unit, column)


def test_nanoseconds_since_1970_lose_nothing():
    """Uneven instants one nanosecond apart in their last digit, which a double cannot hold."""
    ns = 1_716_123_456_123_456_789 + 4_000_001 * np.arange(300) + (np.arange(300) * 7919) % 13
    times = clock.read(Column("t", "ns", [str(k) for k in ns], range(300)), "nanosecond", "x", [])
    assert [round(1e9 * s) for s in times.seconds()] == (ns - ns[0]).tolist()
    assert times.before == clock.Fraction(int(ns[0]), 10**9)


@pytest.mark.parametrize("hertz", [400, 240, 2000, 1500])
def test_even_times_rounded_to_milliseconds_are_found_again(hertz):
    true = np.arange(2000) / hertz
    words = []
    times = clock.read(Column("t", "ms", [str(round(1000 * t)) for t in true], range(2000)), "millisecond", "x", words)
    assert len(times.rows) == 2000 and times.seconds() == pytest.approx(true, abs=2e-4) and "rounded to 1 ms" in words[0]


@pytest.mark.parametrize("lost", [[700], [300, 301, 900], list(range(0, 2000, 97))])
def test_lost_samples_are_not_taken_for_rounding(lost):
    """An even clock without some of its samples: the times that stand there stay."""
    ms = np.delete(np.arange(2000), lost)
    words = []
    times = clock.read(Column("t", "ms", [str(t) for t in ms], range(len(ms))), "millisecond", "x", words)
    assert times.seconds().tolist() == (ms / 1000).tolist() and words == []


def test_a_clock_that_jitters_by_more_than_its_rounding_keeps_its_times():
    ms = np.sort(np.round(1000 * (np.arange(2000) / 100 + np.random.default_rng(2).normal(0, 0.002, 2000)))).astype(int)
    times = clock.read(Column("t", "ms", [str(t) for t in ms], range(2000)), "millisecond", "x", [])
    assert times.seconds().tolist() == (np.unique(ms) / 1000).tolist()


def test_wraps_are_found_only_where_a_sensor_starts_again():
    q = np.linspace(0, 40, 4001)
    assert guess.wrap(np.degrees(q) % 360, "deg", True) == 360
    assert guess.unwrap(np.degrees(q) % 360, 360, True) == pytest.approx(np.degrees(q))
    for smooth in (np.degrees(q), 180 * np.sin(q), np.where(q > 20, 300.0, 0.0) % 299):
        assert guess.wrap(smooth, "deg", True) is None


# ---- bad input ----------------------------------------------------------------------------

GOOD = table(["time_s", "joint_rad", "joint_current_A"], [truth().t, truth().q, truth().i])
MIDDLE = GOOD.splitlines()[700]
BAD = {
    "bus log": (b"(1436509052.249713) can0 044#2A366C2BBA\n(1436509052.449847) can0 0F6#7ADFE07BD2\n",
                "in.dat: a log of the bus, try: talus-acquire-export --dbc D.dbc --model M.yaml --out recording.csv"),
    "empty": ("", "empty"),
    "header only": (GOOD.splitlines()[0], "one line only"),
    "no table": ("Dear reader,\nthis is a letter\nand no table.\n" * 40, "no "),
    "too few": ("\n".join(GOOD.splitlines()[:60]), "expected at least 100"),
    "a word": (GOOD.replace(MIDDLE, MIDDLE.rsplit(",", 1)[0] + ",off"), ":701: joint_current: 'off' is not a number"),
    "a word for a time": (GOOD.replace(MIDDLE, "noon," + MIDDLE.split(",", 1)[1]), ":701: time: 'noon' is not a"),
    "a field too many": (GOOD.replace(MIDDLE, MIDDLE + ",7"), ":701: 4 fields, expected 3"),
    "a field too few": (GOOD.replace(MIDDLE, MIDDLE.rsplit(",", 1)[0]), ":701: 2 fields, expected 3"),
    "no time": (GOOD.replace("time_s", "wheel", 1), "no column looks like a time; found wheel, joint [rad], joint_current [A]"),
    "no current": (GOOD.replace("joint_current_A", "mood", 1), "nothing looks like joint_current_A or joint_torque_Nm"),
    "an immense time": (GOOD.replace(MIDDLE, "1e300," + MIDDLE.split(",", 1)[1]), ":701: time"),
    "MATLAB, cut": (b"MATLAB 5.0 MAT-file" + b" " * 90 + b"\0\1IM\x0e\0\0\0", "MATLAB file"),
    "HDF5, cut": (b"\x89HDF\r\n\x1a\n" + b"\0" * 100, "damaged HDF5 file"),
    "Parquet, cut": (b"PAR1" + b"\0" * 100, "damaged Parquet file"),
    "MCAP, cut": (b"\x89MCAP0\r\n" + b"\0" * 100, "damaged or no rosbag2"),
    "gzip, cut": (b"\x1f\x8b\x08\0\0\0", "damaged"),
}


def check_refusal(words, said):
    assert len(said.splitlines()) == 1 and said.startswith("talus-import: ") and words in said, said


def refused(words, *arguments):
    check_refusal(words, run("talus-import", *arguments, status=2).stderr)


def refused_within(words, *arguments):
    """What no library has a word in."""
    status, _, said = within(*arguments)
    assert status == 2
    check_refusal(words, said)


@pytest.mark.parametrize("name", BAD)
def test_bad_files_get_one_line_and_leave_the_output(tmp_path, name):
    content, words = BAD[name]
    path, out = tmp_path / "in.dat", tmp_path / "rec.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    out.write_text("before")
    refused(words, "--suggest", "--out", out, path)
    assert out.read_text() == "before" and len(list(tmp_path.iterdir())) == 2


def test_bad_usage_and_bad_maps(tmp_path):
    path, out = tmp_path / "in.csv", tmp_path / "rec.csv"
    path.write_text(GOOD)
    refused("--out is missing", path)
    refused_within("no file to import", "--out", out)
    refused_within("is an input and an output", "--out", path, path)
    refused_within("--plant: expected", "--out", out, "--plant", "dog", path)
    refused_within("No such file", "--out", out, tmp_path / "absent.csv")
    refused_within("expected MAP.yaml or COLUMN=SOURCE:UNIT", "--out", out, "--map", "x=", path)
    refused_within("is no column of a recording", "--out", out, "--map", "wheel=q:deg", path)
    refused_within("there is no column 'q'", "--out", out, "--map", "joint_rad=q:deg", "--map", "time_s=time:s", path)
    refused_within("'A' is no unit for it", "--out", out, "--map", "joint_rad=joint:A", "--map", "time_s=time:s", path)
    for text, words in (("columns: [", "is no YAML"), ("[]", "expected columns"), ("columns: {joint_rad: {source: q, colour: red}}", "unknown key colour"),
                        ("columns: {joint_rad: {source: q, sign: 2}}", "expected sign 1 or -1"), ("columns: {joint_rad: {source: q}}\nx: 1", "unknown key x"),
                        ("plant: dog\ncolumns: {joint_rad: {source: joint}}", "plant: expected"), ("columns: {joint_rad: 7}", "joint_rad: expected source")):  # fmt: skip
        (tmp_path / "map.yaml").write_text(text)
        refused_within(words, "--out", out, "--map", tmp_path / "map.yaml", path)


def test_mutated_files_never_end_in_a_traceback(tmp_path):
    """Bytes of good files changed, cut and doubled: in this process, because a start takes long."""
    rng, ends = np.random.default_rng(5), {"read": 0, "refused": 0}
    for number, case in enumerate(cases(tmp_path)):
        data = case.paths[0].read_bytes() if case.paths[0].is_file() else b""
        for kind in [number % 4] if data else []:
            bad = bytearray(data)
            for at in rng.integers(0, min(len(bad), 4000), 8 if kind < 2 else 0):
                bad[at] = rng.integers(0, 256) if kind else rng.choice(list(b',;.\n"\t -e9'))
            bad = bad[: rng.integers(1, len(bad))] if kind == 2 else bad[: len(bad) // 3] + bad[len(bad) // 4 :] if kind == 3 else bad
            path = tmp_path / f"bad{case.paths[0].suffix}"
            path.write_bytes(bytes(bad))
            try:
                tables = formats.read(str(path))
                found = suggest.Suggestion(tables)
                b"".join(assemble.recording(tables, found.map, found.times, []).text())
                ends["read"] += 1
            except Refused as refusal:
                assert refusal.status == 2 and refusal.text
                ends["refused"] += 1
    assert min(ends.values()) > 5, ends


# ---- ASAM MDF -----------------------------------------------------------------------------

TURNING = truth()
ANGLE = ("angle", "deg", TURNING.t, np.degrees(TURNING.q))
CURRENT = ("current", "mA", TURNING.t, 1000 * TURNING.i)


def whole_mdf(path):
    write_mdf(path, [[ANGLE, CURRENT]])


def no_group(path):
    write_mdf(path, [])


def no_sample(path):
    write_mdf(path, [[("angle", "deg", np.array([]), np.array([]))]])


def text_alone(path):
    write_mdf(path, [[("gear", "", TURNING.t, np.arange(N) % 2, {"val_0": 0, "text_0": "in", "val_1": 1, "text_1": "out"})]])


def frames_alone(path):
    import can

    with can.MF4Writer(str(path)) as log:
        for k in range(200):
            log(can.Message(timestamp=100 + k / 100, arbitration_id=5, data=b"abcd", is_rx=True, channel=0))


def cut_in_half(path):
    whole_mdf(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def begins_alike(path):
    path.write_bytes(b"MDF     4.10    and what follows is a letter\n" * 20)


def outside_of_its_record(path):
    """A channel's first bit, which asammdf itself does not look at in version 3, is its record's 60000th."""
    write_mdf(path.with_suffix(".mdf"), [[ANGLE]], version="3.30")  # it wants that suffix
    content = path.with_suffix(".mdf").read_bytes()
    at = content.index(b"CN\xe4\x00")  # a channel's block, 228 bytes
    at = at if content[at + 24] == 1 else content.index(b"CN\xe4\x00", at + 4)  # type 1: the clock
    path.write_bytes(content[: at + 186] + (60000).to_bytes(2, "little") + content[at + 188 :])


@pytest.mark.parametrize(
    ("write", "words"),
    [(no_group, "it is empty"), (no_sample, "no samples, left out: group 1"), (text_alone, "texts or arrays, left out: gear"),
     (frames_alone, "frames of a bus, to be decoded with their DBC first, left out: CAN_DataFrame"), (cut_in_half, "damaged or no MDF file"),
     (begins_alike, "damaged or no MDF file"), (outside_of_its_record, "stands outside of its record of 16 bytes")],
)  # fmt: skip
def test_mdf_files_without_a_measurement_get_one_line(tmp_path, write, words):
    write(tmp_path / "in.mf4")
    refused(words, "--suggest", "--out", tmp_path / "rec.csv", tmp_path / "in.mf4")
    assert not (tmp_path / "rec.csv").exists()


@pytest.mark.parametrize(("lost", "whole"), [(1, True), (2, False), (40, False)])
def test_where_one_group_of_an_mdf_pauses_is_a_gap(tmp_path, lost, whole):
    """One sample lost is two steps, and read between its neighbours; from three steps on (assemble.NEAR) nothing is invented."""
    x, there = TURNING, np.ones(N, bool)
    there[500 : 500 + lost] = False
    write_mdf(tmp_path / "in.mf4", [[ANGLE], [("current", "A", x.t[there], x.i[there])]])
    imported("--out", tmp_path / "rec.csv", tmp_path / "in.mf4")
    got, kept = talus.Recording.read(tmp_path / "rec.csv").columns, there | whole
    assert got["time_s"] == pytest.approx(x.t[kept], abs=1e-12) and got["joint_rad"] == pytest.approx(x.q[kept], abs=1e-12)
    assert got["joint_current_A"][there[kept]] == pytest.approx(x.i[there], abs=1e-12)
    assert got["joint_current_A"] == pytest.approx(np.interp(x.t[kept], x.t[there], x.i[there]), abs=1e-12)


def test_what_an_mdf_calls_invalid_is_missing(tmp_path):
    x, bad = TURNING, np.arange(N) % 100 == 7
    write_mdf(tmp_path / "in.mf4", [[ANGLE, ("current", "A", x.t, np.where(bad, 1e6, x.i))]], invalidation_bits=bad)
    run("talus-import", "--out", tmp_path / "rec.csv", tmp_path / "in.mf4")
    assert talus.Recording.read(tmp_path / "rec.csv").columns["joint_current_A"] == pytest.approx(x.i[~bad], abs=1e-12)


def test_the_clocks_of_an_mdf_are_files_of_the_map(tmp_path):
    """A name that two clocks have is told apart by the file; the time need not be said."""
    x, slow = TURNING, slice(None, None, 4)
    write_mdf(tmp_path / "in.mf4", [[("x", "", x.t, x.q), ("y", "", x.t, x.i)], [("x", "", x.t[slow], x.i[slow])]])
    arguments = ["--out", tmp_path / "rec.csv", tmp_path / "in.mf4"]
    refused_within("'x' stands in 2 files", "--map", "joint_rad=x:rad", "--map", "joint_current_A=y:A", *arguments)
    (tmp_path / "map.yaml").write_text("columns: {joint_rad: {source: x, unit: rad, file: 1}, joint_current_A: {source: x, unit: A, file: 2}}")
    imported("--map", tmp_path / "map.yaml", *arguments)
    got = talus.Recording.read(tmp_path / "rec.csv").columns
    assert got["joint_rad"] == pytest.approx(x.q[: N - 3], abs=1e-12)
    assert got["joint_current_A"] == pytest.approx(np.interp(x.t[: N - 3], x.t[slow], x.i[slow]), abs=1e-12)


@pytest.mark.parametrize(("sign", "speed", "words"), [(1, 1, None), (-1, 1, "joint_current_A: it works against"), (1, 2, "it is 2 times the derivative")])
def test_motion_is_looked_at_across_the_clocks_of_an_mdf(tmp_path, sign, speed, words):
    x, slow = TURNING, slice(None, None, 3)
    write_mdf(tmp_path / "in.mf4", [[("current", "A", x.t[slow], sign * x.i[slow])], [ANGLE], [("speed", "rad/s", x.t[::2], speed * x.v[::2])]])
    arguments = ["--out", tmp_path / "rec.csv", tmp_path / "in.mf4"]
    if words:
        refused_within(words, *arguments)
    imported("--suggest", *arguments)


@pytest.mark.parametrize("name", ["in.mf4", "in.zip", "in.gzip"])
def test_an_mdf_that_was_never_finished_is_read_and_stays_as_it_is(tmp_path, name):
    """asammdf completes such a file, and deletes those of some names."""
    whole_mdf(tmp_path / "whole.mf4")
    content = bytearray((tmp_path / "whole.mf4").read_bytes())
    content[:8], content[60] = b"UnFinMF ", 1 + 4  # counts of samples and the last block's length are to be made up
    (tmp_path / name).write_bytes(content)
    run("talus-import", "--out", tmp_path / "rec.csv", tmp_path / name)
    assert talus.Recording.read(tmp_path / "rec.csv").columns["joint_current_A"] == pytest.approx(TURNING.i, abs=1e-12)
    assert (tmp_path / name).read_bytes() == content


@pytest.mark.parametrize(("module", "package", "start"), [("h5py", "h5py", b"\x89HDF\r\n\x1a\n"), ("pyarrow.parquet", "pyarrow", b"PAR1"),
                                                          ("rosbags.highlevel", "rosbags", b"\x89MCAP0\r\n"), ("asammdf", "asammdf", b"MDF     4.10    "),
                                                          ("asammdf", "asammdf", b"UnFinMF 4.10    "), ("scipy.io", "scipy", b"MATLAB 5.0")])  # fmt: skip
def test_a_reader_that_is_missing_is_named(tmp_path, monkeypatch, module, package, start):
    (tmp_path / "in").write_bytes(start)
    monkeypatch.setitem(sys.modules, module, None)  # as if it were not installed
    with pytest.raises(Refused, match=f"needs the Python package {package}: pip install {package}") as refusal:
        formats.read(str(tmp_path / "in"))
    assert refusal.value.status == 1
