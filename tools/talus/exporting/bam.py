"""One joint's drive as the JSON of BAM, whose models M1 (Coulomb, viscous) and M2 (with Stribeck's) it takes."""

from __future__ import annotations

import json
from typing import Any

from talus import Model

from .target import Held

ACTUATOR = "erob80_100"  # of those that BAM has, one whose command is a current


def tree(model: Model, held: Held, joint: int) -> dict[str, Any]:
    """The keys of BAM's parameter files; torques at the joint."""
    drive, own, stribeck = model.struct.drive[joint], held.chain.joints[joint], held.stribeck[joint]
    gear = own.ratio if model.plant == "leg" else model.transmission(joint).ratio([0.0])[0]
    out = {"model": "m2" if stribeck else "m1", "actuator": ACTUATOR, "kt": abs(drive.torque_constant_Nm_A * gear), "armature": own.armature,
           "friction_base": held.term(joint, "coulomb_Nm"), "friction_viscous": held.term(joint, "viscous_Nms_rad"), "q_offset": 0.0,
           "command_delay": 0.0}  # fmt: skip
    if stribeck:
        out |= {"friction_stribeck": stribeck["extra_Nm"], "dtheta_stribeck": stribeck["speed_rad_s"], "alpha": stribeck["exponent"]}
    return out


def text(model: Model, held: Held, joint: int) -> str:
    return json.dumps(tree(model, held, joint), indent=1) + "\n"
