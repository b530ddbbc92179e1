"""Effects in forward time: what they do when the motion is not the recorded one. Friction turns with the direction, a
spring pulls back, and friction with a memory follows the motion's own path; all else acts as it does along the recorded
motion.
"""

import numpy as np

from .effects import EFFECTS, Motion

SMALL = 1e-6  # rad, of differences


def one_way(scene, way):
    """The scene as if every joint slid in one direction throughout, as far as friction goes."""
    out = scene.copied()
    out.slip, out.v = np.full_like(scene.slip, way), way * np.abs(scene.v)
    change = np.array([scene.coulomb_Nm[j] * out.slip[j] + scene.viscous[j] * out.v[j]
                       for j in range(len(scene.v))]) - scene.friction_Nm  # fmt: skip
    out.friction_Nm, out.joint_Nm = scene.friction_Nm + change, scene.joint_Nm + change
    return out


def moved(scene, joint):
    """The scene with one joint a little further."""
    out = scene.copied()
    out.q = scene.q.copy()
    out.q[joint] += SMALL
    return out


class Memory:
    """Friction with a memory (Dahl) at one joint: its size, and its state along the recorded motion."""

    def __init__(self, joint, parameters, torque_Nm, size_Nm):
        self.joint, self.size_Nm = joint, max(float(np.median(size_Nm)), 1e-12)
        self.travel, self.power = parameters["travel_rad"], parameters.get("power", 1.0)
        self.recorded = np.clip(torque_Nm / self.size_Nm, -1.0, 1.0)

    def moved(self, state, way):
        """The state after a way."""
        side = np.where(way > 0, 1.0, -1.0)
        rest, x = 1.0 - side * state, np.abs(way) / self.travel
        if self.power == 1.0:
            rest = rest * np.exp(-x)
        else:
            rest = (np.maximum(rest, 1e-12) ** (1 - self.power) + (self.power - 1) * x) ** (1 / (1 - self.power))
        return side * (1.0 - rest)


class Acting:
    """What effects add to a plant along one recording, on the grid: `sliding_Nm` is what is to be added to the
    residual so that it no longer jumps with the recorded direction, `level_Nm` the dry friction that stands for it,
    `slope_Nm_rad` how springs pull back."""

    def __init__(self, search, record, chosen, residuals):
        self.scene = search.scenes[record]
        joints, n = search.evidence.joints, len(self.scene.track.grid_t_s)
        self.sliding_Nm, self.level_Nm = np.zeros((joints, n)), np.zeros((joints, n))
        self.slope_Nm_rad, self.memories = np.zeros((joints, joints, n)), []
        columns = [(candidate, column) for candidate in chosen for column in candidate.columns]
        for (candidate, column), strength in zip(columns, residuals.strengths[len(residuals.strengths) - len(columns):]):
            motion = EFFECTS[candidate.effect].motion
            if motion in (Motion.FRICTION, Motion.HYSTERESIS):
                self._add_friction(candidate, column, strength)
            if motion is Motion.SPRING:
                self._add_spring(column, strength)

    def _at_joints(self, shown, strength):
        """The torque column of each joint that has one: (joint, torque at the joint)."""
        return [(j, strength * self.scene.grid("ratio", j) * shown[f"T{j}"])
                for j in range(len(self.level_Nm)) if f"T{j}" in shown]  # fmt: skip

    def _add_friction(self, candidate, column, strength):
        ahead, back, as_it_is = (self._at_joints(column(s), strength)
                                 for s in (one_way(self.scene, 1.0), one_way(self.scene, -1.0), self.scene))  # fmt: skip
        for (j, plus), (_, minus), (_, shown) in zip(ahead, back, as_it_is):
            self.sliding_Nm[j] += shown - 0.5 * (plus + minus)
            self.level_Nm[j] += 0.5 * (plus - minus)
            if EFFECTS[candidate.effect].motion is Motion.HYSTERESIS:
                figures = candidate.parameters([strength])
                self.memories.append(Memory(j, figures, 0.5 * (plus + minus), 0.5 * (minus - plus)))

    def _add_spring(self, column, strength):
        here = self._at_joints(column(self.scene), strength)
        for i in range(len(self.level_Nm)):
            for (j, there), (_, torque) in zip(self._at_joints(column(moved(self.scene, i)), strength), here):
                self.slope_Nm_rad[j, i] += (there - torque) / SMALL
