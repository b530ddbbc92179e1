"""Currents and angles that are sampled at different instants."""

from ..catalogue import drive
from .entry import Effect

EFFECT = Effect(
    id="delay",
    words="currents and angles taken at different instants",
    candidates=drive.delay,
    coordinates=("acceleration", "frequency", "reversal"),
    trajectory="fast_multisine",
)
