"""talus-track on real pictures: those of Debian's package opencv-doc (tools/setup installs it)."""

import re
import subprocess
from pathlib import Path

import av
import numpy as np
import pytest
from film.camera import Camera
from matplotlib.colors import rgb_to_hsv
from scipy.ndimage import label
from support import REPOSITORY, run

PICTURES = Path("/usr/share/doc/opencv-doc/examples/data")
BOARDS = sorted(PICTURES.glob("left??.jpg"))


def numbers_of(text, key):
    """The data of one matrix, or a number, in a file of OpenCV's."""
    found = re.search(rf"{key}: !!opencv-matrix.*?data: \[(.*?)\]", text, re.DOTALL)
    return np.array(found[1].split(","), float) if found else float(re.search(rf"{key}: (.*)", text)[1])


@pytest.fixture(scope="module")
def lens(tmp_path_factory):
    path = tmp_path_factory.mktemp("lens") / "lens.yaml"
    done = run("talus-track", "lens", "--out", path, *BOARDS)
    return path, done.stderr


def test_a_lens_from_real_chessboards(lens):
    """Beside what the package itself has of this camera, with one focal length for both directions."""
    text, known = lens[0].read_text(), (PICTURES / "left_intrinsics.yml").read_text()
    assert len(BOARDS) == 13 and "13 of 13 pictures show the board" in lens[1]
    camera, other = numbers_of(text, "camera_matrix"), numbers_of(known, "camera_matrix")
    assert np.allclose(camera[[0, 4]], other[[0, 4]], rtol=1e-3) and np.allclose(camera[[2, 5]], other[[2, 5]], atol=0.5)
    assert np.allclose(numbers_of(text, "distortion_coefficients"), numbers_of(known, "distortion_coefficients"), atol=0.02)
    assert numbers_of(text, "avg_reprojection_error") == pytest.approx(numbers_of(known, "avg_reprojection_error"), rel=0.05)


@pytest.mark.long
@pytest.mark.release
def test_its_reprojection_error_is_opencvs_own(lens, tmp_path):
    """A program of its own that calls OpenCV as OpenCV's manual does: the same numbers."""
    flags = ["-O1", "-isystem", "/usr/include/opencv4", "-o", str(tmp_path / "reference"), str(REPOSITORY / "tests/lens_reference.cpp")]
    modules = [f"-lopencv_{m}" for m in ("calib3d", "imgcodecs", "imgproc", "core")]
    subprocess.run(["g++", *flags, *modules], check=True)
    printed = subprocess.run([tmp_path / "reference", "9", "6", *BOARDS], check=True, capture_output=True, text=True).stdout
    error, *camera = map(float, printed.split())
    text = lens[0].read_text()
    ours = numbers_of(text, "camera_matrix")[[0, 4, 2, 5]]
    print(f"reprojection error {numbers_of(text, 'avg_reprojection_error'):.9f} px, OpenCV's {error:.9f}")
    assert numbers_of(text, "avg_reprojection_error") == pytest.approx(error, rel=1e-12) and np.allclose(ours, camera, rtol=1e-12)


def test_pictures_without_a_board(tmp_path):
    done = run("talus-track", "lens", "--out", tmp_path / "l.yaml", *[PICTURES / f"{n}.jpg" for n in ("fruits", "fruits", "fruits")],
               status=2)  # fmt: skip
    assert "found in 0 of 3 pictures" in done.stderr and not (tmp_path / "l.yaml").exists()


@pytest.mark.long
def test_distortion_is_taken_out(tmp_path):
    """A leg filmed through a lens that bends by pixels, with OpenCV's file of that lens and without."""
    from marker_scenes import FOOT_OFFSET_RAD, SMALL, film_of, rms
    from test_track import write_film

    bent = (-0.25, 0.05, 0.001, -0.001)
    camera = Camera(**SMALL, distortion=bent)
    truths = write_film(tmp_path / "film.mov", film_of(1, camera=camera, whole=True), np.arange(40) / 120, "raw")
    (x, y), f = camera.center_px, camera.focal_px
    (tmp_path / "lens.yaml").write_text(
        "%YAML:1.0\n---\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
        f"   data: [ {f}, 0., {x}, 0., {f}, {y}, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 4\n   cols: 1\n"
        f"   dt: d\n   data: [ {', '.join(map(str, bent))} ]\n")  # fmt: skip
    off = []
    for lens in ([], ["--lens", "lens.yaml"]):
        run("talus-track", "calibrate", "--out", tmp_path / "s.yaml", "--shank-length", 0.3615, *lens, tmp_path / "film.mov")
        run("talus-track", "--setup", tmp_path / "s.yaml", "--out", tmp_path / "t.csv", tmp_path / "film.mov")
        table = np.genfromtxt(tmp_path / "t.csv", delimiter=",", names=True)
        off.append([rms(table["shank_rad"] - [t.shank_rad for t in truths]),
                    rms(table["foot_rad"] - FOOT_OFFSET_RAD - [t.foot_rad for t in truths])])  # fmt: skip
    print(f"angles off by {1e3 * np.array(off)} mrad without and with the lens")
    assert max(off[0]) > 2e-3 and max(off[1]) < 0.6e-3


def test_a_coloured_thing_in_a_real_film(tmp_path):
    """A blue sweater that two scenes show and others do not: followed where it is, lost elsewhere. NumPy looks for the
    same colour in pictures that FFmpeg decoded."""
    film = PICTURES / "Megamind.avi"
    run("talus-track", "calibrate", "--out", tmp_path / "s.yaml", "--points", "sweater=510,470", "--at", 5, film)
    run("talus-track", "--setup", tmp_path / "s.yaml", "--out", tmp_path / "t.csv", "--sheet", tmp_path / "sheet.png", film)
    table = np.genfromtxt(tmp_path / "t.csv", delimiter=",", names=True)
    seen = (table["sweater_flags"].astype(int) & 1) != 0
    areas, off = np.zeros(len(table)), []
    with av.open(str(film)) as video:
        for i, frame in zip(range(len(table)), video.decode(video=0), strict=False):
            if i % 18:
                continue
            hue, saturation, value = np.moveaxis(rgb_to_hsv(frame.to_ndarray(format="rgb24") / 255), -1, 0)
            parts, n = label((np.abs(360 * hue - 201) < 18) & (saturation > 0.44) & (value > 0.08))
            areas[i] = np.bincount(parts.ravel())[1:].max() if n else 0
            if seen[i]:
                y, x = np.nonzero(parts == 1 + np.bincount(parts.ravel())[1:].argmax())
                off.append(np.hypot(x.mean() - table["sweater_x_px"][i], y.mean() - table["sweater_y_px"][i]))
    looked = np.arange(len(table)) % 18 == 0
    assert np.all(seen[looked & (areas > 12_000)]) and not np.any(seen[looked & (areas < 1_500)])
    assert len(off) > 5 and max(off) < 40  # of a thing 160 wide that is no disc
    assert (tmp_path / "sheet.png").stat().st_size > 100_000
