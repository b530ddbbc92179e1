"""Effects as sums of terms that simulators know of a joint, where their law is such a sum."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from talus._library import ffi, lib

# What a term's number multiplies in the torque at the joint, along its motion; `slip` is the direction of sliding.
COLUMNS = {
    "coulomb_Nm": lambda q, v, slip: slip,
    "viscous_Nms_rad": lambda q, v, slip: v,
    "viscous_Nms2_rad2": lambda q, v, slip: v * abs(v),
    "viscous_Nms3_rad3": lambda q, v, slip: v**3,
    "stiffness_Nm_rad": lambda q, v, slip: q,
    "stiffness_Nm_rad2": lambda q, v, slip: q**2,
    "stiffness_Nm_rad3": lambda q, v, slip: q**3,
    "constant_Nm": lambda q, v, slip: 0.0 * q + 1.0,
}


def name(effect: Any) -> str:
    return str(ffi.string(effect.kind.name).decode())


def values(effect: Any) -> dict[str, float]:
    """The effect's parameters by name."""
    kind = effect.kind
    count = kind.strengths + kind.shapes
    return {ffi.string(kind.parameter[i].name).decode(): float(effect.value[i]) for i in range(count)}


def _nonlinear_viscous(v: dict[str, float]) -> dict[str, float] | None:
    power = {1.0: "viscous_Nms_rad", 2.0: "viscous_Nms2_rad2", 3.0: "viscous_Nms3_rad3"}.get(v["exponent"])
    return {power: v["size_Nm"]} if power and not v["saturation_rad_s"] else None


def _parallel_spring(v: dict[str, float]) -> dict[str, float] | None:
    if v["bumper_Nm_rad"]:
        return None
    return {"stiffness_Nm_rad": v["stiffness_Nm_rad"], "stiffness_Nm_rad2": v["bend_Nm_rad2"],
            "stiffness_Nm_rad3": v["stiffening_Nm_rad3"], "constant_Nm": v["preload_Nm"]}  # fmt: skip


EXACT: dict[str, Callable[[dict[str, float]], dict[str, float] | None]] = {
    "stribeck": lambda v: {"stribeck": v["extra_Nm"]},
    "nonlinear_viscous": _nonlinear_viscous,
    "parallel_spring": _parallel_spring,
    "current_offset": lambda v: {"shown_Nm": v["torque_Nm"]},
    "torque_constant": lambda v: {"gain": v["excess"]},
    "gravity_tilt": lambda v: {"tilt_rad": v["tilt_rad"]},
    "elasticity": lambda v: {"twist": 1.0} if spring(v) else None,
}


def exact(effect: Any) -> dict[str, float] | None:
    """The terms whose sum the effect's law is, those that are not 0; None where it is no such sum."""
    law = EXACT.get(name(effect))
    found = law and law(values(effect))
    return found and {term: number for term, number in found.items() if number}


def spring(v: dict[str, float]) -> tuple[float, float, float, float] | None:
    """(motor share, stiffness, damping, hardening) of an elasticity that is a linear spring with a cubic part, with all friction
    on the motor's side; else None."""
    compliance = v["share"] / v["stiffness_Nm_rad"] + v["compliance_rad_Nm"]
    soft = v["soft_rad"] and v["soft_share"] != 1.0
    if not compliance or soft or v["friction_share"] or v["viscous_share"] or v["friction_compliance_rad_Nm"]:
        return None
    return v["motor_share"], 1.0 / compliance, v["damping_s"] / compliance, v["hardening_Nm_rad3"]


def acts_by_law(effect: Any) -> bool:
    """Is it a torque of the instant at the joint, which forward time knows?"""
    acting = effect.kind.acts == lib.TL_EFFECT_MECHANICAL and effect.kind.law != ffi.NULL
    return bool(acting and lib.tl_effect_fit_only(ffi.new("tl_effect *", effect)) < 0 and not lib.tl_effect_needs_temperature(ffi.new("tl_effect *", effect)))
