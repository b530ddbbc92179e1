"""A model's drives as a Python module with Isaac Lab's actuator configuration. Torques are at the joint; gains are the user's.

DelayedPDActuatorCfg stands for a drive whose command comes late, RemotizedPDActuatorCfg for one whose torque limit depends on
the angle, as a linkage's does: https://isaac-sim.github.io/IsaacLab (isaaclab.actuators).
"""

from __future__ import annotations

import numpy as np

from talus import Model, lib

from .chain import ratios
from .limits import Limits
from .target import Held

KNOTS = 13


def text(model: Model, held: Held, limits: Limits, comment: str) -> str:
    lines = [f'"""{comment}"""', "", "from isaaclab.actuators import DCMotorCfg, RemotizedPDActuatorCfg  # noqa: F401", "",
             "STIFFNESS, DAMPING = {}, {}  # gains of your controller, by joint: {\"knee\": 40.0}", "", "ACTUATORS = {"]  # fmt: skip
    for j in range(len(held.chain.joints)):
        lines += _drive(model, held, j, limits)
    return "\n".join([*lines, "}", ""])


def _drive(model: Model, held: Held, j: int, limits: Limits) -> list[str]:
    joint, linked = held.chain.joints[j], model.struct.drive[j].transmission.kind != lib.TL_TRANSMISSION_FIXED
    effort, speed = limits.torque[j], limits.speed[j]
    friction = held.term(j, "coulomb_Nm")
    kind = "RemotizedPDActuatorCfg" if linked and effort else "DCMotorCfg"
    lines = [f'    "{joint.name}": {kind}(', f'        joint_names_expr=["{joint.name}"],', f'        stiffness=STIFFNESS.get("{joint.name}", 0.0),',
             f'        damping=DAMPING.get("{joint.name}", 0.0),', f"        armature={joint.armature!r},", f"        friction={friction!r},",
             f"        dynamic_friction={friction!r},", f"        viscous_friction={held.term(j, 'viscous_Nms_rad')!r},"]  # fmt: skip
    if speed:
        lines.append(f"        velocity_limit={speed!r},")
    if kind == "DCMotorCfg":
        lines += [f"        effort_limit={effort or float('1e9')!r},", f"        saturation_effort={effort or float('1e9')!r},"]
    else:
        lines.append(f"        joint_parameter_lookup={_lookup(model, j, limits)},")
    return [*lines, "    ),"]


def _lookup(model: Model, j: int, limits: Limits) -> list[list[float]]:
    """Joint angle, ratio, torque limit at the joint: the motor's torque at angle 0 times the ratio elsewhere."""
    low, high = limits.position[j] or (-np.pi / 6, np.pi / 6)
    angles = np.linspace(low, high, KNOTS)
    ratio = ratios(model, j, angles)
    at_zero = float(ratios(model, j, np.zeros(1))[0])
    return [[float(q), float(abs(r)), float((limits.torque[j] or 0.0) * abs(r / at_zero))] for q, r in zip(angles, ratio, strict=True)]
