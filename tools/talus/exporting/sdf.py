"""A model as SDF 1.10: what Gazebo and Drake read. Poses are in the frame of the link that a link hangs from."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from .chain import Joint
from .limits import Limits
from .target import Held
from .xml_text import add, numbers, to_text


def text(held: Held, limits: Limits, comment: str) -> str:
    root = ET.Element("sdf", version="1.10")
    model = add(root, "model", name=held.chain.name)
    add(model, "static", "false")
    parent, below = "world", 0.0
    for j, joint in enumerate(held.chain.joints):
        _link(model, held, j, parent, below)
        _joint(model, held, j, joint, parent, limits)
        parent, below = joint.link.name, joint.link.length_m
    return to_text(root, comment)


def _link(model: ET.Element, held: Held, j: int, parent: str, below: float) -> None:
    link = held.chain.joints[j].link
    element = add(model, "link", name=link.name)
    pitch = -held.chain.zero_rad if j == 0 else 0.0
    add(element, "pose", numbers(0, 0, -below, 0, pitch, 0), **({"relative_to": parent} if j else {}))
    inertial = add(element, "inertial")
    add(inertial, "pose", numbers(0, 0, -link.com_m, 0, 0, 0))
    add(inertial, "mass", link.mass_kg)
    inertia = add(inertial, "inertia")
    for name in ("ixx", "iyy", "izz"):
        add(inertia, name, link.inertia_kg_m2)
    for name in ("ixy", "ixz", "iyz"):
        add(inertia, name, 0.0)


def _joint(model: ET.Element, held: Held, j: int, joint: Joint, parent: str, limits: Limits) -> None:
    element = add(model, "joint", name=joint.name, type="prismatic" if joint.slides else "revolute")
    add(element, "parent", parent)
    add(element, "child", joint.link.name)
    axis = add(element, "axis")
    add(axis, "xyz", "1 0 0" if joint.slides else "0 1 0")
    limit = add(axis, "limit")
    low, high = limits.position[j] or (float("-inf"), float("inf"))
    for name, value in (("lower", low), ("upper", high), ("effort", limits.torque[j]), ("velocity", limits.speed[j])):
        if value is not None:
            add(limit, name, value)
    dynamics = add(axis, "dynamics")
    add(dynamics, "damping", held.term(j, "viscous_Nms_rad"))
    add(dynamics, "friction", held.term(j, "coulomb_Nm"))
    add(dynamics, "spring_reference", 0.0)
    add(dynamics, "spring_stiffness", held.term(j, "stiffness_Nm_rad"))
