"""Effects between motor and link: springs, gaps, and what stands in parallel with the joint."""

import numpy as np

from .candidate import Family, named, usual

MOST_STEPS, LARGEST_STEP = 60, 1.0  # of a link for one sample; and beyond so many rad a stepped oscillation grows
STIFFNESSES_NM_RAD = (200, 400, 800, 1500, 3000, 6000, 12000)
GAPS_RAD = (0.0007, 0.0015, 0.003, 0.005, 0.008, 0.012)
TEETH_NM_RAD = 5000.0  # their stiffness on the grid: timing tells the gap, and hardly how hard it ends
MOTOR_SHARE = 0.15  # of the joint's own inertia that turns with its motor: a knee's rotor through its ratio
KNEE_MOTOR_SHARES = (0.15, 0.4)
# of dry and of viscous friction on the link's side: a motor's bearings and its seal are viscous on their own
SPRING_FRICTION = ((0, 0), (0.5, 0), (1, 0), (1, 1))
GAP_FRICTION = ((0, 0), (0.3, 0), (0.6, 0), (1, 0), (0.3, 0.3), (0.6, 0.6), (1, 1), (0, 1))
SPRING_DAMPING_RATIO = 0.1  # metal gears, and enough for the free motion to die out
SOFT_RAD = 0.002  # twist up to which a gear may be softer than beyond
HARDER_RAD = 0.005  # twist at which hardening is told against stiffness
# springs of other forms, from which that of a joint without an encoder behind its gear is looked for: a line alone, wrong in
# phase, may close nothing. As gears' data sheets have it: half as stiff up to a fifth of the largest load; or a cube that
# bears as much as the line at that load.
BENT_NM_RAD, BENT_DRY, BENT_MOTOR_SHARE = (400, 800, 1500, 3000), (0.0, 0.5), 0.3
SOFT_SHARE, SOFT_LOAD, CUBE_LOAD = 0.5, 0.2, 1.0
BOTH_FRICTIONS = (((2, 0.5), (3, -1.0)), ((2, 1.0), (3, 1.0)))  # dry for viscous at the speeds of a leg, and both
SOFTER = (((0, 1.0), (6, -1.0)), ((0, 1.0), (5, -0.5)))  # stiffer, but soft up to the same load; stiffer, but softer at first
TEETH_DAMPING_RATIO = 0.1
KNEE_TEETH_DAMPING_RATIO = 0.5  # its light rotor gives way, and the recorded motion is a wall that bounces more
# Of a leg's gears: what looks stiffer, or less lost, is the trace of something else in the smoothed acceleration
STIFFEST_NM_RAD, LEAST_GAP_RAD = 15000.0, 0.0005
STIFFER_SHARE = 0.05  # of a spring's twist: a stiffer one, that a first look may have had with other friction alone
BEGIN_SHARE = 0.15  # of an effect whose jolts come at the wrong time, from which the right shape may still be found
FASTEST_SWING = 4.0  # rad from sample to sample, of a link on a spring: a stiffer one follows at once
USUAL_SPRING_NM_RAD = (1.0, 15.0)
BUMPER_BEGINS = (0.0, 0.3, 0.6)  # of half the range


def parallel_spring(at):
    # a sensor at the output twists with its load: angle and torque then look like a spring
    if at.evidence.velocity_only or at.evidence.load_sensor or not at.travels:
        return
    j, middle, half = at.number, at.extent.middle[at.number], at.extent.half_range[at.number]
    names = ("preload_Nm", "stiffness_Nm_rad", "bend_Nm_rad2", "stiffening_Nm_rad3")

    def make(form, powers, low=None):
        return at.of_law("parallel_spring", form, [{names[p]: 1.0} for p in powers], low=low, prior=lambda x: likely(powers, x))

    def likely(powers, strengths):
        """By the mean stiffness over the range."""
        if not at.evidence.at_motor:
            return 1.0
        ends = [sum(x * q**p for p, x in zip(powers, strengths)) for q in (middle - half, middle + half)]
        return usual(abs(ends[1] - ends[0]) / (2 * half), *USUAL_SPRING_NM_RAD)

    yield make("line", (1,), (0.0,))
    yield make("cube", (3,), (0.0,))
    yield make("line and cube", (1, 3))
    yield make("polynomial", (1, 2, 3))
    yield make("polynomial and preload", (0, 1, 2, 3))
    if at.evidence.at_motor:
        yield make("line and preload", (1, 0))
    for side in (-1, 1):
        for begin in BUMPER_BEGINS:
            shapes = {"bumper_rad": float(middle + side * begin * half), "bumper_side": float(side)}
            yield at.of_law("parallel_spring", f"bumper at {side * begin:g}", [{"bumper_Nm_rad": 1.0}], shapes, low=(0.0,))


def _motor_shares(at):
    """An ankle's rotor is known."""
    return KNEE_MOTOR_SHARES if at.evidence.at_motor and at.number == 0 else (MOTOR_SHARE,)


def _hidden(at):
    """Where no link behind the motor can be told: without an angle, or with the load measured before the link; or so
    light a link that its oscillation cannot be stepped."""
    if at.evidence.velocity_only or at.evidence.load_sensor:
        return True
    fastest = at.scenes[0].link_rad_s(at.number, 0.0, max(STIFFNESSES_NM_RAD))
    return not all(scene.step_s * fastest < MOST_STEPS * LARGEST_STEP for scene in at.scenes)


def _shapes(at, stiffness, dry, viscous, motor, damping_ratio, **form):
    """The library's shapes of a spring or a gap: damping over stiffness from the link's damping ratio."""
    damping_s = 2 * damping_ratio / at.scenes[0].link_rad_s(at.number, motor, stiffness)
    return {"stiffness_Nm_rad": stiffness, "damping_s": damping_s, "friction_share": dry, "viscous_share": viscous,
            "motor_share": motor, **form}  # fmt: skip


def elasticity(at):
    if _hidden(at):
        return
    j = at.number
    begin_low = (STIFFER_SHARE,) if at.evidence.at_motor else None

    def soft(stiffness, dry, viscous, motor, damping=SPRING_DAMPING_RATIO, share=1.0, begin=SOFT_RAD, harder=0.0):
        hardening = float(harder * stiffness / HARDER_RAD**2)
        shapes = _shapes(at, stiffness, dry, viscous, motor, damping, soft_rad=begin, soft_share=share,
                         hardening_Nm_rad3=hardening)  # fmt: skip
        bent = {"soft_rad": begin, "soft_share": share} if share < 1.0 else {}
        bent |= {"hardening_Nm_rad3": hardening} if harder else {}
        figures = lambda x: {"compliance_rad_Nm": float(x[0]) / stiffness, **bent}
        family = Family(soft, (stiffness, dry, viscous, motor, damping, share, begin, harder),
                        (2.0, 0.3, 0.3, 0.2, 1.7, 0.5, 2.0, 0.4), (100.0, 0.0, 0.0, 0.02, 0.02, 0.1, 2e-4, 0.0),
                        (30000.0, 1.0, 1.0, 0.7, 1.0, 1.0, 0.02, 4.0), SOFTER,
                        start="cube" if harder else "soft" if share < 1.0 else "")  # fmt: skip
        return at.of_law("elasticity", f"{stiffness:g} Nm/rad{_sides(dry, viscous, motor)}", [{"share": 1.0}], shapes,
                         parameters=figures, low=(0.5,), high=(1.8,), family=family, begin_low=begin_low)  # fmt: skip

    fastest = FASTEST_SWING / max(scene.step_s for scene in at.scenes)
    stiffnesses = [k for k in STIFFNESSES_NM_RAD if at.scenes[0].link_rad_s(j, 0.0, k) <= fastest]
    for motor in _motor_shares(at):
        for dry, viscous in SPRING_FRICTION:
            for stiffness in stiffnesses or STIFFNESSES_NM_RAD[:1]:
                yield soft(float(stiffness), float(dry), float(viscous), motor)

    if at.evidence.at_motor and j == 0:
        yield from _bent(at, soft)

    # stiff: twist = load over stiffness, by the link's torque and, apart, by friction; the soft form takes no part
    shapes = {"stiffness_Nm_rad": 1000.0, "damping_s": 0.001}
    names = ("compliance_rad_Nm", "friction_compliance_rad_Nm")
    stiffest = 1 / STIFFEST_NM_RAD if at.evidence.at_motor else 0.0
    for form, count in (("stiff", 1), ("stiff, friction apart", 2)):
        own = names[:count]
        yield at.of_law("elasticity", form, [{name: 1.0} for name in own], shapes, parameters=named(*own),
                        low=(stiffest, 0.0)[:count], high=(0.01,) * count)  # fmt: skip


def _bent(at, soft):
    """Springs that are no line."""
    most = max(np.quantile(np.abs(scene.link_Nm[at.number][scene.track.inside]), 0.98) for scene in at.scenes)
    for stiffness in map(float, BENT_NM_RAD):
        twist = most / stiffness
        for dry in BENT_DRY:
            sides = (stiffness, dry, 0.0, BENT_MOTOR_SHARE, SPRING_DAMPING_RATIO)
            yield soft(*sides, share=SOFT_SHARE, begin=SOFT_LOAD * twist)
            yield soft(*sides, harder=CUBE_LOAD * (HARDER_RAD / twist) ** 2)


def backlash(at):
    if _hidden(at):
        return

    least = LEAST_GAP_RAD if at.evidence.at_motor else 0.0
    begin_low = (BEGIN_SHARE,) if at.evidence.at_motor and at.number == 0 else None  # no encoder tells its gap

    def lost(gap, stiffness, dry, viscous, motor, damping, drag=0.0):
        shapes = _shapes(at, stiffness, dry, viscous, motor, damping, gap_rad=gap, drag_Nm=drag * at.coulomb_Nm)
        figures = lambda x: {"gap_rad": float(x[0]) * gap, "stiffness_Nm_rad": stiffness}
        family = Family(lost, (gap, stiffness, dry, viscous, motor, damping, drag), (1.7, 3.0, 0.3, 0.3, 0.2, 1.7, 0.06),
                        (max(2e-4, least), 500.0, 0.0, 0.0, 0.02, 0.05, 0.0), (0.03, 50000.0, 1.0, 1.0, 0.7, 1.0, 0.3),
                        BOTH_FRICTIONS, rough=True)  # fmt: skip
        return at.of_law("backlash", f"{1e3 * gap:.2g} mrad, {stiffness:g} Nm/rad{_sides(dry, viscous, motor)}", [{"share": 1.0}],
                         shapes, parameters=figures, low=(max(0.4, least / gap),), high=(1.8,), family=family,
                         begin_low=begin_low)  # fmt: skip

    damping = KNEE_TEETH_DAMPING_RATIO if at.evidence.at_motor and at.number == 0 else TEETH_DAMPING_RATIO
    for motor in _motor_shares(at):
        for gap in GAPS_RAD:
            for dry, viscous in GAP_FRICTION:
                yield lost(gap, TEETH_NM_RAD, float(dry), float(viscous), motor, damping)


def _sides(dry, viscous, motor):
    """What of a joint stands on which side, in words."""
    return f", {dry:g} of dry and {viscous:g} of viscous friction at the link, rotor {motor:g}"
