"""talus-track on films of a simulated leg, on real ones, and on what is no film of a leg."""

import json
import subprocess
import sys

import numpy as np
import pytest
from film.camera import Camera
from film.encode import Video
from film.scene import Passing
from marker_scenes import FOOT_OFFSET_RAD, SMALL, film_of, passers, rms
from support import many, run

NAMES = ("knee", "ankle", "heel", "toe")
OUTSIDE = "/usr/share/doc/opencv-doc/examples/data"


def write_film(path, film, times, codec="h264"):
    """The truths of a film's pictures."""
    video, truths = Video(path, film.camera.width, film.camera.height, codec), []
    for t_s in times:
        picture, truth = film.take(t_s)
        video.add(picture, t_s - times[0])
        truths.append(truth)
    video.close()
    return truths


def track_of(path):
    table = np.genfromtxt(path, delimiter=",", names=True)
    centers = np.array([[table[f"{n}_x_px"], table[f"{n}_y_px"]] for n in NAMES]).transpose(2, 0, 1)
    return table, centers, np.array([table[f"{n}_flags"] for n in NAMES], int).T


def pose_of(truth):
    return f"{truth.shank_rad:.9f},{truth.foot_rad:.9f}"


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A second at 640 by 360, jittered, two pictures dropped, a bar that passes; its setup."""
    folder = tmp_path_factory.mktemp("film")
    random, times = np.random.default_rng(2), np.delete(np.arange(120) / 120, [50, 51])
    times[1:] += random.uniform(-5e-4, 5e-4, len(times) - 1)
    bar = Passing(0.2, 0.9, (-0.2, -0.36), (0.7, 0), half_m=0.02, length_m=0.2)
    film = film_of(2, camera=Camera(**SMALL), whole=True, passing=[bar])
    truths = write_film(folder / "film.mov", film, times, "mjpeg")
    run("talus-track", "calibrate", "--out", folder / "setup.yaml", "--shank-length", 0.3615, "--pose", pose_of(truths[0]),
        folder / "film.mov", "--sheet", folder / "found.png")  # fmt: skip
    return folder, truths


def test_a_film(filmed, tmp_path):
    folder, truths = filmed
    done = run("talus-track", "--setup", folder / "setup.yaml", "--out", tmp_path / "track.csv", "--report", tmp_path / "r.json",
               "--overlay", tmp_path / "overlay.avi", "--sheet", tmp_path / "sheet.png", folder / "film.mov")  # fmt: skip
    table, centers, flags = track_of(tmp_path / "track.csv")
    truth = np.array([t.center_px for t in truths])
    whole, clear = (flags & 0b10011) == 1, np.array([t.clear for t in truths])
    visible = np.array([t.visible for t in truths])
    assert np.abs(table["time_s"] - [t.t_s - truths[0].t_s for t in truths]).max() < 1e-5, "times are the file's, to its ticks"
    assert rms((centers - truth)[whole & clear]) < 0.15
    assert np.all(whole[clear]) and not np.any(whole & (visible < 0.7)) and (visible < 0.7).sum() > 5
    assert "1 gaps" in done.stderr and "lost" in done.stderr
    report = json.loads((tmp_path / "r.json").read_text())
    losses = [(i["from_s"], i["to_s"]) for n in NAMES for i in report["markers"][n]["intervals"]]
    hidden_s = np.array([t.t_s - truths[0].t_s for t, v in zip(truths, visible, strict=True) if v.min() < 0.7])
    assert losses and all(any(a - 2e-5 <= t <= b + 2e-5 for a, b in losses) for t in hidden_s)
    good = table["shank_sigma_rad"] > 0
    assert rms((table["shank_rad"] - [t.shank_rad for t in truths])[good]) < 1.5e-3  # 5 px markers, MJPEG
    assert (tmp_path / "overlay.avi").stat().st_size > 10_000 and (tmp_path / "sheet.png").stat().st_size > 10_000


def test_places_are_sampled_and_names_are_free(filmed, tmp_path):
    folder, truths = filmed
    x, y = truths[0].center_px[3]
    run("talus-track", "calibrate", "--out", tmp_path / "one.yaml", "--points", f"thing={x:.0f},{y:.0f}", folder / "film.mov")
    run("talus-track", "--setup", tmp_path / "one.yaml", "--out", tmp_path / "t.csv", folder / "film.mov", "--pictures", 50)
    table = np.genfromtxt(tmp_path / "t.csv", delimiter=",", names=True)
    assert len(table) == 50 and rms(table["thing_x_px"] - [t.center_px[3, 0] for t in truths[:50]]) < 0.2
    assert "shank_rad" not in table.dtype.names


def refuse(tmp_path, setup, video, *words):
    before = tmp_path / "out.csv"
    before.write_text("kept")
    done = run("talus-track", "--setup", setup, "--out", before, video, status=2)
    assert len(done.stderr.strip().splitlines()) == 1 and all(word in done.stderr for word in words), done.stderr
    assert before.read_text() == "kept"


def test_films_of_something_else(filmed, tmp_path):
    """A blank video, one of a marker too few, a real one of something else, no video at all."""
    folder, _ = filmed
    blank = Video(tmp_path / "blank.mp4", 320, 180)
    for i in range(20):
        blank.add(np.full((180, 320, 3), 128, np.uint8), i / 30)
    blank.close()
    refuse(tmp_path, folder / "setup.yaml", tmp_path / "blank.mp4", "none of the markers appears in any of 20 pictures")
    film = film_of(2, camera=Camera(**SMALL), whole=True, hidden=(3,))
    write_film(tmp_path / "three.mp4", film, np.arange(20) / 120)
    refuse(tmp_path, folder / "setup.yaml", tmp_path / "three.mp4", "marker toe", "does not appear in any of 20 pictures")
    refuse(tmp_path, folder / "setup.yaml", f"{OUTSIDE}/Megamind.avi", "Megamind.avi")
    (tmp_path / "text.mp4").write_text("no film\n" * 1000)
    refuse(tmp_path, folder / "setup.yaml", tmp_path / "text.mp4", "text.mp4: no video that can be opened")
    refuse(tmp_path, folder / "setup.yaml", tmp_path / "missing.mp4", "missing.mp4: no video that can be opened")


BAD_SETUPS = {
    "hue_deg: 400": "expected hue_deg 0 to 360",
    "hue_tolerance_deg: 0": "a number above 0",
    "radius_px: 0.2": "radius_px from 1.5 to 500",
    "min_value: no": "'no'",
}


@pytest.mark.parametrize("change", BAD_SETUPS)
def test_bad_setups_are_named_with_line_and_key(filmed, tmp_path, change):
    folder, _ = filmed
    key = change.split(":")[0]
    lines = (folder / "setup.yaml").read_text().splitlines()
    head, tail = lines[1].split(f"{key}: ", 1)
    lines[1] = f"{head}{change}{tail[min(tail.find(c) for c in ',}' if c in tail) :]}"
    (tmp_path / "bad.yaml").write_text("\n".join(lines) + "\n")
    refuse(tmp_path, tmp_path / "bad.yaml", folder / "film.mov", "bad.yaml:2: markers.knee", BAD_SETUPS[change])


def test_a_setup_that_lacks_something(filmed, tmp_path):
    folder, _ = filmed
    text = (folder / "setup.yaml").read_text()
    for bad, word in ((text.replace("clockwise", "sideways"), "positive: expected clockwise"),
                      (text + "lens: none.yaml\n", "none.yaml: no calibration of OpenCV"),
                      (text.replace("view:", "look:"), "look: unknown key"), ("markers: {}\n", "markers")):  # fmt: skip
        (tmp_path / "bad.yaml").write_text(bad)
        refuse(tmp_path, tmp_path / "bad.yaml", folder / "film.mov", word)


@pytest.mark.long
@pytest.mark.longest
@pytest.mark.parametrize("codec, kind", [("h264", "mp4"), ("mjpeg", "mov")])
def test_centers_after_compression_at_1080p(tmp_path, codec, kind):
    film = film_of(3, seed=4, whole=True)
    truths = write_film(tmp_path / f"film.{kind}", film, np.arange(many(240)) / 120, codec)
    run("talus-track", "calibrate", "--out", tmp_path / "s.yaml", "--shank-length", 0.3615, "--pose", pose_of(truths[0]),
        tmp_path / f"film.{kind}")  # fmt: skip
    run("talus-track", "--setup", tmp_path / "s.yaml", "--out", tmp_path / "t.csv", tmp_path / f"film.{kind}")
    table, centers, flags = track_of(tmp_path / "t.csv")
    error = rms(centers - [t.center_px for t in truths], axis=(0, 2))
    angles = [rms(table[k] - [getattr(t, k) for t in truths]) for k in ("shank_rad", "foot_rad")]
    print(f"{codec}: centres {error} px RMS, angles {1e3 * np.array(angles)} mrad RMS")
    assert np.all(flags & 1) and np.all(error <= 0.15)
