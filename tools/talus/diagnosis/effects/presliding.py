"""Friction with memory: a spring over a small travel after each reversal (Dahl)."""

from ..catalogue.candidate import Family
from ..catalogue.sizes import angle
from .entry import Effect

PRESLIDING_TRAVELS_RAD = (0.0007, 0.0015, 0.003, 0.006, 0.012, 0.024)


def candidates(at):
    friction_Nm = at.usual_coulomb_Nm
    scale = 0.1 if at.is_straight else 1.0  # a travel in m
    travels = [scale * x for x in PRESLIDING_TRAVELS_RAD]
    shapes = [(travel, power) for power in (1.0, 2.0) for travel in travels]

    def dahls(travel, power):
        return at.of_law("presliding", f"Dahl, power {power:g}, {1e3 * travel:.2g} mrad", [{"friction_Nm": friction_Nm}],
                         {"travel_rad": float(travel), "power": power}, low=(0.2,), high=(1.5,),
                         family=Family(dahls, (travel, power), (1.7, 0.5), (travels[0] / 2, 1.0), (2 * travels[-1], 2.0)))  # fmt: skip

    for travel, power in shapes:
        yield dahls(travel, power)


def size(p):
    return f"yields by about {angle(p['travel_rad'])} after each reversal before it slides"


EFFECT = Effect(
    id="presliding",
    words="friction that acts like a spring before it slides",
    candidates=candidates,
    size=size,
    coordinates=("reversal",),
)
