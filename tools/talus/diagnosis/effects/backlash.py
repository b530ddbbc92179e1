"""Lost motion between motor and joint."""

from ..catalogue.candidate import Family
from ..catalogue.flexible_joint import TEETH_HZ, is_out_of_sight, link_shapes, motor_shares, sides_in_words, stiffness_at
from ..catalogue.sizes import angle
from .entry import Effect

GAPS_RAD = (0.0007, 0.0015, 0.003, 0.005, 0.008, 0.012)
TEETH_NM_RAD = 5000.0  # their stiffness on the grid: timing tells the gap, and hardly how hard it ends
GAP_FRICTION = ((0, 0), (0.3, 0), (0.6, 0), (1, 0), (0.3, 0.3), (0.6, 0.6), (1, 1), (0, 1))
BOTH_FRICTIONS = (((2, 0.5), (3, -1.0)), ((2, 1.0), (3, 1.0)))  # dry for viscous at the speeds of a leg, and both
TEETH_DAMPING_RATIO = 0.1
KNEE_TEETH_DAMPING_RATIO = 0.5  # its light rotor gives way, and the recorded motion is a wall that bounces more
SOFTER = ((1.0, 0.1, 1.0, 1.0, 1.0, 1.0, 1.0),)  # teeth: jolts against stiff ones are short, and miss those of a gap nearby
# of a leg's gears: what looks smaller is the trace of something else in the smoothed acceleration
LEAST_GAP_RAD = 0.0005
BEGIN_SHARE = 0.15  # of an effect whose jolts come at the wrong time, from which the right shape may still be found


def candidates(at):
    if is_out_of_sight(at):
        return

    teeth = TEETH_NM_RAD if at.dataset.at_motor else stiffness_at(at, TEETH_HZ)
    least = LEAST_GAP_RAD if at.dataset.at_motor else 0.0
    begin_low = None if at.dataset.at_motor and at.number == 1 else (BEGIN_SHARE,)  # an encoder tells an ankle's gap

    def lost(gap, stiffness, dry, viscous, motor, damping, drag=0.0):
        shapes = link_shapes(at, stiffness, dry, viscous, motor, damping, gap_rad=gap, drag_Nm=drag * at.coulomb_Nm)
        figures = lambda x: {"gap_rad": float(x[0]) * gap, "stiffness_Nm_rad": stiffness}
        family = Family(lost, (gap, stiffness, dry, viscous, motor, damping, drag), (1.7, 3.0, 0.3, 0.3, 0.2, 1.7, 0.06),
                        (max(2e-4, least), 0.1 * teeth, 0.0, 0.0, 0.02, 0.05, 0.0), (0.03, 10 * teeth, 1.0, 1.0, 0.7, 1.0, 0.3),
                        BOTH_FRICTIONS, rough=True, elsewhere=SOFTER)  # fmt: skip
        return at.of_law("backlash", f"{1e3 * gap:.2g} mrad, {stiffness:g} Nm/rad{sides_in_words(dry, viscous, motor)}", [{"share": 1.0}],
                         shapes, parameters=figures, low=(max(0.4, least / gap),), high=(1.8,), family=family,
                         begin_low=begin_low)  # fmt: skip

    damping = KNEE_TEETH_DAMPING_RATIO if at.dataset.at_motor and at.number == 0 else TEETH_DAMPING_RATIO
    for motor in motor_shares(at):
        for gap in GAPS_RAD:
            for dry, viscous in GAP_FRICTION:
                yield lost(gap, teeth, float(dry), float(viscous), motor, damping)


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
