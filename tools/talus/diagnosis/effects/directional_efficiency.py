"""A gear's losses in proportion to power, which differ between driving and back-driving."""

from ..catalogue.carried_load import carried_loads
from ..catalogue.sizes import percent
from .entry import Effect


def candidates(at):
    if not at.carries_both_ways:
        return
    for name, shares in carried_loads(at):
        yield at.of_law("directional_efficiency", name, [{"driving": 1.0}, {"back_driving": 1.0}], shares, low=(0.0, 0.0),
                        high=(0.6, 0.6))  # fmt: skip


def size(p):
    return f"loses {percent(p['driving'])} of the load when driving, {percent(p['back_driving'])} when driven"


EFFECT = Effect(
    id="directional_efficiency",
    words="losses that differ between driving and being driven",
    candidates=candidates,
    size=size,
    coordinates=("load", "current"),
    needs="known mass",
)
