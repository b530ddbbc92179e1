"""Laws that must be stepped in time, along arrays: friction with memory, a link behind a spring and a gap, filters."""

from dataclasses import dataclass

import numpy as np

from talus import constants, ffi, lib, pointer

MOST_STEPS = 60  # of the link for one sample
LARGEST_STEP = 1.0  # rad: beyond it a stepped oscillation grows


def dahl(position, travel, power, first=0.0):
    """Dahl's friction state in [-1, 1] along a position."""
    position, state = np.ascontiguousarray(position, float), np.empty(len(position))
    lib.tl_dahl_along(pointer(position), len(position), travel, power, first, pointer(state))
    return state


@dataclass(frozen=True)
class LinkShape:
    """A link behind a spring [Nm/rad] and a gap of +-half [rad]; `dry` and `viscous` are the shares of that friction on
    the link's side, `motor` the share of the joint's own inertia on the motor's."""

    stiffness: float
    half: float
    dry: float
    viscous: float
    motor: float
    damping_ratio: float
    soft_rad: float = 0.0  # so far the spring has only a share of its stiffness
    soft_share: float = 1.0
    hardening: float = 0.0  # Nm/rad^3
    drag_Nm: float = 0.0  # dry friction between motor and link

    def damping_s(self, inertia):
        """Damping of the spring over its stiffness."""
        return 2 * self.damping_ratio * np.sqrt(inertia / self.stiffness)


def link_behind(shape, t_s, motor, other_Nm, inertia, coulomb_Nm, viscous):
    """Angle of the link less the motor's, torque through the spring, and acceleration of the link, at the samples t_s.

    The motor's angle and speed (at the joint) are given, and the torque `other_Nm` that the link needs besides its
    inertia and friction."""
    link = ffi.new("tl_two_mass *", {
        "stiffness_Nm_rad": shape.stiffness, "gap_rad": 2 * shape.half, "soft_rad": shape.soft_rad, "soft_share": shape.soft_share,
        "hardening_Nm_rad3": shape.hardening, "drag_Nm": shape.drag_Nm, "friction_share": shape.dry, "viscous_share": shape.viscous,
        "damping_s": shape.damping_s(inertia), "inertia_kg_m2": inertia, "coulomb_Nm": coulomb_Nm,
        "viscous_Nms_rad": viscous, "settle_s": constants.TL_TWO_MASS_SETTLE_S,
        "step_s": (t_s[-1] - t_s[0]) / (len(t_s) - 1)})  # fmt: skip
    rows = [np.ascontiguousarray(x, float) for x in (t_s, *motor, other_Nm)]
    out = np.empty((3, len(t_s)))
    motion = ffi.new("tl_two_mass_motion *", [pointer(x) for x in out])
    lib.tl_two_mass_along(link, *map(pointer, rows), len(t_s), motion)
    return out


def second_order(b, a, x):
    """A filter of second order from rest, numerator b and denominator a of three coefficients each."""
    b, a, x = (np.ascontiguousarray(v, float) for v in (b, a, x))
    out = np.empty(len(x))
    lib.tl_filter_second_order(pointer(b), pointer(a), pointer(x), len(x), pointer(out))
    return out
