"""From a leg that moves to a recording with the camera's angles: filmed, tracked, aligned, merged, identified."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from marker_scenes import rms
from scipy.interpolate import CubicSpline
from support import REPOSITORY, run

pytestmark = pytest.mark.long
MODEL, BENT, FOCAL_PX = REPOSITORY / "models/leg.yaml", (-0.12, 0.03, 0.0004, -0.0003), 1800
LENS = """%YAML:1.0
---
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ {f}., 0., 959.5, 0., {f}., 539.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 4
   cols: 1
   dt: d
   data: [ {bent} ]
"""


def table(path):
    return np.genfromtxt(path, delimiter=",", names=True)


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A bench's recording, and the film of the same leg: 1080p at 120 Hz in MJPEG, from a camera that stands askew, with a lens that
    bends, a clock of its own, jitter, pictures that are lost, and bars that pass."""
    folder = tmp_path_factory.mktemp("whole")
    run("talus-sim", "--model", MODEL, "--out", folder / "walk.csv", "--motion", folder / "motion.csv", "--duration", 12, "--period", 20,
        "--rate", 200)  # fmt: skip
    film = [sys.executable, "-m", "film", "--motion", folder / "motion.csv", "--out", folder / "film.mov", "--truth", folder / "truth.csv",
            "--codec", "mjpeg", "--begin", 2, "--duration", 7, "--rate", 120, "--width", 1920, "--offset", 3.217, "--drift-ppm", 80,
            "--jitter", 3e-4, "--drop", 0.01, "--passing", 2, "--near-markers", "--turn", 0.05, -0.03, 0.02, "--distortion", *BENT]  # fmt: skip
    subprocess.run(list(map(str, film)), check=True, env={**os.environ, "PYTHONPATH": str(REPOSITORY / "tools")})
    (folder / "lens.yaml").write_text(LENS.format(f=FOCAL_PX, bent=", ".join(map(str, BENT))))
    return folder


@pytest.fixture(scope="module")
def merged(filmed):
    """The recording with the camera's angles, by the commands that docs/talus-track.md names."""
    setup, track, film, truth = filmed / "setup.yaml", filmed / "track.csv", filmed / "film.mov", table(filmed / "truth.csv")
    pose = f"{truth['shank_rad'][0]:.9f},{truth['foot_rad'][0]:.9f}"
    run("talus-track", "calibrate", "--out", setup, "--shank-length", 0.3615, "--lens", "lens.yaml", "--pose", pose, film)
    run("talus-track", "--setup", setup, "--out", track, film)
    run("talus-track", "tilt", "--setup", setup, "--out", setup, track)
    run("talus-track", "--setup", setup, "--out", track, film)
    run("talus-track", "align", "--recording", filmed / "walk.csv", "--out", filmed / "merged.csv", "--report", filmed / "align.json", track)
    return table(filmed / "merged.csv")


def test_angles_are_the_legs_to_a_milliradian(filmed, merged):
    motion = table(filmed / "motion.csv")
    shank = CubicSpline(motion["time_s"], motion["knee_position_rad"])(merged["time_s"])
    foot = shank + CubicSpline(motion["time_s"], motion["ankle_position_rad"])(merged["time_s"])
    valid = merged["valid"] == 1
    error = rms((merged["shank_rad"] - shank)[valid]), rms((merged["foot_rad"] - foot)[valid])
    print(f"{valid.sum()} rows, {(~valid).sum()} without a marker; angles off by {1e3 * np.array(error)} mrad RMS")
    assert max(error) <= 1e-3 and 0 < (~valid).sum() < 0.2 * len(valid)


def test_the_clock_is_the_recordings(filmed, merged):
    truth, report = table(filmed / "truth.csv"), json.loads((filmed / "align.json").read_text())
    at = report["at_camera_s"]
    off_s = report["offset_s"] + at - np.interp(at, truth["time_s"], truth["motion_s"])
    print(f"clock off by {1e3 * off_s:.4f} ms, stated {1e3 * report['offset_sigma_s']:.4f}")
    assert abs(off_s) < 0.5e-3 and abs(off_s) < 3 * report["offset_sigma_s"]


def test_the_tilt_keeps_the_pose_of_the_calibration(filmed, merged):
    """The first picture of the second track has the pose that was told, though its tilt was not known then."""
    truth, track = table(filmed / "truth.csv"), table(filmed / "track.csv")
    assert abs(track["shank_rad"][0] - truth["shank_rad"][0]) < 1e-4 and abs(track["foot_rad"][0] - truth["foot_rad"][0]) < 1e-4


def test_every_command_reads_what_was_merged(filmed, merged):
    recording, report = filmed / "merged.csv", filmed / "gap.json"
    run("talus-identify", "--model", MODEL, "--out", filmed / "fitted.yaml", recording)
    run("talus-predict", "--model", filmed / "fitted.yaml", "--out", filmed / "predicted.csv", recording)
    run("talus-gap", "--quick", "--model", MODEL, "--report", report, recording)
    assert len(table(filmed / "predicted.csv")) == len(merged)
    assert json.loads(report.read_text())["verdict"]["effect"]
