"""A model as MuJoCo's MJCF. An actuator's control is torque as the model counts it: of the motor for a leg, of the joint else."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from functools import partial
from typing import Any

from .chain import Joint, Link
from .limits import Limits
from .target import Held
from .xml_text import add, number, to_text

FLOOR_Nm = 1e-9  # of friction, so that MuJoCo has a row for it that a callback can set
TINY_KG = 1e-12  # MuJoCo wants a mass of what moves
INERTIA_ACROSS = 1.001  # what lies across the hinge's axis does not count, but must close a triangle


def text(held: Held, limits: Limits, comment: str) -> str:
    root = ET.Element("mujoco", model=held.chain.name)
    add(root, "compiler", angle="radian", inertiafromgeom="false", autolimits="true")
    gravity, tilt = held.chain.gravity_m_s2, held.added[0].get("tilt_rad", 0.0)
    add(root, "option", timestep=0.001, integrator="RK4", gravity=(gravity * tilt, 0, -gravity))
    parent, below = add(root, "worldbody"), 0.0
    for j, joint in enumerate(held.chain.joints):
        parent = _bodies(parent, held, j, joint, below, limits)
        below = joint.link.length_m
    actuators = add(root, "actuator")
    sensors = add(root, "sensor")
    for j, joint in enumerate(held.chain.joints):
        _actuator(actuators, held, j, joint, limits)
        add(sensors, "jointpos", name=f"{joint.name}_position", joint=joint.name)
        add(sensors, "jointvel", name=f"{joint.name}_velocity", joint=joint.name)
        add(sensors, "actuatorfrc", name=f"{joint.name}_torque", actuator=joint.name)
    return to_text(root, comment)


def _bodies(parent: ET.Element, held: Held, j: int, joint: Joint, below: float, limits: Limits) -> ET.Element:
    """The joint's link below `parent`; with a spring between motor and link the motor is a body of its own."""
    twist = joint.twist
    place: dict[str, Any] = {"pos": (0, 0, -below)}
    if j == 0 and held.chain.zero_rad:
        place["euler"] = (0, -held.chain.zero_rad, 0)
    if twist:
        motor = add(parent, "body", name=f"{joint.name}_motor", **place)
        add(motor, "inertial", pos=(0, 0, 0), mass=TINY_KG, diaginertia=_across(max(twist.inertia_kg_m2, 1e-12)))
        _hinge(motor, held, j, joint, limits)
        parent, place = motor, {}
    body = add(parent, "body", name=joint.link.name, **place)
    if twist:
        stiffness = (twist.stiffness_Nm_rad, 0.0, twist.hardening_Nm_rad3) if twist.hardening_Nm_rad3 else (twist.stiffness_Nm_rad,)
        add(body, "joint", name=f"{joint.name}_twist", type="hinge", axis=(0, 1, 0), stiffness=stiffness, damping=twist.damping_Nms_rad)
    else:
        _hinge(body, held, j, joint, limits)
    _link(body, joint.link)
    return body


def _across(inertia: float) -> tuple[float, float, float]:
    return inertia * INERTIA_ACROSS, inertia, inertia * INERTIA_ACROSS


def _link(body: ET.Element, link: Link) -> None:
    add(body, "inertial", pos=(0, 0, -link.com_m), mass=link.mass_kg, diaginertia=_across(link.inertia_kg_m2))
    reach = link.length_m or 2 * abs(link.com_m) or 0.1
    add(body, "geom", type="capsule", fromto=(0, 0, 0, 0, 0, -reach), size=0.02, contype="0", conaffinity="0")


def _hinge(body: ET.Element, held: Held, j: int, joint: Joint, limits: Limits) -> None:
    term = partial(held.term, j)
    more: dict[str, Any] = {"range": limits.position[j]} if limits.position[j] else {}
    add(body, "joint", name=joint.name, type="slide" if joint.slides else "hinge", axis=(1, 0, 0) if joint.slides else (0, 1, 0),
        armature=joint.armature, solreffriction=(1e-4, 1), solimpfriction=(0.9999, 0.9999, 1e-3, 0.5, 2), frictionloss=max(term("coulomb_Nm"), FLOOR_Nm),
        damping=_poly(term("viscous_Nms_rad"), term("viscous_Nms2_rad2"), term("viscous_Nms3_rad3")),
        stiffness=_poly(term("stiffness_Nm_rad"), term("stiffness_Nm_rad2"), term("stiffness_Nm_rad3")), **more)  # fmt: skip


def _poly(*parts: float) -> tuple[float, ...]:
    """Without the zeros at the end: MuJoCo before 3.8 knows one number alone."""
    while len(parts) > 1 and not parts[-1]:
        parts = parts[:-1]
    return parts


def _actuator(actuators: ET.Element, held: Held, j: int, joint: Joint, limits: Limits) -> None:
    gain = 1.0 + held.added[j].get("gain", 0.0)
    bias = -gain * held.added[j].get("shown_Nm", 0.0) * joint.gear / joint.ratio - held.term(j, "constant_Nm") / joint.ratio
    effort = limits.torque[j]
    more: dict[str, Any] = {"ctrlrange": (-effort / abs(joint.ratio), effort / abs(joint.ratio))} if effort else {}
    add(actuators, "general", name=joint.name, joint=joint.name, gear=number(joint.ratio), gainprm=gain, biastype="affine", biasprm=(bias, 0, 0), **more)
