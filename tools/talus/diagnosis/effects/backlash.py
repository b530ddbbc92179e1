"""Lost motion between motor and joint."""

from ..catalogue import transmission
from .entry import Effect

EFFECT = Effect(
    id="backlash",
    words="play in the transmission",
    candidates=transmission.backlash,
    coordinates=("reversal", "load", "encoder"),
    trajectory="fast_multisine",
    integrated=True,
)
