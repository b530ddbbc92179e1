"""Friction above Coulomb's near standstill."""

from ..catalogue.candidate import Family
from ..catalogue.sizes import torque
from .entry import Effect

STRIBECK_SPEEDS_RAD_S = (0.02, 0.04, 0.07, 0.12, 0.2, 0.3, 0.45)


def _usual_and_faster(widest):
    """A joint without a gear, or with a low one, is faster than those that the usual speeds come from."""
    yield from STRIBECK_SPEEDS_RAD_S
    faster = STRIBECK_SPEEDS_RAD_S[-1]
    while (faster := 1.5 * faster) <= widest:
        yield faster


def candidates(at):
    j, speed = at.number, at.extent.speed[at.number]
    widest = 0.25 * speed  # wider is viscous friction under another name
    speeds = [x * speed for x in (0.02, 0.05, 0.1)] if at.is_straight else [x for x in _usual_and_faster(widest) if x <= widest]

    def falling(width, power):
        return at.of_law("stribeck", f"power {power:g}, {width:.3g} rad/s", [{"extra_Nm": 1.0}],
                         {"speed_rad_s": float(width), "exponent": power}, low=(0.02 * at.coulomb_Nm,),
                         high=(1.5 * at.usual_coulomb_Nm,), family=Family(falling, (width, power), (1.5, 0.5),
                         (speeds[0] / 2, 0.5), (widest, 2.0)))  # fmt: skip

    for power in (1.0, 2.0):
        for width in speeds:
            yield falling(width, power)


def size(p):
    return f"{torque(p['extra_Nm'])} more at standstill, a third of that at {p['speed_rad_s']:.3g} rad/s"


EFFECT = Effect(
    id="stribeck",
    words="friction that is higher near standstill",
    candidates=candidates,
    size=size,
    coordinates=("velocity", "reversal"),
)
