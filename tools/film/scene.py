"""What stands before the camera at an instant: links, markers, what passes in front of them, a lamp."""

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

SHANK_M = 0.3615
HEEL_M, TOE_M = (-0.06, -0.045), (0.14, -0.06)  # from the ankle, the foot's angle being 0
RED, GREEN, BLUE, YELLOW = (205, 40, 45), (40, 170, 70), (40, 80, 205), (225, 200, 30)
DARK, GREY = (62, 62, 66), (120, 118, 122)


@dataclass
class Capsule:
    """A bar with round ends: a colour (red, green, blue), two ends [m] and half its width."""

    color: tuple
    a: np.ndarray
    b: np.ndarray
    half_m: float

    def distance(self, point):
        """From its edge, negative inside [m]."""
        along = self.b - self.a
        length2 = float(along @ along)
        share = np.clip(((point - self.a) @ along) / length2, 0, 1) if length2 else np.zeros(point.shape[:-1])
        return np.linalg.norm(point - self.a - share[..., None] * along, axis=-1) - self.half_m

    def box(self):
        """Lowest and highest corner [m]."""
        return np.minimum(self.a, self.b) - self.half_m, np.maximum(self.a, self.b) + self.half_m


def disc(color, center, radius_m):
    """A round marker."""
    return Capsule(color, np.asarray(center), np.asarray(center), radius_m)


def turned(local, angle):
    """A link's point (x, y) at an angle, clockwise positive."""
    x, y = local
    s, c = np.sin(angle), np.cos(angle)
    return np.array([x * c + y * s, y * c - x * s])


@dataclass
class Passing:
    """A bar that crosses the picture at an even speed, in front of all."""

    begin_s: float
    end_s: float
    start_m: tuple
    velocity_m_s: tuple
    half_m: float = 0.02
    length_m: float = 0.1
    color: tuple = GREY

    def at(self, t_s):
        """The bar, upright; None when it is not there."""
        if not self.begin_s <= t_s <= self.end_s:
            return None
        middle = np.array(self.start_m) + (t_s - self.begin_s) * np.array(self.velocity_m_s)
        reach = np.array([0, self.length_m / 2])
        return Capsule(self.color, middle - reach, middle + reach, self.half_m)


@dataclass
class Scene:
    """A leg that hangs from the knee; angles are interpolated (cubic) between their times."""

    shank_rad: object  # functions of time
    foot_rad: object
    radius_m: float = 0.010
    colors: tuple = (RED, GREEN, BLUE, YELLOW)
    passing: list = field(default_factory=list)
    hidden: tuple = ()  # markers that are not there
    lamp_m: tuple | None = None
    lamp_on: object = None  # function of time: 0 or 1

    @classmethod
    def leg(cls, t_s, shank_rad, foot_rad, **more):
        """From a motion's samples."""
        from scipy.interpolate import CubicSpline

        return cls(CubicSpline(t_s, shank_rad), CubicSpline(t_s, foot_rad), **more)

    def centers(self, t_s):
        """Knee, ankle, heel, toe (4, 2) [m]."""
        foot = float(self.foot_rad(t_s))
        ankle = turned((0, -SHANK_M), float(self.shank_rad(t_s)))
        return np.array([(0, 0), ankle, ankle + turned(HEEL_M, foot), ankle + turned(TOE_M, foot)])

    def shapes(self, t_s):
        """(bars, markers, what passes in front), each from back to front."""
        knee, ankle, heel, toe = at = self.centers(t_s)
        bars = [Capsule(DARK, knee, ankle, 0.026), Capsule(DARK, heel, toe, 0.026)]
        markers = [disc(color, c, self.radius_m) for m, (color, c) in enumerate(zip(self.colors, at, strict=True))
                   if m not in self.hidden]  # fmt: skip
        front = [bar for bar in (p.at(t_s) for p in self.passing) if bar is not None]
        if self.lamp_m is not None:
            front.append(disc((250, 250, 250) if self.lamp_on(t_s) else (30, 30, 30), self.lamp_m, 0.008))
        return bars, markers, front

    def visible(self, t_s, margin_m=0.0):
        """The share of each marker, with a margin around it, that nothing covers (4)."""
        reach_m = self.radius_m + margin_m
        _, markers, front = self.shapes(t_s)
        if not front and min(np.linalg.norm(a.a - b.a) for a, b in combinations(markers, 2)) > 2 * reach_m:
            return np.array([float(m not in self.hidden) for m in range(4)])
        grid = np.linspace(-1, 1, 41)
        unit = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
        unit = unit[np.linalg.norm(unit, axis=1) <= 1]
        shares, present = np.zeros(4), [m for m in range(4) if m not in self.hidden]
        for index, m in enumerate(present):
            free = np.ones(len(unit), bool)
            for cover in [*markers[index + 1 :], *front]:
                free &= cover.distance(markers[index].a + reach_m * unit) > 0
            shares[m] = free.mean()
        return shares
