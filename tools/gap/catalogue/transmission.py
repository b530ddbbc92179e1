"""Effects between motor and link: springs, gaps, and what stands in parallel with the joint."""

import numpy as np

from ..loops import LARGEST_STEP, MOST_STEPS, LinkShape, link_behind
from .candidate import Candidate, differentiate_twice, link_displaced, named

STIFFNESSES_NM_RAD = (200, 400, 800, 1500, 3000, 6000, 12000)
GAPS_RAD = (0.0007, 0.0015, 0.003, 0.005, 0.008, 0.012)
BACKLASH_STIFFNESSES_NM_RAD = (12000, 3000)
FRICTION_SHARES = (1, 0.6, 0.3, 0)  # of the friction that stands on the link's side
BUMPER_BEGINS = (0.0, 0.3, 0.6)  # of half the range


def parallel_spring(at):
    if at.evidence.velocity_only:
        return
    j, middle, half = at.number, at.extent.middle[at.number], at.extent.half_range[at.number]
    power = [at.joint_column(lambda s, p=p: s.q[j] ** p) for p in range(4)]
    names = ("preload_Nm", "stiffness_Nm_rad", "bend_Nm_rad2", "stiffening_Nm_rad3")

    def make(shape, powers, low=None, saved=True, preload=True):
        figures = named(*(names[p] for p in powers))
        zero = {names[p]: 0.0 for p in (0, 1, 3)} if saved else {}
        return Candidate("parallel_spring", at.name, shape, tuple(power[p] for p in powers),
                         lambda x: {**zero, **figures(x)}, low, saved=saved)  # fmt: skip

    yield make("line", (1,), (0.0,))
    yield make("cube", (3,), (0.0,))
    yield make("line and cube", (1, 3))
    yield make("polynomial", (1, 2, 3), saved=False)
    yield make("polynomial and preload", (0, 1, 2, 3), saved=False)
    if at.evidence.leg:
        yield make("line and preload", (1, 0))
    for side in (-1, 1):
        for begin in BUMPER_BEGINS:
            law = lambda s, d=side, b=begin: d * np.maximum(d * (s.q[j] - middle) - b * half, 0.0)
            yield Candidate("parallel_spring", at.name, f"bumper at {side * begin:g}", (at.joint_column(law),),
                            named("stiffness_Nm_rad", begin_rad=float(middle + side * begin * half)), (0.0,))  # fmt: skip


def _shapes():
    springs = [LinkShape(k, 0.0, share) for share in FRICTION_SHARES for k in STIFFNESSES_NM_RAD]
    gaps = [LinkShape(k, gap / 2, share) for share in FRICTION_SHARES for k in BACKLASH_STIFFNESSES_NM_RAD
            for gap in GAPS_RAD]  # fmt: skip
    return springs, gaps


def _answer(scene, j, shape):
    """Angle and spring torque of a link behind `shape`."""
    inertia = scene.link_inertia[j]
    other = scene.once(("other", j), lambda: scene.track.resample(scene.link_Nm[j] - inertia * scene.a[j]))
    return link_behind(shape, scene.step_s, scene.grid("v", j), other, inertia, scene.coulomb_Nm[j], scene.viscous[j])


def _behind(j, shape):
    """What shows of a link behind `shape`, at the whole effect's strength."""

    def column(scene):
        track, (angle, torque) = scene.track, _answer(scene, j, shape)
        rigid = scene.once(("rigid", j, shape.share), lambda: track.resample(
            track.bridge(scene.link_Nm[j] + shape.share * scene.friction_Nm[j], j)))
        shown = {f"T{j}": track.lowpass((torque - rigid) / scene.grid("ratio", j))}
        if scene.evidence.leg:
            for kind in ("E", "F") if j == 1 else ("K",):
                if kind in scene.evidence.kinds:
                    shown[kind] = track.lowpass(angle)
            coupled = scene.once("coupling", lambda: track.resample(scene.inertia[0][1]))
            other = coupled * differentiate_twice(angle, scene.step_s) / scene.grid("ratio", 1 - j)
            shown[f"T{1 - j}"] = track.lowpass(other)
        return shown

    return column


def _hidden(at):
    """Where no link behind the motor can be told: without an angle, or with the load measured before the link; or so
    light a link that its oscillation cannot be stepped."""
    fastest = np.sqrt(max(STIFFNESSES_NM_RAD) / at.scenes[0].link_inertia[at.number])
    slow = all(scene.step_s * fastest < MOST_STEPS * LARGEST_STEP for scene in at.scenes)
    return at.evidence.velocity_only or at.evidence.load_sensor or not slow


def elasticity(at):
    if _hidden(at):
        return
    j = at.number
    for shape in _shapes()[0]:
        figures = lambda x, k=shape.stiffness: {"compliance_rad_Nm": float(x[0]) / k, "damping_s": 0.0}
        yield Candidate("elasticity", at.name, f"{shape.stiffness} Nm/rad, {shape.share:g} of friction at the link",
                        (_behind(j, shape),), figures, (0.5,), (1.8,), saved=True)  # fmt: skip

    # stiff: twist = load over stiffness, by the link's torque and, apart, by friction
    def twist(scene, torque):
        track = scene.track
        return link_displaced(scene, j, -track.lowpass(track.resample(track.bridge(torque, j))))

    link, friction = lambda s: twist(s, s.link_Nm[j]), lambda s: twist(s, s.friction_Nm[j])
    yield Candidate("elasticity", at.name, "stiff", (link,), named("compliance_rad_Nm", damping_s=0.0), (0.0,), (0.01,),
                    saved=True)  # fmt: skip
    yield Candidate("elasticity", at.name, "stiff, friction apart", (link, friction),
                    named("compliance_rad_Nm", "friction_compliance_rad_Nm"), (0.0, 0.0), (0.01, 0.01))  # fmt: skip


def backlash(at):
    if _hidden(at):
        return
    for shape in _shapes()[1]:
        gap, k = 2 * shape.half, float(shape.stiffness)
        figures = lambda x, gap=gap, k=k: {"gap_rad": float(x[0]) * gap, "stiffness_Nm_rad": k}
        yield Candidate("backlash", at.name, f"{1e3 * gap:.2g} mrad, {k:g} Nm/rad, {shape.share:g} of friction at the link",
                        (_behind(at.number, shape),), figures, (0.4,), (1.8,), saved=True)  # fmt: skip


EFFECTS = (parallel_spring, elasticity, backlash)
