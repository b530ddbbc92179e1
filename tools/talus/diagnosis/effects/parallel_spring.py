"""Elastic torque in parallel with the joint."""

from ..catalogue import transmission
from .entry import Effect

EFFECT = Effect(
    id="parallel_spring",
    words="a spring beside the joint",
    candidates=transmission.parallel_spring,
    coordinates=("position",),
    needs="turned base",
)
