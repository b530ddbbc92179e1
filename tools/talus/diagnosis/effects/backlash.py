"""Lost motion between motor and joint."""

import itertools

from ..catalogue.candidate import Family
from ..catalogue.flexible_joint import MOTOR_SHARES, is_out_of_sight, link_shapes, motor_shares, sides_in_words, stiffness_at
from ..catalogue.sizes import angle
from .entry import Effect

GAPS_RAD = (0.0007, 0.0015, 0.003, 0.005, 0.008, 0.012)
GAP_FRICTION = ((0, 0), (0.3, 0), (0.6, 0), (1, 0), (0.3, 0.3), (0.6, 0.6), (1, 1), (0, 1))
STEPS = (1.7, 3.0, 0.3, 0.3, 0.2, 1.7, 0.06, 0.3)  # gap, stiffness, dry, viscous, motor, damping, drag, constant torque
BOTH_FRICTIONS = (((2, 0.5), (3, -1.0)), ((2, 1.0), (3, 1.0)))  # dry for viscous at the speeds of a leg, and both
# teeth on the grid: timing tells the gap, and hardly how hard it ends
TEETH_NM_RAD, TEETH_HZ = 5000.0, 25.0  # of a leg; of a single joint, at which its own inertia swings on them
TEETH_DAMPING_RATIO = 0.1
LIGHT_DAMPING_RATIO = 0.5  # a light rotor gives way, and the recorded motion is a wall that bounces more
SOFTER_SHARE, STIFFER_SHARE = 0.1, 10.0  # of their stiffness: the softest and the stiffest that are looked for
# teeth: jolts against stiff ones are short, and miss those of a gap nearby
SOFTER = ((1.0, SOFTER_SHARE, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0),)
LEAST_OFFSET = 0.01  # of its dry friction: a constant torque that tells on which side it acts
# of a leg's gears: what looks smaller is the trace of something else in the smoothed acceleration
LEAST_GAP_RAD = 0.0005
BEGIN_SHARE = 0.15  # of an effect whose jolts come at the wrong time, from which the right shape may still be found


def candidates(at):
    if is_out_of_sight(at):
        return

    teeth = TEETH_NM_RAD if at.dataset.at_motor else stiffness_at(at, TEETH_HZ)
    motors, constants = motor_shares(at) if at.dataset.at_motor else MOTOR_SHARES, constant_shares(at)
    encoder = at.dataset.at_motor and at.number == 1  # it tells an ankle's gap
    least = LEAST_GAP_RAD if at.dataset.at_motor else 0.0
    lowest = (max(2e-4, least), SOFTER_SHARE * teeth, 0.0, 0.0, 0.02, 0.05, 0.0, 0.0)
    highest = (0.03, STIFFER_SHARE * teeth, 1.0, 1.0, 0.7, 1.0, 0.3, constants[-1])

    def lost(*values):
        gap, stiffness, dry, viscous, motor, damping, drag, constant = values
        shapes = link_shapes(at, stiffness, dry, viscous, motor, damping, gap_rad=gap, drag_Nm=drag * at.coulomb_Nm, offset_share=constant)
        figures = lambda x: {"gap_rad": float(x[0]) * gap, "stiffness_Nm_rad": stiffness}
        family = Family(lost, values, STEPS, lowest, highest, BOTH_FRICTIONS, rough=True, elsewhere=SOFTER)
        form = f"{1e3 * gap:.2g} mrad, {stiffness:g} Nm/rad{sides_in_words(dry, viscous, motor)}"
        return at.of_law("backlash", form, [{"share": 1.0}], shapes, parameters=figures, low=(max(0.4, least / gap),), high=(1.8,),
                         family=family, begin_low=None if encoder else (BEGIN_SHARE,))  # fmt: skip

    damping = TEETH_DAMPING_RATIO if encoder else LIGHT_DAMPING_RATIO
    for motor, constant, gap, (dry, viscous) in itertools.product(motors, constants, GAPS_RAD, GAP_FRICTION):
        yield lost(gap, teeth, float(dry), float(viscous), motor, damping, 0.0, constant)


def constant_shares(at):
    """Of the joint's constant torque, what acts on the link: none of a current's zero, all of a weight. It holds the link to one face."""
    return (0.0, 1.0) if abs(at.offset_Nm) > LEAST_OFFSET * at.coulomb_Nm else (0.0,)


def size(p):
    return f"{angle(p['gap_rad'])} from one side of the play to the other"


EFFECT = Effect(
    id="backlash",
    words="play in the transmission",
    candidates=candidates,
    size=size,
    coordinates=("reversal", "load", "encoder"),
    trajectory="fast_multisine",
    integrated=True,
)
