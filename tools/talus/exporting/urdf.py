"""A model as URDF, with ros2_control's interfaces, limits and transmissions."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from .chain import Joint
from .limits import Limits
from .target import Held
from .xml_text import add, number, numbers, to_text

NO_LIMIT = 1e9  # URDF wants a number for every effort and speed


def text(held: Held, limits: Limits, comment: str) -> str:
    root = ET.Element("robot", name=held.chain.name)
    add(root, "link", name="base")
    parent, below = "base", 0.0
    for j, joint in enumerate(held.chain.joints):
        _joint(root, held, j, parent, below, limits)
        _link(root, joint)
        parent, below = joint.link.name, joint.link.length_m
    _ros2_control(root, held, limits)
    return to_text(root, comment)


def _joint(root: ET.Element, held: Held, j: int, parent: str, below: float, limits: Limits) -> None:
    joint, position = held.chain.joints[j], limits.position[j]
    kind = "prismatic" if joint.slides else "revolute" if position else "continuous"
    element = add(root, "joint", name=joint.name, type=kind)
    pitch = -held.chain.zero_rad if j == 0 else 0.0
    add(element, "origin", xyz=(0, 0, -below), rpy=(0, pitch, 0))
    add(element, "parent", link=parent)
    add(element, "child", link=joint.link.name)
    add(element, "axis", xyz=(1, 0, 0) if joint.slides else (0, 1, 0))
    bounds = {"lower": position[0], "upper": position[1]} if position else {"lower": -NO_LIMIT, "upper": NO_LIMIT} if joint.slides else {}
    add(element, "limit", effort=limits.torque[j] or NO_LIMIT, velocity=limits.speed[j] or NO_LIMIT, **bounds)
    add(element, "dynamics", damping=held.term(j, "viscous_Nms_rad"), friction=held.term(j, "coulomb_Nm"))


def _link(root: ET.Element, joint: Joint) -> None:
    inertial = add(add(root, "link", name=joint.link.name), "inertial")
    add(inertial, "origin", xyz=(0, 0, -joint.link.com_m), rpy=(0, 0, 0))
    add(inertial, "mass", value=joint.link.mass_kg)
    i = joint.link.inertia_kg_m2
    add(inertial, "inertia", ixx=i, iyy=i, izz=i, ixy=0, ixz=0, iyz=0)


def _ros2_control(root: ET.Element, held: Held, limits: Limits) -> None:
    control = add(root, "ros2_control", name=held.chain.name, type="system")
    add(add(control, "hardware"), "plugin", "mock_components/GenericSystem")
    for j, joint in enumerate(held.chain.joints):
        element, position = add(control, "joint", name=joint.name), limits.position[j]
        for interface, bounds in (("position", position), ("velocity", _both(limits.speed[j])), ("effort", _both(limits.torque[j]))):
            command = add(element, "command_interface", name=interface)
            for name, value in zip(("min", "max"), bounds or (), strict=False):
                add(command, "param", numbers(value), name=name)
        for interface in ("position", "velocity", "effort"):
            add(element, "state_interface", name=interface)
        if joint.ratio != 1.0:
            _transmission(control, joint)


def _transmission(control: ET.Element, joint: Joint) -> None:
    transmission = add(control, "transmission", name=f"{joint.name}_transmission")
    add(transmission, "plugin", "transmission_interface/SimpleTransmission")
    add(transmission, "actuator", name=f"{joint.name}_motor", role="actuator1")
    element = add(transmission, "joint", name=joint.name, role="joint1")
    add(element, "mechanical_reduction", number(joint.ratio))


def _both(limit: float | None) -> tuple[float, float] | None:
    return (-limit, limit) if limit else None
