"""Torsional compliance between motor and joint."""

import numpy as np

from ..catalogue.candidate import Family, named
from ..catalogue.flexible_joint import is_out_of_sight, link_shapes, motor_shares, sides_in_words, stiffnesses
from .entry import Effect

# of dry and of viscous friction on the link's side: a motor's bearings and its seal are viscous on their own
SPRING_FRICTION = ((0, 0), (0.5, 0), (1, 0), (1, 1))
SPRING_DAMPING_RATIO = 0.1  # metal gears, and enough for the free motion to die out
SOFT_RAD = 0.002  # twist up to which a gear may be softer than beyond
HARDER_RAD = 0.005  # twist at which hardening is told against stiffness
# springs of other forms, from which that of a joint without an encoder behind its gear is looked for: a line alone, wrong in
# phase, may close nothing. As gears' data sheets have it: half as stiff up to a fifth of the largest load; or a cube that
# bears as much as the line at that load.
BENT_NM_RAD, BENT_DRY, BENT_MOTOR_SHARE = (400, 800, 1500, 3000), (0.0, 0.5), 0.3
SOFT_SHARE, SOFT_LOAD, CUBE_LOAD = 0.5, 0.2, 1.0
SOFTER = (((0, 1.0), (6, -1.0)), ((0, 1.0), (5, -0.5)))  # stiffer, but soft up to the same load; stiffer, but softer at first
# of a leg's gears: what looks stiffer is the trace of something else in the smoothed acceleration
STIFFEST_NM_RAD = 15000.0
STIFFER_SHARE = 0.05  # of a spring's twist: a stiffer one, that a first look may have had with other friction alone
FASTEST_SWING = 4.0  # rad from sample to sample, of a link on a spring: a stiffer one follows at once


def candidates(at):
    if is_out_of_sight(at):
        return
    j = at.number
    grid, (softest, stiffest) = stiffnesses(at)
    begin_low = (STIFFER_SHARE,)
    stiffest = min(stiffest, STIFFEST_NM_RAD) if at.dataset.at_motor else stiffest

    def soft(stiffness, dry, viscous, motor, damping=SPRING_DAMPING_RATIO, share=1.0, begin=SOFT_RAD, harder=0.0):
        hardening = float(harder * stiffness / HARDER_RAD**2)
        shapes = link_shapes(at, stiffness, dry, viscous, motor, damping, soft_rad=begin, soft_share=share,
                         hardening_Nm_rad3=hardening)  # fmt: skip
        bent = {"soft_rad": begin, "soft_share": share} if share < 1.0 else {}
        bent |= {"hardening_Nm_rad3": hardening} if harder else {}
        figures = lambda x: {"compliance_rad_Nm": float(x[0]) / stiffness, **bent}
        family = Family(soft, (stiffness, dry, viscous, motor, damping, share, begin, harder),
                        (2.0, 0.3, 0.3, 0.2, 1.7, 0.5, 2.0, 0.4), (softest, 0.0, 0.0, 0.02, 0.02, 0.1, 2e-4, 0.0),
                        (stiffest, 1.0, 1.0, 0.7, 1.0, 1.0, 0.02, 4.0), SOFTER,
                        start="cube" if harder else "soft" if share < 1.0 else "")  # fmt: skip
        return at.of_law("elasticity", f"{stiffness:g} Nm/rad{sides_in_words(dry, viscous, motor)}", [{"share": 1.0}], shapes,
                         parameters=figures, low=(max(0.5, stiffness / stiffest),), high=(1.8,), family=family, begin_low=begin_low)  # fmt: skip

    fastest = FASTEST_SWING / max(terms.step_s for terms in at.all_terms)
    slow = [k for k in grid if at.all_terms[0].link_rad_s(j, 0.0, k) <= fastest]
    for motor in motor_shares(at):
        for dry, viscous in SPRING_FRICTION:
            for stiffness in slow or grid[:1]:
                yield soft(float(stiffness), float(dry), float(viscous), motor)

    if at.dataset.at_motor and j == 0:
        yield from _bent(at, soft)

    # stiff: twist = load over stiffness, by the link's torque and, apart, by friction; the soft form takes no part
    shapes = {"stiffness_Nm_rad": 1000.0, "damping_s": 0.001}
    names = ("compliance_rad_Nm", "friction_compliance_rad_Nm")
    least = 1 / STIFFEST_NM_RAD if at.dataset.at_motor else 0.0
    for form, count in (("stiff", 1), ("stiff, friction apart", 2)):
        own = names[:count]
        yield at.of_law("elasticity", form, [{name: 1.0} for name in own], shapes, parameters=named(*own),
                        low=(least, 0.0)[:count], high=(0.01,) * count)  # fmt: skip


def _bent(at, soft):
    """Springs that are no line."""
    most = max(np.quantile(np.abs(terms.link_Nm[at.number][terms.processed.inside]), 0.98) for terms in at.all_terms)
    for stiffness in map(float, BENT_NM_RAD):
        twist = most / stiffness
        for dry in BENT_DRY:
            sides = (stiffness, dry, 0.0, BENT_MOTOR_SHARE, SPRING_DAMPING_RATIO)
            yield soft(*sides, share=SOFT_SHARE, begin=SOFT_LOAD * twist)
            yield soft(*sides, harder=CUBE_LOAD * (HARDER_RAD / twist) ** 2)


def size(p):
    if not p["compliance_rad_Nm"]:
        return ""
    return f"twists by {1e3 * p['compliance_rad_Nm']:.3g} mrad for 1 Nm ({1 / p['compliance_rad_Nm']:.3g} Nm/rad)"


EFFECT = Effect(
    id="elasticity",
    words="a transmission that gives way like a spring",
    candidates=candidates,
    size=size,
    coordinates=("load", "acceleration", "frequency", "encoder"),
    trajectory="fast_multisine",
    integrated=True,
)
