"""Motions and passers-by for the tests that film a leg."""

import numpy as np
from film.camera import Camera
from film.pictures import Film, Look
from film.scene import SHANK_M, Passing, Scene

RATE_HZ = 120.0
SMALL = {"width": 640, "height": 360, "focal_px": 600.0}
FOOT_OFFSET_RAD = float(np.arctan2(-0.20, 0.015))  # heel to toe, the foot's angle being 0


def motion(duration_s, seed=1):
    """Times and angles of shank and foot: a few sines of random phase."""
    random, t = np.random.default_rng(seed), np.arange(-0.5, duration_s + 0.5, 0.005)
    def sines(*terms):
        return sum(a * np.sin(2 * np.pi * f * t + random.uniform(0, 6.3)) for a, f in terms)
    shank = sines((0.28, 0.55), (0.12, 1.3))
    return t, shank, shank + sines((0.25, 0.7), (0.10, 1.7))


def film_of(duration_s, seed=1, camera=None, look=None, whole=False, **scene):
    """A leg in motion before a camera."""
    return Film(camera or Camera(), Scene.leg(*motion(duration_s, seed), **scene), look or Look(), seed, whole)


def passers(duration_s, every_s, seed=1, speed_m_s=0.7):
    """Grey bars that cross the picture now and then, at different heights and from both sides."""
    random = np.random.default_rng(seed)
    bars = []
    for begin_s in np.arange(0.8, duration_s - 2.0, every_s):
        side = random.choice((-1, 1))
        start = (-side * 0.4, -random.uniform(0, SHANK_M + 0.10))
        bars.append(Passing(begin_s, begin_s + 0.8 / speed_m_s, start, (side * speed_m_s, 0), half_m=random.uniform(0.012, 0.05),
                            length_m=0.2))
    return bars


def rms(x, axis=None):
    return np.sqrt(np.mean(np.square(x), axis=axis))
