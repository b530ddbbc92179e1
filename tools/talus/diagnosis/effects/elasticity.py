"""Torsional compliance between motor and joint."""

from ..catalogue import transmission
from .entry import Effect

EFFECT = Effect(
    id="elasticity",
    words="a transmission that gives way like a spring",
    candidates=transmission.elasticity,
    coordinates=("load", "acceleration", "frequency", "encoder"),
    trajectory="fast_multisine",
    integrated=True,
)
