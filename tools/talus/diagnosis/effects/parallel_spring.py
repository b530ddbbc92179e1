"""Elastic torque in parallel with the joint."""

import functools

from ..catalogue.candidate import Family, usual
from .entry import Effect

USUAL_SPRING_NM_RAD = (1.0, 15.0)
# of half the range, from its middle: where a bumper may be met, from which it is looked for between
BUMPER_BEGINS, BUMPER_STEP, BUMPER_FIRST, BUMPER_LAST = (-0.3, 0.0, 0.3, 0.6), 0.15, -0.8, 0.95

BENT = (("bend_Nm_rad2", 2.0, "q"), ("stiffening_Nm_rad3", 3.0, "q²"))  # the slope of each torque


def candidates(at):
    # a sensor at the output twists with its load: angle and torque then look like a spring
    if at.dataset.velocity_only or at.dataset.load_sensor or not at.travels:
        return
    j, middle, half = at.number, at.extent.middle[at.number], at.extent.half_range[at.number]
    names = ("preload_Nm", "stiffness_Nm_rad", "bend_Nm_rad2", "stiffening_Nm_rad3")

    def make(form, powers, low=None):
        return at.of_law("parallel_spring", form, [{names[p]: 1.0} for p in powers], low=low, prior=lambda x: likely(powers, x))

    def likely(powers, strengths):
        """By the mean stiffness over the range."""
        if not at.dataset.at_motor:
            return 1.0
        ends = [sum(x * q**p for p, x in zip(powers, strengths)) for q in (middle - half, middle + half)]
        return usual(abs(ends[1] - ends[0]) / (2 * half), *USUAL_SPRING_NM_RAD)

    yield make("line", (1,), (0.0,))
    yield make("cube", (3,), (0.0,))
    yield make("line and cube", (1, 3))
    yield make("polynomial", (1, 2, 3))
    yield make("polynomial and preload", (0, 1, 2, 3))
    if at.dataset.at_motor:
        yield make("line and preload", (1, 0))

    def bumper(side, begin):
        shapes = {"bumper_rad": float(middle + side * begin * half), "bumper_side": float(side)}
        family = Family(functools.partial(bumper, side), (begin,), (BUMPER_STEP,), (BUMPER_FIRST,), (BUMPER_LAST,), start=f"{side}")
        return at.of_law("parallel_spring", f"bumper at {side * begin:.3g}", [{"bumper_Nm_rad": 1.0}], shapes, low=(0.0,), family=family)

    for side in (-1, 1):
        for begin in BUMPER_BEGINS:
            yield bumper(side, begin)


def size(p):
    if p.get("bumper_Nm_rad"):
        return f"{p['bumper_Nm_rad']:.3g} Nm/rad beyond {p['bumper_rad']:.3g} rad"
    bent = [f"{p.get(name, 0.0) * power:+.3g} {of}" for name, power, of in BENT if p.get(name)]
    if not bent:
        return f"{p['stiffness_Nm_rad']:.3g} Nm/rad" if p.get("stiffness_Nm_rad") else ""
    line = [f"{p['stiffness_Nm_rad']:.3g}"] if p.get("stiffness_Nm_rad") else []
    return f"{' '.join([*line, *bent]).removeprefix('+').replace(' +', ' + ').replace(' -', ' - ')} Nm/rad at q rad"


def stiffness(p, q):
    """Of its straight and bent parts; a bumper's is never below 0."""
    return p.get("stiffness_Nm_rad", 0.0) + sum(p.get(name, 0.0) * power * q**order for order, (name, power, _) in enumerate(BENT, 1))


EFFECT = Effect(
    id="parallel_spring",
    words="a spring beside the joint",
    candidates=candidates,
    size=size,
    stiffness=stiffness,
    coordinates=("position",),
    needs="turned base",
)
