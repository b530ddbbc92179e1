"""talus-track align: clocks found again whose truth is known, by motion and by flashes, and what is merged.

The tracks are made from the twin's true motion as a tracker writes them, with the noise and the clocks of a consumer's
camera; the film itself is in test_track_whole.py.
"""

import json

import numpy as np
import pytest
from marker_scenes import rms
from scipy.interpolate import CubicSpline
from support import REPOSITORY, many, run

RATE_HZ, SIGMA_RAD = 120.0, (6e-5, 1.2e-4)


def sim(folder, name, duration_s, *more):
    """Recording and true motion of the leg. The excitation does not repeat within them."""
    run("talus-sim", "--model", REPOSITORY / "models/leg.yaml", "--out", folder / f"{name}.csv", "--motion", folder / f"{name}_motion.csv",
        "--duration", duration_s, "--period", 70, "--harmonics", 32, *more)  # fmt: skip
    return np.genfromtxt(folder / f"{name}_motion.csv", delimiter=",", names=True)



@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    return folder, sim(folder, "walk", 66)


class Track:
    """A track of the motion, made with a seed: clock, jitter that the file does not tell, dropped pictures, noise, a lamp."""

    def __init__(self, motion, seed, duration_s=60.0, exposure_s=0.003):
        random = np.random.default_rng(seed)
        self.offset_s, self.rate = random.uniform(-20, 20), 1e-6 * random.uniform(-150, 150)
        n = int(duration_s * RATE_HZ)
        taken = 2.0 + random.uniform(0, 1) + np.arange(n) / RATE_HZ  # on the recording's clock
        keep = random.uniform(size=n) > 0.01
        self.taken, camera = taken[keep], ((taken - self.offset_s) / (1 + self.rate))[keep]
        self.camera = camera + random.normal(0, 1e-4, len(camera))  # the driver's stamps
        shank = CubicSpline(motion["time_s"], motion["knee_position_rad"])(self.taken)
        foot = shank + CubicSpline(motion["time_s"], motion["ankle_position_rad"])(self.taken)
        self.angles = [x + random.normal(0, s, len(x)) for x, s in zip((shank, foot), SIGMA_RAD, strict=True)]
        self.edges = 1.5 + np.cumsum(random.uniform(0.4, 1.1, int(2 * duration_s)))
        self.lamp = np.clip(self.share(exposure_s) + random.normal(0, 0.01, len(self.taken)), -0.1, 1.1) * 0.8 + 0.1

    def share(self, exposure_s):
        """Of each exposure, in which the lamp is on: it goes on at even edges."""
        fine = self.taken[:, None] + exposure_s * (np.arange(200) + 0.5 - 100) / 200
        return (np.searchsorted(self.edges, fine) % 2 == 1).mean(axis=1)

    def write(self, folder, name="track", hide=(), lamp=True, fmt="%.9g"):
        sigma = [np.full(len(self.camera), s) for s in SIGMA_RAD]
        for begin_s, end_s in hide:
            sigma[0][(self.taken > begin_s) & (self.taken < end_s)] = 0
        columns = [self.camera, self.angles[0], sigma[0], self.angles[1], sigma[1]]
        header = "time_s,shank_rad,shank_sigma_rad,foot_rad,foot_sigma_rad"
        columns, header = ([*columns, self.lamp], header + ",lamp") if lamp else (columns, header)
        np.savetxt(folder / f"{name}.csv", np.c_[tuple(columns)], delimiter=",", header=header, comments="", fmt=fmt)
        edges = np.c_[self.edges, 1 - np.arange(len(self.edges)) % 2]
        np.savetxt(folder / f"{name}_edges.csv", edges, delimiter=",", header="time_s,on", comments="", fmt="%.6f")

    def errors(self, report):
        """Offset [s] and rate off by, each also in stated sigmas."""
        at = report["at_camera_s"]
        offset = report["offset_s"] + at - (self.offset_s + (1 + self.rate) * at)
        rate = 1e-6 * report["rate_ppm"] - self.rate
        return np.array([offset, rate, offset / report["offset_sigma_s"], 1e6 * rate / report["rate_sigma_ppm"]])


def align(folder, recording, *more, name="track", status=0):
    done = run("talus-track", "align", "--recording", recording, "--out", folder / "merged.csv", "--report", folder / "align.json",
               folder / f"{name}.csv", *more, status=status)  # fmt: skip
    return json.loads((folder / "align.json").read_text()) if status == 0 else done.stderr


def study(bench, tmp_path, seeds, *options, flashes):
    folder, motion = bench
    errors = []
    for seed in seeds:
        track = Track(motion, seed)
        track.write(tmp_path, lamp=flashes)
        more = ("--flashes", tmp_path / "track_edges.csv", *options) if flashes else ()
        report = align(tmp_path, folder / "walk.csv", *more)
        assert report["method"] == ("flashes" if flashes else "motion")
        errors.append(track.errors(report))
    errors = np.array(errors)
    inside = (np.abs(errors[:, 2:]) < 2).sum(axis=0)
    print(f"{'flashes' if flashes else 'motion'}: {len(seeds)} seeds, worst offset {1e3 * np.abs(errors[:, 0]).max():.4f} ms, worst rate "
          f"{1e6 * np.abs(errors[:, 1]).max():.3f} ppm, within two sigma {inside}, RMS of error/sigma {rms(errors[:, 2:], axis=0)}")  # fmt: skip
    return errors, inside


def test_clock_from_motion(bench, tmp_path):
    errors, inside = study(bench, tmp_path, range(5), flashes=False)
    assert np.abs(errors[:, 0]).max() < 0.5e-3 and np.abs(errors[:, 1]).max() < 20e-6 and np.all(inside >= 4)


def test_clock_from_flashes(bench, tmp_path):
    errors, inside = study(bench, tmp_path, range(2), flashes=True)
    assert np.abs(errors[:, 0]).max() < 0.2e-3 and np.abs(errors[:, 1]).max() < 20e-6 and np.all(inside >= 1)


@pytest.mark.long
@pytest.mark.parametrize("flashes, limit_s", [(False, 0.5e-3), (True, 0.2e-3)])
def test_uncertainty_is_honest_over_a_hundred_seeds(bench, tmp_path, flashes, limit_s):
    errors, inside = study(bench, tmp_path, range(100, 100 + many(100)), "--exposure", 0.003, flashes=flashes)
    assert np.abs(errors[:, 0]).max() < limit_s and np.abs(errors[:, 1]).max() < 20e-6
    assert np.all(inside >= 0.9 * len(errors)) and np.all(rms(errors[:, 2:], axis=0) > 0.4)


def test_merged_angles(bench, tmp_path):
    """The camera's angles at the recording's samples; where a marker was hidden the row is not valid."""
    folder, motion = bench
    track = Track(motion, 7)
    track.write(tmp_path, hide=[(20, 20.5)])
    report = align(tmp_path, folder / "walk.csv")
    merged = np.genfromtxt(tmp_path / "merged.csv", delimiter=",", names=True)
    source = np.genfromtxt(folder / "walk.csv", delimiter=",", names=True)
    inside = np.isin(source["time_s"], merged["time_s"])
    assert inside.sum() == len(merged) == report["merged"]["rows"] and report["merged"]["outside_the_film"] == (~inside).sum()
    for name in source.dtype.names:
        assert np.allclose(merged[name], source[name][inside], atol=1e-9, rtol=0)
    shank = CubicSpline(motion["time_s"], motion["knee_position_rad"])(merged["time_s"])
    foot = shank + CubicSpline(motion["time_s"], motion["ankle_position_rad"])(merged["time_s"])
    valid = merged["valid"] == 1
    error = [rms((merged["shank_rad"] - shank)[valid]), rms((merged["foot_rad"] - foot)[valid])]
    print(f"merged angles off by {1e3 * np.array(error)} mrad RMS, interpolation stated as "
          f"{1e3 * report['merged']['shank_interpolation_rad']:.4f}, {1e3 * report['merged']['foot_interpolation_rad']:.4f}")  # fmt: skip
    assert max(error) < 1e-3 and np.abs(merged["shank_rad"] - shank)[valid].max() < 2e-3
    hidden = (merged["time_s"] > 20.05) & (merged["time_s"] < 20.45)
    assert not np.any(valid & hidden) and (~valid).sum() < 1.3 * hidden.sum()
    stated = np.hypot(SIGMA_RAD, [report["merged"][f"{k}_interpolation_rad"] for k in ("shank", "foot")])
    assert np.all(np.array(error) < 2.5 * stated + 1e-4)  # 1e-4: stamps off by 0.1 ms at 1 rad/s


def test_a_motion_that_repeats_is_refused(tmp_path):
    """A multisine of 4 s: any period fits; with --near it is the one that is meant."""
    run("talus-sim", "--model", REPOSITORY / "models/leg.yaml", "--out", tmp_path / "walk.csv", "--motion", tmp_path / "motion.csv",
        "--duration", 25)  # fmt: skip
    track = Track(np.genfromtxt(tmp_path / "motion.csv", delimiter=",", names=True), 3, duration_s=12)
    track.write(tmp_path)
    assert "repeats itself" in align(tmp_path, tmp_path / "walk.csv", status=2)
    assert not (tmp_path / "merged.csv").exists()
    report = align(tmp_path, tmp_path / "walk.csv", "--near", f"{track.offset_s + 0.4:.2f}")
    assert abs(track.errors(report)[0]) < 0.5e-3


def write_export(path, zero_ns, clock="CLOCK_MONOTONIC", schema="talus-export/1"):
    """What the export says of a recording."""
    path.write_text(json.dumps({"schema": schema, "zero_ns": zero_ns, "clock": clock}))
    return path


def test_a_camera_that_the_kernel_stamps_needs_no_offset_by_hand(tmp_path):
    """A repeating motion, and pictures stamped by CLOCK_MONOTONIC some days after the machine was started: the export's report says where
    the recording lies on it. The camera stamps 40 ms after the middle of its exposure."""
    run("talus-sim", "--model", REPOSITORY / "models/leg.yaml", "--out", tmp_path / "walk.csv", "--motion", tmp_path / "motion.csv",
        "--duration", 25)  # fmt: skip
    track, zero_s, late_s = Track(np.genfromtxt(tmp_path / "motion.csv", delimiter=",", names=True), 3, duration_s=12), 345_678.9, 0.04
    track.camera = track.taken + zero_s + late_s
    track.offset_s, track.rate = -zero_s - late_s, 0.0
    track.write(tmp_path, fmt="%.12g")
    assert "repeats itself" in align(tmp_path, tmp_path / "walk.csv", status=2)
    told = write_export(tmp_path / "walk.json", round(zero_s * 1e9))
    assert abs(track.errors(align(tmp_path, tmp_path / "walk.csv", "--export", told))[0]) < 0.5e-3
    assert "both say" in align(tmp_path, tmp_path / "walk.csv", "--export", told, "--near", "0", status=2)
    for wrong in ({"clock": "the stamps' clock"}, {"schema": "other"}):
        said = align(tmp_path, tmp_path / "walk.csv", "--export", write_export(tmp_path / "wrong.json", 5, **wrong), status=2)
        assert "wrong.json: " in said
    assert "no motion in common" in align(tmp_path, tmp_path / "walk.csv", "--export", write_export(told, 5), status=2)


def test_what_has_nothing_in_common_is_refused(bench, tmp_path):
    folder, motion = bench
    track = Track(motion, 5)
    track.angles = [np.random.default_rng(1).normal(0, 0.1, len(x)) for x in track.angles]
    track.write(tmp_path)
    assert "no motion in common" in align(tmp_path, folder / "walk.csv", status=2)
    text = (tmp_path / "track.csv").read_text().splitlines()
    for lines, word in ((text[:60], "expected 100"), ([text[0].replace("foot_rad", "toe_rad"), *text[1:]], "missing column: foot_rad"),
                        ([*text[:5], text[2], *text[5:]], "time_s must rise"), ([], "track.csv")):  # fmt: skip
        (tmp_path / "track.csv").write_text("\n".join(lines) + "\n")
        said = align(tmp_path, folder / "walk.csv", status=2)
        assert word in said and len(said.strip().splitlines()) == 1, said
    assert not (tmp_path / "merged.csv").exists()
