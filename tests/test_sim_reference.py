"""talus-sim --reference: a trajectory from a file, against SciPy's spline through the same rows; what is refused."""

import json

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from support import REPOSITORY, run

LEG, SLIDER = (REPOSITORY / f"models/{name}.yaml" for name in ("leg", "slider"))


def smooth_path(seconds=6.0, step_s=0.01):
    """(times, knee, ankle): swings that fade in and out."""
    t = np.arange(0, seconds + step_s / 2, step_s)
    fade = np.sin(np.pi * t / seconds) ** 4
    return t, 0.4 * fade * np.sin(4 * t), 0.2 * fade * np.sin(7 * t + 1)


def write(path, columns):
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    return path


def simulate(folder, reference, *more, model=LEG, status=0):
    return run("talus-sim", "--model", model, "--out", folder / "r.csv", "--motion", folder / "motion.csv",
               "--truth", folder / "truth.json", "--reference", reference, *more, status=status)  # fmt: skip


def columns_of(path):
    return np.genfromtxt(path, delimiter=",", names=True)


def test_the_bench_follows_the_spline_through_the_rows(tmp_path):
    t, knee, ankle = smooth_path()
    # columns in any order, others left aside, time that begins anywhere
    done = simulate(tmp_path, write(tmp_path / "t.csv", {"ankle_rad": ankle, "extra": t, "time_s": t + 3, "knee_rad": knee}))
    assert "not read" in done.stderr
    motion = columns_of(tmp_path / "motion.csv")
    assert abs(motion["time_s"][-1] - t[-1]) < 0.01
    for name, q, lag_rad in (("knee", knee, 0.03), ("ankle", ankle, 0.03)):
        spline = CubicSpline(t, q, bc_type="clamped")
        assert np.max(np.abs(motion[f"{name}_reference_rad"] - spline(motion["time_s"]))) < 1e-6
        assert np.max(np.abs(motion[f"{name}_position_rad"] - spline(motion["time_s"]))) < lag_rad
    excitation = json.loads((tmp_path / "truth.json").read_text())["excitation"]
    assert excitation["kind"] == "reference" and abs(excitation["length_s"] - t[-1]) < 1e-9


def test_speeds_and_torques_are_for_a_drive(tmp_path):
    t, knee, ankle = smooth_path(2.0)
    plain = {"time_s": t, "knee_rad": knee, "ankle_rad": ankle}
    simulate(tmp_path, write(tmp_path / "t.csv", plain))
    first = (tmp_path / "r.csv").read_bytes()
    done = simulate(tmp_path, write(tmp_path / "t.csv", plain | {"knee_torque_Nm": t, "ankle_velocity_rad_s": t}))
    assert "speeds and torques are not used" in done.stderr
    assert first == (tmp_path / "r.csv").read_bytes()


def test_the_same_options_give_the_same_bytes(tmp_path):
    t, knee, ankle = smooth_path(2.0)
    reference = write(tmp_path / "t.csv", {"time_s": t, "knee_rad": knee, "ankle_rad": ankle})
    simulate(tmp_path, reference)
    first = (tmp_path / "r.csv").read_bytes()
    simulate(tmp_path, reference)
    assert first == (tmp_path / "r.csv").read_bytes()


def test_rows_at_uneven_times_and_a_slider(tmp_path):
    t, q, _ = smooth_path(4.0)
    kept = np.random.default_rng(1).random(len(t)) > 0.3
    kept[[0, -1]] = True
    simulate(tmp_path, write(tmp_path / "t.csv", {"time_s": t[kept], "slider_m": 0.2 * q[kept]}), model=SLIDER)
    motion = columns_of(tmp_path / "motion.csv")
    spline = CubicSpline(t[kept], 0.2 * q[kept], bc_type="clamped")
    assert np.max(np.abs(motion["slider_reference_m"] - spline(motion["time_s"]))) < 1e-6


def test_a_trajectory_beyond_the_limits_is_refused_with_each_limit(tmp_path):
    t, knee, ankle = smooth_path()
    reference = write(tmp_path / "t.csv", {"time_s": t / 4, "knee_rad": 4 * knee, "ankle_rad": ankle})
    line = simulate(tmp_path, reference, status=2).stderr
    assert "knee position" in line and "knee speed" in line and "--fit" not in line
    assert not (tmp_path / "r.csv").exists()
    torque = simulate(tmp_path, write(tmp_path / "t.csv", {"time_s": t, "knee_rad": knee, "ankle_rad": ankle}), "--limits",
                      "ankle.torque=1e-4", status=2)  # fmt: skip
    assert "ankle torque" in torque.stderr


HEADER = "time_s,knee_rad,ankle_rad\n"
RISING = "".join(f"{0.01 * k},0,0\n" for k in range(12))


@pytest.mark.parametrize(("text", "words"), [
    ("", "the file is empty"), (HEADER + "0,0,0\n", "1 rows, expected at least 2"),
    ("time_s,knee_rad\n0,0\n", "missing column: ankle_rad; found time_s, knee_rad"),
    (HEADER.replace(",", ";") + "0;0;0\n", "found time_s, knee_rad, ankle_rad separated by ';', expected ','"),
    (HEADER + "0,0,nan\n", ":2: ankle_rad: 'nan' is not a finite number"), (HEADER + "0,x,0\n", ":2: knee_rad: 'x' is not a number"),
    (HEADER + "0,,0\n", "knee_rad: the field is empty"), (HEADER + "0,0\n", ":2: 2 fields, expected 3 as in the header"),
    (HEADER + "0,0,0\n0.01,0", ":3: truncated: the file ends within this line (2 of 3 fields)"),
    (HEADER + "0,0,0\n\n0.01,0,0\n", ":3: a blank line amid the samples"),
    (HEADER + RISING + "0.01,0,0\n", ":14: time_s does not rise"), ("time_s,time_s,knee_rad,ankle_rad\n", "twice"),
])  # fmt: skip
def test_bad_files_are_refused_with_their_line(tmp_path, text, words):
    (tmp_path / "t.csv").write_text(text)
    (tmp_path / "r.csv").write_text("earlier")
    line = simulate(tmp_path, tmp_path / "t.csv", status=2).stderr
    assert words in line and "t.csv" in line and line.count("\n") == 1
    assert (tmp_path / "r.csv").read_text() == "earlier"


@pytest.mark.parametrize("more", [("--excitation", "ramps"), ("--speed", "2"), ("--amplitude", "0.1"), ("--fit",)])
def test_other_motions_are_refused_beside_it(tmp_path, more):
    (tmp_path / "t.csv").write_text(HEADER + RISING)
    assert "--reference" in simulate(tmp_path, tmp_path / "t.csv", *more, status=2).stderr


def test_the_reference_is_not_written_over(tmp_path):
    (tmp_path / "t.csv").write_text(HEADER + RISING)
    line = run("talus-sim", "--model", LEG, "--out", tmp_path / "t.csv", "--reference", tmp_path / "t.csv", status=2).stderr
    assert "one file" in line
