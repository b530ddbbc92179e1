"""lib/marker*.c on pictures of a scene whose truth is known (tools/film, which shares nothing with the tracker)."""

import numpy as np
import pytest
from film.camera import Camera
from film.pictures import Look
from marker_eye import EDGE, HUES, PARTIAL, SEEN, Eye
from marker_scenes import FOOT_OFFSET_RAD, RATE_HZ, SMALL, film_of, passers, rms
from support import many

from talus import check, ffi, lib

pytestmark = pytest.mark.spread


def follow(film, frames, eye):
    """(flags, centres, sigma, truths) of a film's first pictures."""
    flags, centers, sigma, truths = [], [], [], []
    for i in range(frames):
        picture, truth = film.take(i / RATE_HZ)
        seen, at = eye.see(picture, truth.t_s)
        flags.append(seen), centers.append(at), sigma.append(eye.sigma()), truths.append(truth)
    return np.array(flags), np.array(centers), np.array(sigma), truths


def centers_of(truths):
    return np.array([truth.center_px for truth in truths])


def check_centers(film, frames, limit_px):
    flags, centers, sigma, truths = follow(film, frames, Eye())
    error = centers - centers_of(truths)
    assert np.all(flags & SEEN) and not np.any(flags & PARTIAL)
    print(f"centre error {rms(error):.4f} px RMS, worst {np.abs(error).max():.4f}; stated {rms(sigma):.4f}")
    assert np.all(rms(error, axis=(0, 2)) <= limit_px)
    assert np.abs(error).max() < 8 * limit_px
    assert 0.5 < rms(error) / rms(sigma) < 2.0
    return error, truths, centers


def test_centers_at_1080p():
    check_centers(film_of(2), 60, 0.05)


@pytest.mark.long
@pytest.mark.parametrize("look", [Look(), Look(blur_px=1.6, exposure_s=0.006, read=4.0, light=0.6), Look(blur_px=0.4, exposure_s=0.001)])
def test_centers_at_1080p_in_every_light(look):
    camera = Camera(yaw=0.03, pitch=-0.02, roll=0.02, distortion=(-0.12, 0.03, 0.0005, -0.0003))
    check_centers(film_of(5, seed=2, camera=camera, look=look), 400, 0.05)


def test_angles_and_their_sigma():
    film = film_of(2, seed=3)
    view = ffi.new("tl_marker_view *", {"clockwise": 1, "shank_length_m": 0.3615, "foot_offset_rad": FOOT_OFFSET_RAD})
    eye, angles, error, sigma = Eye(), ffi.new("tl_marker_angles *"), [], []
    for i in range(60):
        picture, truth = film.take(i / RATE_HZ)
        eye.see(picture, truth.t_s)
        lib.tl_marker_angles_from(view, eye.sample, angles)
        assert angles.shank_valid and angles.foot_valid
        error.append((angles.shank_rad - truth.shank_rad, angles.foot_rad - truth.foot_rad))
        sigma.append((angles.shank_sigma_rad, angles.foot_sigma_rad))
        assert angles.scale_m_px == pytest.approx(1.30 / 1800, rel=1e-3)
    print(f"angle error {1e3 * rms(error, axis=0)} mrad RMS, stated {1e3 * rms(sigma, axis=0)}")
    assert np.all(rms(error, axis=0) <= 0.5e-3)
    assert np.all(np.abs(np.log2(rms(error, axis=0) / rms(sigma, axis=0))) < 1)


def test_the_other_sense_of_turning():
    view = ffi.new("tl_marker_view *", {"clockwise": 0})
    down_right = lib.tl_marker_direction(view, [0.0, 0.0], [1.0, 10.0])
    view.clockwise = 1
    assert down_right == pytest.approx(np.arctan(0.1)) and lib.tl_marker_direction(view, [0.0, 0.0], [1.0, 10.0]) == -down_right


# ---- hidden, crossing, at the edge -------------------------------------------------------


def check_hidden(film, frames, eye, far_px=30):
    """Every marker of which six per cent are hidden is reported, and none that nothing touches; what is called whole is
    where it is; nobody is taken for another."""
    flags, centers, _, truths = follow(film, frames, eye)
    visible, clear, truth = np.array([t.visible for t in truths]), np.array([t.clear for t in truths]), centers_of(truths)
    whole = ((flags & SEEN) != 0) & ((flags & (PARTIAL | EDGE)) == 0)
    assert (visible < 0.94).sum() > 0.02 * visible.size, "the film hides too little to tell"
    missed, invented = int(np.sum(whole & (visible < 0.94))), int(np.sum(~whole & clear))
    off = np.linalg.norm(centers - truth, axis=2)
    print(f"{visible.size} markers, {np.sum(visible < 0.94)} hidden or partly: {missed} not reported, {invented} invented; "
          f"worst error of a whole one {off[whole].max():.3f} px, of any {off[(flags & SEEN) != 0].max():.1f} px")
    assert (missed, invented) == (0, 0)
    assert off[(flags & SEEN) != 0].max() < far_px, "a marker was taken for another"
    assert rms((centers - truth)[whole & clear]) < 0.05


@pytest.mark.long
def test_what_is_hidden_is_reported():
    film = film_of(6, camera=Camera(**SMALL), passing=passers(6, 1.0, speed_m_s=1.0))
    check_hidden(film, 480, Eye(radius_px=5))


@pytest.mark.long
@pytest.mark.longest
def test_none_swapped_in_ten_thousand_pictures():
    pictures = many(10_000)
    seconds = pictures / RATE_HZ
    film = film_of(seconds, seed=5, camera=Camera(**SMALL), look=Look(instants=2), passing=passers(seconds, 0.9, seed=5))
    check_hidden(film, pictures, Eye(radius_px=5))


def crossing(t_s, seed, radius=8):
    """Two red and two green discs that swing through each other, drawn with plain supersampling."""
    phase = np.random.default_rng(seed).uniform(0, 6.28, 4)
    at = np.array([(160 + 90 * np.sin(1.3 * (1 + 0.17 * m) * t_s + phase[m]), 60 + 25 * m + 3 * np.cos(t_s + m)) for m in range(4)])
    at[2:] += (0, 30)
    picture = np.full((240, 320, 3), 140.0)
    y, x = np.mgrid[0:240, 0:320]
    for m, color in enumerate(((45, 40, 205), (45, 40, 205), (70, 170, 40), (70, 170, 40))):
        share = np.clip(radius + 0.5 - np.hypot(x - at[m, 0], y - at[m, 1]), 0, 1)[..., None]
        picture += share * (np.array(color) - picture)
    noise = np.random.default_rng(int(1e4 * t_s)).normal(0, 2, picture.shape)
    return np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8), at


def test_two_of_a_colour_keep_their_names():
    """Rows of 25 px and discs of 16: those of a colour touch at times, and pass each other."""
    for seed in (1, 2):
        eye = Eye(HUES[:2], 8, (0, 0, 1, 1), crossing(0, seed)[1], links=())
        for i in range(150):
            picture, truth = crossing(i / 50, seed)
            flags, at = eye.see(picture, i / 50)
            seen = (flags & SEEN) != 0
            assert np.linalg.norm(at - truth, axis=1)[seen].max(initial=0) < 3, (seed, i, flags)


def test_at_the_edge_and_beyond():
    eye = Eye(HUES[:1], 8, links=())
    for i in range(60):
        x = 40 - i
        y, c = np.mgrid[0:100, 0:100]
        share = np.clip(8.5 - np.hypot(c - x, y - 50), 0, 1)[..., None]
        picture = (140 + share * (np.array((45, 40, 205)) - 140)).astype(np.uint8)
        flags, at = eye.see(picture, i / 50)
        if x > 11:
            assert flags[0] & ~32 == SEEN and abs(at[0, 0] - x) < 0.05
        elif 0 < x < 8:
            assert flags[0] == 0 or flags[0] & (EDGE | PARTIAL)
        elif x < -9:
            assert flags[0] == 0


# ---- the plane's tilt ----------------------------------------------------------------------


@pytest.mark.parametrize("yaw, pitch", [(0.0, 0.0), (0.08, -0.05), (-0.12, 0.1)])
def test_tilt_from_motion(yaw, pitch):
    """The slopes of the plane's depth, from the camera's turn: normal = turn . z."""
    camera = Camera(yaw=yaw, pitch=pitch)
    film = film_of(20, camera=camera)
    random = np.random.default_rng(4)
    points = np.array([film.camera.pixel(film.scene.centers(t)) for t in np.arange(0, 20, 1 / 30)])
    points = np.ascontiguousarray(points + random.normal(0, 0.01, points.shape))
    view = ffi.new("tl_marker_view *", {"clockwise": 1, "focal_px": camera.focal_px, "center_px": list(camera.center_px)})
    sigma = ffi.new("double[2]")
    check(lib.tl_marker_fit_tilt(view, ffi.cast("double(*)[4][2]", points.ctypes.data), len(points), sigma))
    normal = camera.turn[:, 2]
    truth = -normal[:2] / normal[2]
    error = np.array(list(view.tilt)) - truth
    assert np.all(np.abs(error) < 3.5 * np.array(list(sigma))) and np.all(np.array(list(sigma)) < 2e-3), (error, list(sigma))
    shank = [lib.tl_marker_direction(view, list(p[0]), list(p[1])) for p in points]
    off = np.array(shank) - [film.scene.shank_rad(t) for t in np.arange(0, 20, 1 / 30)]
    assert rms(off - off.mean()) < 0.5e-3  # a constant is the calibration's


def test_tilt_needs_motion():
    view = ffi.new("tl_marker_view *", {"focal_px": 1800.0})
    sigma = ffi.new("double[2]")
    still = np.tile(np.array([[0, 0], [0, 500], [-90, 560], [200, 580]], float), (50, 1, 1))
    pointer = ffi.cast("double(*)[4][2]", still.ctypes.data)
    assert lib.tl_marker_fit_tilt(view, pointer, 50, sigma) == lib.TL_ERR_SINGULAR
    assert lib.tl_marker_fit_tilt(view, pointer, 10, sigma) == lib.TL_ERR_TOO_SHORT
