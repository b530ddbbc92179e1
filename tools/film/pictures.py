"""Pictures of a scene: blur, motion during the exposure, uneven light, noise."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

POOL = 1 << 20  # normal numbers that noise is taken from


@dataclass
class Truth:
    """What a picture shows: markers' centres in mid exposure, as the lens shows them [px], the share of each that is to
    be seen, whether nothing comes within three pixels of it, and the angles [rad]."""

    t_s: float
    center_px: np.ndarray
    visible: np.ndarray
    clear: np.ndarray
    shank_rad: float
    foot_rad: float


@dataclass
class Look:
    """The camera's quality. Noise in levels: read^2 + shot * level; light falls off by `light` across the width."""

    blur_px: float = 0.8
    exposure_s: float = 0.003
    instants: int = 3  # within an exposure, of which its motion blur is made
    read: float = 2.0
    shot: float = 0.03
    light: float = 0.3
    background: tuple = (152, 156, 160)


class Film:
    """Takes pictures (height, width, 3) of blue, green, red. `whole` draws all of the leg; without it only surroundings of
    the markers and of what passes, which is faster and all that a tracker looks at. The picture is
    one buffer that the next one is drawn into."""

    def __init__(self, camera, scene, look=None, seed=1, whole=True):
        self.camera, self.scene, self.look, self.whole = camera, scene, look or Look(), whole
        nodes, weights = np.polynomial.legendre.leggauss(self.look.instants)
        self.instants = [(self.look.exposure_s / 2 * node, weight / 2) for node, weight in zip(nodes, weights, strict=True)]
        self.random = np.random.default_rng(seed)
        self.pool = self.random.standard_normal(POOL, dtype=np.float32)
        x = np.linspace(-0.5, 0.5, camera.width, dtype=np.float32)
        self.light = 1 + self.look.light * np.broadcast_to(x, (camera.height, camera.width))
        self.empty = self._expose(np.array(self.look.background, np.float32) * self.light[..., None])
        self.picture = self.empty.copy()
        self.drawn = []

    def _noise(self, shape):
        n = int(np.prod(shape))
        if n > POOL // 2:
            return self.random.standard_normal(shape, dtype=np.float32)
        start = self.random.integers(0, POOL - n)
        return self.pool[start : start + n].reshape(shape)

    def _expose(self, rgb):
        """Levels with noise, as bytes in the order blue, green, red."""
        sigma = np.sqrt(self.look.read**2 + self.look.shot * rgb)
        return np.clip(np.rint(rgb + sigma * self._noise(rgb.shape)), 0, 255).astype(np.uint8)[..., ::-1]

    def _window(self, low, high):
        """Rows and columns of the picture that hold a box of the plane, with room for blur."""
        corners = np.array([low, high, (low[0], high[1]), (high[0], low[1])])
        px = self.camera.pixel(corners)
        room = 6 * self.look.blur_px + 12
        (x0, y0), (x1, y1) = np.floor(px.min(0) - room).astype(int), np.ceil(px.max(0) + room).astype(int)
        rows = slice(max(y0, 0), min(max(y1, 0), self.camera.height))
        return rows, slice(max(x0, 0), min(max(x1, 0), self.camera.width))

    def _windows(self, t_s):
        bars, markers, front = self.scene.shapes(t_s)
        shapes = [*markers, *front, *(bars if self.whole else ())]
        windows = [self._window(*shape.box()) for shape in shapes]
        return [(r, c) for r, c in windows if r.stop > r.start and c.stop > c.start]

    def _levels(self, t_s, rows, columns):
        """Light that reaches a window at one instant."""
        point = self.camera.plane_of_pixels[rows, columns]
        rgb = np.broadcast_to(np.array(self.look.background, np.float32), (*point.shape[:2], 3)).copy()
        sharp = self.camera.px_per_m / np.hypot(self.look.blur_px, 0.29)  # a pixel's own width: 1/sqrt(12)
        low, high = point.reshape(-1, 2).min(0) - 0.01, point.reshape(-1, 2).max(0) + 0.01
        for shape in [shape for group in self.scene.shapes(t_s) for shape in group]:
            first, last = shape.box()
            if np.all(first <= high) and np.all(last >= low):
                share = ndtr(-sharp * shape.distance(point)).astype(np.float32)[..., None]
                rgb += share * (np.array(shape.color, np.float32) - rgb)
        return rgb

    def take(self, t_s):
        """The picture whose exposure has its middle at t_s, and its truth."""
        for rows, columns in self.drawn:
            self.picture[rows, columns] = self.empty[rows, columns]
        self.drawn = self._windows(t_s)
        for rows, columns in self.drawn:
            rgb = sum(share * self._levels(t_s + later_s, rows, columns) for later_s, share in self.instants)
            self.picture[rows, columns] = self._expose(rgb * self.light[rows, columns, None])
        return self.picture, self.truth(t_s)

    def truth(self, t_s):
        """What the picture at t_s shows."""
        centers = self.camera.pixel(self.scene.centers(t_s))
        clear = self.scene.visible(t_s, 3 / self.camera.px_per_m) == 1
        return Truth(t_s, centers, self.scene.visible(t_s), clear, float(self.scene.shank_rad(t_s)), float(self.scene.foot_rad(t_s)))
