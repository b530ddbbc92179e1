"""What a target holds of a model, and the model fitted into it: terms of each joint, and the loss report."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from talus import Model, Recording, lib
from talus._arrays import Array
from talus._library import ffi

from . import chain, loss, terms

FORCES = "talus.mujoco.Runtime.forces"
SHOWN = "talus.mujoco.Runtime.shown"
HELPS = 0.9  # nearest terms that leave more of the torque than this are left out
BY_FORCES = {"presliding", "backlash", "elasticity", "linkage_error", "torque_saturation", "current_offset", "torque_constant"}
BY_SHOWN = {"delay", "encoder_eccentricity", "sensor_offset"}  # what sensors show: no simulated torque depends on it


@dataclass(frozen=True)
class Target:
    """A kind of file: the terms that it takes of a joint, those that it fits others by, and whether callbacks are there."""

    name: str
    takes: frozenset[str]
    fits_by: tuple[str, ...]
    callbacks: bool = False
    armature: bool = True


TARGETS = {
    "mjcf": Target("mjcf", frozenset(terms.COLUMNS) | {"shown_Nm", "gain", "tilt_rad", "twist"},
                   ("coulomb_Nm", "viscous_Nms_rad", "constant_Nm"), callbacks=True),
    "urdf": Target("urdf", frozenset({"coulomb_Nm", "viscous_Nms_rad"}), ("coulomb_Nm", "viscous_Nms_rad"), armature=False),
    "sdf": Target("sdf", frozenset({"coulomb_Nm", "viscous_Nms_rad", "stiffness_Nm_rad"}),
                  ("coulomb_Nm", "viscous_Nms_rad", "stiffness_Nm_rad"), armature=False),
    "bam": Target("bam", frozenset({"coulomb_Nm", "viscous_Nms_rad", "stribeck"}), ("coulomb_Nm", "viscous_Nms_rad")),
    "isaac": Target("isaac", frozenset({"coulomb_Nm", "viscous_Nms_rad"}), ("coulomb_Nm", "viscous_Nms_rad")),
}  # fmt: skip


@dataclass
class Held:
    """A model as a target holds it: added terms by joint, numbers of its own kind, and the report's entries."""

    chain: chain.Chain
    added: list[dict[str, float]]
    stribeck: list[dict[str, float]]
    entries: list[dict[str, Any]] = field(default_factory=list)
    motion_s: float = 0.0

    def term(self, joint: int, name: str) -> float:
        """A term of a joint with the model's own in it; dry and viscous friction are never below 0."""
        own = self.chain.joints[joint]
        base = {"coulomb_Nm": own.coulomb, "viscous_Nms_rad": own.viscous, "constant_Nm": own.constant}.get(name, 0.0)
        total = base + self.added[joint].get(name, 0.0)
        return max(total, 0.0) if name in loss.LINEAR else total


def fit(model: Model, target: Target, recording: Recording | None) -> Held:
    """The model as the target holds it, with a report entry for each effect and each part of the plain model that it lacks."""
    twists = twists_of(model) if "twist" in target.takes else {}
    held = Held(chain.of(model, twists), [{} for _ in model.joints], [{} for _ in model.joints])
    motion = loss.along(model, recording or loss.default_recording(model))
    held.motion_s = float(motion.recording.t[-1] - motion.recording.t[0])
    _plain_losses(model, target, held, motion)
    for number, effect in enumerate(model.effects):
        held.entries.append(_one(model, number, effect, target, held, motion))
    return held


def twists_of(model: Model) -> dict[int, tuple[float, float, float, float]]:
    """(motor share, stiffness, damping, hardening) of the joints that are not rigid and have all friction on the motor's side. A
    gap and a soft zone are left to the callback."""
    effects, out = ffi.new("tl_effect[]", model.effects), {}
    for j in range(len(model.joints)):
        c = lib.tl_effects_change(effects, len(model.effects), j)
        if c.compliance_rad_Nm > 0 and not (c.friction_share or c.viscous_share or c.drag_Nm or c.offset_share):
            out[j] = (c.motor_share, 1 / c.compliance_rad_Nm, c.damping_s / c.compliance_rad_Nm, c.hardening_Nm_rad3)
    return out


def take_exact(model: Model, target: Target, held: Held) -> None:
    """Adds the terms of each effect that the target holds exactly."""
    for effect in model.effects:
        added = terms_of(model, effect)
        if added is not None and set(added) <= target.takes:
            _take(held, effect, added)


def terms_of(model: Model, effect: Any) -> dict[str, float] | None:
    """Its exact terms; none of a spring in series with a gap, nor of a motor's constant torque that the joint feels by its angle."""
    if terms.name(effect) == "current_offset" and model.plant != "leg":
        if model.struct.drive[effect.joint].transmission.kind != lib.TL_TRANSMISSION_FIXED:
            return None
    rattles = any(terms.name(e) == "backlash" and e.joint == effect.joint for e in model.effects)
    return None if rattles and terms.name(effect) == "elasticity" else terms.exact(effect)


def _plain_losses(model: Model, target: Target, held: Held, motion: loss.Motion) -> None:
    """Ratios that depend on the angle, rotors and constant torques, where the target lacks them."""
    for j, joint in enumerate(held.chain.joints):
        if model.struct.drive[j].transmission.kind != lib.TL_TRANSMISSION_FIXED and np.ptp(motion.ratio[j]) > 0:
            off = loss.of_plain(model, chain.constant_ratio(model), motion)[j]
            held.entries.append(_plain("ratio over the angle", joint.name, off, motion.rows[j], FORCES if target.callbacks else None,
                                       "as it is at angle 0"))  # fmt: skip
        if joint.armature and not target.armature:
            still = model.copy()
            still.struct.drive[j].rotor_inertia_kg_m2 = 0.0
            off = loss.of_plain(model, still, motion)[j]
            held.entries.append(_plain("rotor inertia", joint.name, off, motion.rows[j], None, "left out"))
        if joint.constant and "constant_Nm" not in target.takes:
            held.entries.append(_plain("torque offset", joint.name, np.full_like(motion.q[j], joint.constant), motion.rows[j], None, "left out"))


def _plain(what: str, joint: str, off: Array, rows: Array, callback: str | None, how: str) -> dict[str, Any]:
    (size,) = loss.rms(off[None], [rows])
    return loss.entry(what, joint, "approximate" if how != "left out" else "lost", torque_Nm=None, lost_Nm=size, callback=callback, note=how)


def _one(model: Model, number: int, effect: Any, target: Target, held: Held, motion: loss.Motion) -> dict[str, Any]:
    """The report's entry for one effect; what the target takes of it is added to `held`."""
    name, added = terms.name(effect), terms_of(model, effect)
    where = model.joints[effect.joint] if effect.joint < len(model.joints) else "base"
    torque = loss.torque_of(model, number, motion)
    callback = _callback(name, effect) if target.callbacks else None
    sizes = None if isinstance(torque, str) else loss.rms(torque, motion.rows)
    size = None if sizes is None else float(np.linalg.norm(sizes))
    if added is not None and set(added) <= target.takes and _take(held, effect, added):
        return loss.entry(name, where, "exact", torque_Nm=size, lost_Nm=0.0, callback=None, note=None)
    if isinstance(torque, str):
        return loss.entry(name, where, "callback" if callback else "lost", torque_Nm=None, lost_Nm=None, callback=callback, note=torque)
    left, terms_used = _nearest(torque, target, held, motion, effect)
    lost = float(np.linalg.norm(loss.rms(left, motion.rows)))
    how = "callback" if callback else "approximate" if terms_used else "lost"
    return loss.entry(name, where, how, torque_Nm=size, lost_Nm=lost, callback=callback, note=_words(terms_used) or None)


def _callback(name: str, effect: Any) -> str | None:
    """The callback that carries it; None where none does."""
    v = terms.values(effect)
    if name in BY_SHOWN:
        return None if v.get("angles_too") or v.get("delay_s", 0.0) < 0 else SHOWN
    if name == "kinematic_error" and (v["sine_rad"] or v["cosine_rad"]):
        return None
    if name in ("elasticity", "backlash") and (v["friction_share"] or v["viscous_share"] or v.get("drag_Nm") or v.get("offset_share") or v.get("friction_compliance_rad_Nm")):
        return None
    return FORCES if name in BY_FORCES or terms.acts_by_law(effect) else None


def _take(held: Held, effect: Any, added: dict[str, float]) -> bool:
    """Adds exact terms; False where the target has one place for them, and it is taken."""
    if "stribeck" in added:
        if held.stribeck[effect.joint]:
            return False
        held.stribeck[effect.joint] = terms.values(effect)
    if effect.joint < len(held.added):
        for term, number in added.items():
            held.added[effect.joint][term] = held.added[effect.joint].get(term, 0.0) + number
    else:
        held.added[0]["tilt_rad"] = held.added[0].get("tilt_rad", 0.0) + added["tilt_rad"]
    return True


def _nearest(torque: Array, target: Target, held: Held, motion: loss.Motion, effect: Any) -> tuple[Array, dict[str, float]]:
    """What is left of a torque after the target's nearest terms at the effect's joint, which are added to `held` where they
    help; and those terms. Only what acts on a joint by a law of the instant has such; a target with callbacks needs none."""
    left, j = torque.copy(), effect.joint
    if target.callbacks or j >= len(held.added) or not terms.acts_by_law(effect):
        return left, {}
    found = loss.fitted(torque[j], j, motion, target.fits_by, {term: -held.term(j, term) for term in loss.LINEAR})
    rest = torque[j] - loss.sum_of(found, j, motion)
    before, after = (loss.rms(x[None], [motion.rows[j]])[0] for x in (torque[j], rest))
    if not found or after > HELPS * before:
        return left, {}
    left[j] = rest
    for term, number in found.items():
        held.added[j][term] = held.added[j].get(term, 0.0) + number
    return left, found


def _words(used: dict[str, float]) -> str:
    return "as " + ", ".join(f"{term} {number:.3g}" for term, number in used.items() if number) if used else ""
