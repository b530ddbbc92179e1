"""A pinhole with Brown's distortion in front of the plane in which the leg moves."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np


def rotation(yaw, pitch, roll):
    """The camera's turn about its upright, sideways and optical axis [rad]."""
    (cy, cp, cr), (sy, sp, sr) = np.cos([yaw, pitch, roll]), np.sin([yaw, pitch, roll])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_x = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
    about_z = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    return about_z @ about_x @ about_y


@dataclass
class Camera:
    """Lengths in metres and pixels. The plane's points are (x to the right, y up) from the knee; `knee` is where the
    knee stands in the camera's frame (right, down, ahead)."""

    width: int = 1920
    height: int = 1080
    focal_px: float = 1800.0
    knee_m: tuple = (0.0, -0.22, 1.30)
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    distortion: tuple = (0.0, 0.0, 0.0, 0.0)  # k1, k2, p1, p2

    @property
    def center_px(self):
        """The principal point."""
        return np.array([(self.width - 1) / 2, (self.height - 1) / 2])

    @cached_property
    def turn(self):
        """Rotation from the plane's frame (x right, y down, z ahead) to the camera's."""
        return rotation(self.yaw, self.pitch, self.roll)

    def distort(self, ray):
        """Rays (..., 2) as the lens bends them (Brown 1966, the form that OpenCV documents)."""
        k1, k2, p1, p2 = self.distortion
        u, v = ray[..., 0], ray[..., 1]
        r2 = u * u + v * v
        radial = 1 + k1 * r2 + k2 * r2 * r2
        return np.stack([u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u),
                         v * radial + p1 * (r2 + 2 * v * v) + 2 * p2 * u * v], axis=-1)  # fmt: skip

    def pixel(self, plane_m, lens=True):
        """Where points (..., 2) of the plane appear; without the lens's distortion when asked."""
        plane_m = np.asarray(plane_m, dtype=float)
        flat = np.stack([plane_m[..., 0], -plane_m[..., 1], np.zeros(plane_m.shape[:-1])], axis=-1)
        point = flat @ self.turn.T + np.array(self.knee_m)
        ray = point[..., :2] / point[..., 2:]
        return self.center_px + self.focal_px * (self.distort(ray) if lens else ray)

    @cached_property
    def plane_of_pixels(self):
        """The plane's point (height, width, 2) that each pixel's centre sees."""
        x, y = np.meshgrid(np.arange(self.width), np.arange(self.height))
        bent = (np.stack([x, y], axis=-1) - self.center_px) / self.focal_px
        ray = bent.copy()
        for _ in range(12 if any(self.distortion) else 0):
            ray += bent - self.distort(ray)
        across, down, normal = self.turn.T
        knee = np.array(self.knee_m)
        ray3 = np.concatenate([ray, np.ones((*ray.shape[:2], 1))], axis=-1)
        hit = ray3 * ((knee @ normal) / (ray3 @ normal))[..., None] - knee
        return np.stack([hit @ across, -(hit @ down)], axis=-1).astype(np.float32)

    @property
    def px_per_m(self):
        """About, at the knee."""
        return self.focal_px / self.knee_m[2]
