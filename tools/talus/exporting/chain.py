"""A model as rigid links and joints, as simulators want them: z up, a link hangs along -z, hinges turn about y.

The angle q of a hinge turns the hanging link towards -x, so that the potential of a link with centre c is -m g c cos q, as
docs/equations.md has it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from talus import Model, lib
from talus._arrays import Array
from talus._library import check, ffi
from talus.refused import Refused


@dataclass(frozen=True)
class Link:
    """What a joint moves: centre `com_m` and next joint `length_m` below it; inertia about the centre [kg m^2]."""

    name: str
    mass_kg: float
    com_m: float
    inertia_kg_m2: float
    length_m: float = 0.0


@dataclass(frozen=True)
class Twist:
    """A transmission that gives way: a motor of so much inertia (0: the armature alone) before a spring."""

    inertia_kg_m2: float
    stiffness_Nm_rad: float
    damping_Nms_rad: float
    hardening_Nm_rad3: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A joint and its drive; torques at the joint. `ratio` is torque at the joint over torque as the model counts it, `gear` over the motor's."""

    name: str
    link: Link
    slides: bool
    ratio: float
    gear: float
    armature: float
    coulomb: float
    viscous: float
    constant: float  # torque that the joint takes at any motion
    twist: Twist | None = None


@dataclass(frozen=True)
class Chain:
    """The joints from the base outwards. `zero_rad` is the angle at which the first link hangs straight down."""

    name: str
    joints: tuple[Joint, ...]
    gravity_m_s2: float
    zero_rad: float = 0.0


def of(model: Model, twists: dict[int, tuple[float, float, float, float]] | None = None) -> Chain:
    """The chain of a model. `twists` gives a joint's (motor share, stiffness, damping, hardening) where it is not rigid."""
    s, twists = model.struct, twists or {}
    if s.form != lib.TL_FORM_LAGRANGE:
        raise Refused(2, "form: expected lagrange, found paper: its terms are no rigid bodies'")
    links = {"leg": _leg, "pendulum": _pendulum, "slider": _slider}.get(model.plant)
    if links is None:
        raise Refused(2, f"plant: expected leg, pendulum or slider, found {model.plant}")
    share = {j: numbers[0] for j, numbers in twists.items()}
    bodies, own = links(s, share)
    joints = [_joint(model, j, body) for j, body in enumerate(bodies)]
    for j, (part, stiffness, damping, hardening) in twists.items():
        joints[j] = replace(joints[j], twist=Twist(part * own[j], stiffness, damping, hardening))
    zero = s.gravity_zero_rad if model.plant == "pendulum" else 0.0
    return Chain(model.plant, tuple(joints), s.gravity_m_s2 if model.has_gravity else 0.0, zero)


def _joint(model: Model, j: int, link: Link) -> Joint:
    s, drive = model.struct, model.struct.drive[j]
    ratio = float(lib.tl_torque_ratio(s, j, 0.0))
    armature = drive.rotor_inertia_kg_m2 * ratio**2 if model.plant == "leg" and j == 1 else 0.0
    return Joint(model.joints[j], link, model.coordinate_unit == "m", ratio, float(lib.tl_motor_ratio(s, j, 0.0)), armature, drive.coulomb_Nm,
                 drive.viscous_Nms_rad, float(lib.tl_joint_offset(s, j)))  # fmt: skip


def _leg(s: Any, share: dict[int, float]) -> tuple[list[Link], list[float]]:
    """Shank with the ankle's motor on it, and foot: J and the moment of docs/equations.md (12)."""
    mass = s.shank_mass_kg + s.ankle_motor_mass_kg
    moment = s.shank_mass_kg * s.shank_com_m + s.ankle_motor_mass_kg * s.ankle_motor_com_m
    own = s.shank_inertia_kg_m2
    about_knee = own * (1 - share.get(0, 0.0)) + s.shank_mass_kg * s.shank_com_m**2 + s.ankle_motor_mass_kg * s.ankle_motor_com_m**2
    shank = Link("shank", mass, moment / mass, about_knee - moment**2 / mass, s.shank_length_m)
    foot = Link("foot", s.foot_mass_kg, s.foot_com_m, s.foot_inertia_kg_m2)
    return [shank, foot], [own, 0.0]  # an ankle's rotor is its armature


def _pendulum(s: Any, share: dict[int, float]) -> tuple[list[Link], list[float]]:
    """Any mass and centre with the model's moment and inertia serve: here the centre's inertia is half of all."""
    inertia = s.inertia_kg_m2 * (1 - share.get(0, 0.0))
    moment = s.gravity_moment_kg_m
    com = inertia / (2 * moment) if moment else 0.0
    link = Link("arm", moment / com if moment else 1.0, com, inertia / 2 if moment else inertia)
    return [link], [s.inertia_kg_m2]


def _slider(s: Any, share: dict[int, float]) -> tuple[list[Link], list[float]]:
    if share:
        raise Refused(2, "effects: a slider's elasticity has no counterpart")
    return [Link("carriage", s.mass_kg, 0.0, 0.01)], [0.0]


def ratios(model: Model, joint: int, q: Array) -> Array:
    """Torque at the joint over torque as the model counts it, along joint positions."""
    return np.array([lib.tl_torque_ratio(model.struct, joint, float(x)) for x in q])


def constant_ratio(model: Model) -> Model:
    """The model with each ratio as it is at joint angle 0."""
    out = model.copy()
    for j in range(len(model.joints)):
        drive = out.struct.drive[j]
        if drive.transmission.kind != lib.TL_TRANSMISSION_FIXED:
            ratio = float(lib.tl_torque_ratio(model.struct, j, 0.0))
            fixed = ffi.new("tl_transmission *")
            check(lib.tl_transmission_fixed(fixed, ratio))
            drive.transmission = fixed[0]
    return out
