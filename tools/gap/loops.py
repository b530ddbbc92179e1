"""Laws that must be stepped in time, along arrays: friction with memory, and a link behind a spring and a gap."""

from dataclasses import dataclass

import numpy as np

from talus import ffi, lib, pointer

MOST_STEPS = 60  # of the link for one sample
LARGEST_STEP = 1.0  # rad: beyond it a stepped oscillation grows


def dahl(position, travel, power):
    """Dahl's friction state in [-1, 1] along a position, power 1 or 2."""
    position, state = np.ascontiguousarray(position, float), np.empty(len(position))
    lib.tl_gap_dahl(pointer(position), len(position), travel, power == 2, pointer(state))
    return state


@dataclass(frozen=True)
class LinkShape:
    """A link behind a spring [Nm/rad] and a gap of +-half [rad]; `share` of the friction stands on the link's side."""

    stiffness: float
    half: float
    share: float


def link_behind(shape, step_s, motor_speed, other_Nm, inertia, coulomb_Nm, viscous):
    """Angle of the link less the motor's, and torque through the spring.

    The motor's speed (at the joint) is given on an even grid, and the torque `other_Nm` that the link needs besides
    its inertia and friction."""
    link = ffi.new("tl_gap_link *", {
        "stiffness_Nm_rad": shape.stiffness, "gap_rad": 2 * shape.half, "friction_share": shape.share,
        "inertia_kg_m2": inertia, "coulomb_Nm": coulomb_Nm, "viscous_Nms_rad": viscous, "step_s": step_s})  # fmt: skip
    motor_speed, other_Nm = (np.ascontiguousarray(x, float) for x in (motor_speed, other_Nm))
    angle, torque = np.empty(len(motor_speed)), np.empty(len(motor_speed))
    lib.tl_gap_link_along(link, pointer(motor_speed), pointer(other_Nm), len(angle), pointer(angle), pointer(torque))
    return angle, torque
