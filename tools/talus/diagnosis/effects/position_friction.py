"""Friction that depends on the joint's angle."""

import numpy as np

from ..catalogue.candidate import Family
from .entry import Effect

POSITION_WAVES = (0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.5, 3, 4, 5)  # half turns over half the range
POSITION_POWERS = ("slope_Nm_rad", "bend_Nm_rad2", "cubic_Nm_rad3", "quartic_Nm_rad4")


def candidates(at):
    if at.dataset.velocity_only or not at.travels:
        return
    j, middle, half = at.number, at.extent.middle[at.number], at.extent.half_range[at.number]
    about = {"middle_rad": float(middle)}
    ends = {**about, "range_rad": float(max(np.abs(s.q[j] - middle).max() for s in at.all_terms))}
    # about the middle in units of half the range
    powers = [{name: float(half**-p)} for p, name in enumerate(POSITION_POWERS, 1)]
    make = lambda form, columns, shapes=None: at.of_law("position_friction", form, columns, shapes)
    yield make("line", [{"slope_Nm_rad": 1.0}])
    yield make("parabola", [{"slope_Nm_rad": 1.0}, {"bend_Nm_rad2": 1.0}])
    yield make("parabola about the middle", powers[1:2], ends)
    yield make("polynomial", powers, ends)

    def wave(order):
        return at.of_law("position_friction", f"wave of {order:.3g} per rad", [{"sine_Nm": 1.0}, {"cosine_Nm": 1.0}],
                         {**about, "wave_1_rad": float(order)},
                         family=Family(wave, (order,), (1.15,), (1.0 / half,), (20.0 / half,)))  # fmt: skip

    for k in POSITION_WAVES:
        yield wave(np.pi * k / half)


EFFECT = Effect(
    id="position_friction",
    words="friction that depends on the position",
    candidates=candidates,
    coordinates=("position",),
)
