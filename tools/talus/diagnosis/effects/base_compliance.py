"""A mount that turns, sways or rises on a resonance of its own."""

from ..catalogue import leg
from .entry import Effect

EFFECT = Effect(
    id="base_compliance",
    words="a mount that sways",
    candidates=leg.base_compliance,
    coordinates=("frequency", "acceleration"),
    trajectory="fast_multisine",
    several=True,
)
