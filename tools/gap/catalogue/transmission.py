"""Effects between motor and link: springs, gaps, and what stands in parallel with the joint."""

import numpy as np

from ..loops import LARGEST_STEP, MOST_STEPS, LinkShape, link_behind
from .candidate import Candidate, Family, library_column, named

STIFFNESSES_NM_RAD = (200, 400, 800, 1500, 3000, 6000, 12000)
GAPS_RAD = (0.0007, 0.0015, 0.003, 0.005, 0.008, 0.012)
BACKLASH_STIFFNESSES_NM_RAD = (12000, 3000)
MOTOR_SHARE = 0.15  # of the joint's own inertia that turns with its motor: a knee's rotor through its ratio
FRICTION_SHARES = (1, 0.6, 0.3, 0)  # of the friction that stands on the link's side
BUMPER_BEGINS = (0.0, 0.3, 0.6)  # of half the range


def parallel_spring(at):
    # a sensor at the output twists with its load: angle and torque then look like a spring
    if at.evidence.velocity_only or at.evidence.load_sensor or not at.travels:
        return
    j, middle, half = at.number, at.extent.middle[at.number], at.extent.half_range[at.number]
    power = [at.joint_column(lambda s, p=p: s.q[j] ** p) for p in range(4)]
    names = ("preload_Nm", "stiffness_Nm_rad", "bend_Nm_rad2", "stiffening_Nm_rad3")

    def make(shape, powers, low=None):
        figures = named(*(names[p] for p in powers))
        zero = {names[p]: 0.0 for p in (0, 1, 3)}
        return Candidate("parallel_spring", at.name, shape, tuple(power[p] for p in powers),
                         lambda x: {**zero, **figures(x)}, low)  # fmt: skip

    yield make("line", (1,), (0.0,))
    yield make("cube", (3,), (0.0,))
    yield make("line and cube", (1, 3))
    yield make("polynomial", (1, 2, 3))
    yield make("polynomial and preload", (0, 1, 2, 3))
    if at.evidence.leg:
        yield make("line and preload", (1, 0))
    for side in (-1, 1):
        for begin in BUMPER_BEGINS:
            law = lambda s, d=side, b=begin: d * np.maximum(d * (s.q[j] - middle) - b * half, 0.0)
            yield Candidate("parallel_spring", at.name, f"bumper at {side * begin:g}", (at.joint_column(law),),
                            named("bumper_Nm_rad", bumper_rad=float(middle + side * begin * half), bumper_side=float(side)),
                            (0.0,))  # fmt: skip


def _shapes():
    springs = [LinkShape(k, 0.0, share) for share in FRICTION_SHARES for k in STIFFNESSES_NM_RAD]
    gaps = [LinkShape(k, gap / 2, share) for share in FRICTION_SHARES for k in BACKLASH_STIFFNESSES_NM_RAD
            for gap in GAPS_RAD]  # fmt: skip
    return springs, gaps


def _answer(scene, j, shape):
    """At the samples, of a link behind `shape`: its angle against the motor's, and torque and acceleration less those of
    a rigid one. To a link that can move on its own a stop of its motor is a jolt, so nothing is bridged before."""
    inertia, turning = _inertia(scene, j)
    load = scene.once(("load", j), lambda: scene.link_Nm[j] - turning * scene.a[j])
    other = scene.once(("other", j), lambda: load - inertia * scene.a[j])
    rigid = scene.once(("rigid", j, shape.share), lambda: load + shape.share * scene.friction_Nm[j])
    out = np.zeros((3, len(rigid)))
    for part in scene.track.parts:
        rows = slice(part["begin"], part["end"])
        out[:, rows] = link_behind(
            shape, scene.t_s[rows], (scene.q[j][rows], scene.v[j][rows]), other[rows], rigid[rows][0], inertia,
            scene.coulomb_Nm[j], scene.viscous[j])  # fmt: skip
        out[1:, rows] -= rigid[rows], scene.a[j][rows]
    return out


def _inertia(scene, j):
    """Of the link, and what of the joint's own turns with its motor."""
    if not scene.evidence.leg:
        turning = MOTOR_SHARE * scene.link_inertia[j]
    else:
        turning = MOTOR_SHARE * scene.evidence.tree["shank"]["inertia_kg_m2"] * (j == 0)
    return scene.link_inertia[j] - turning, turning


def _behind(j, shape):
    """What shows of a link behind `shape`, at the whole effect's strength."""

    def column(scene):
        track, (angle, torque, acceleration) = scene.track, _answer(scene, j, shape)
        shown = {f"T{j}": track.operate(torque / scene.ratio[j], j)}
        if scene.evidence.leg:
            for kind in ("E", "F") if j == 1 else ("K",):
                if kind in scene.evidence.kinds:
                    shown[kind] = track.operate(angle)
            # the other joint feels the link's acceleration and weight
            other = scene.inertia[0][1] * acceleration + scene.tilt_Nm()[1] * angle
            shown[f"T{1 - j}"] = track.operate(other / scene.ratio[1 - j], 1 - j)
        return shown

    return column


def _hidden(at):
    """Where no link behind the motor can be told: without an angle, or with the load measured before the link; or so
    light a link that its oscillation cannot be stepped."""
    fastest = np.sqrt(max(STIFFNESSES_NM_RAD) / at.scenes[0].link_inertia[at.number])
    slow = all(scene.step_s * fastest < MOST_STEPS * LARGEST_STEP for scene in at.scenes)
    return at.evidence.velocity_only or at.evidence.load_sensor or not slow


def _saved(at, shape):
    """The model file's parameters."""
    inertia = _inertia(at.scenes[0], at.number)[0]
    gap = {"gap_rad": 2 * shape.half} if shape.half else {}
    return named("share", stiffness_Nm_rad=shape.stiffness, damping_s=float(shape.damping_s(inertia)),
                 friction_share=shape.share, motor_share=MOTOR_SHARE, **gap)  # fmt: skip


def elasticity(at):
    if _hidden(at):
        return
    j = at.number

    def soft(stiffness, share):
        shape = LinkShape(stiffness, 0.0, share)
        figures = lambda x: {"compliance_rad_Nm": float(x[0]) / stiffness}
        return Candidate("elasticity", at.name, f"{stiffness:g} Nm/rad, {share:g} of friction at the link",
                         (_behind(j, shape),), figures, (0.5,), (1.8,), _saved(at, shape),
                         Family(soft, (stiffness, share), (2.0, 0.3), (100.0, 0.0), (30000.0, 1.0)))  # fmt: skip

    for shape in _shapes()[0]:
        yield soft(shape.stiffness, shape.share)

    # stiff: twist = load over stiffness, by the link's torque and, apart, by friction
    rest = {"stiffness_Nm_rad": 1000.0, "damping_s": 0.001}  # of the soft form, which takes no part
    link, friction = (library_column("elasticity", j, k, {**rest, "friction_share": 0.0, "motor_share": MOTOR_SHARE})
                      for k in (1, 2))  # fmt: skip
    rest["share"] = 0.0
    names = ("compliance_rad_Nm", "friction_compliance_rad_Nm")
    yield Candidate("elasticity", at.name, "stiff", (link,), named(names[0]), (0.0,), (0.01,),
                    saved=named(names[0], **rest))  # fmt: skip
    yield Candidate("elasticity", at.name, "stiff, friction apart", (link, friction), named(*names), (0.0, 0.0),
                    (0.01, 0.01), saved=named(*names, **rest))  # fmt: skip


def backlash(at):
    if _hidden(at):
        return

    def lost(gap, stiffness, share):
        shape = LinkShape(stiffness, gap / 2, share)
        figures = lambda x: {"gap_rad": float(x[0]) * gap, "stiffness_Nm_rad": stiffness}
        return Candidate("backlash", at.name, f"{1e3 * gap:.2g} mrad, {stiffness:g} Nm/rad, {share:g} of friction at the link",
                         (_behind(at.number, shape),), figures, (0.4,), (1.8,), _saved(at, shape),
                         Family(lost, (gap, stiffness, share), (1.7, 3.0, 0.3), (2e-4, 500.0, 0.0),
                                (0.03, 50000.0, 1.0)))  # fmt: skip

    for shape in _shapes()[1]:
        yield lost(2 * shape.half, float(shape.stiffness), shape.share)


EFFECTS = (parallel_spring, elasticity, backlash)
