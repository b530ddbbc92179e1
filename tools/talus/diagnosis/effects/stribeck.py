"""Friction above Coulomb's near standstill."""

from ..catalogue import friction
from .entry import Effect

EFFECT = Effect(
    id="stribeck",
    words="friction that is higher near standstill",
    candidates=friction.stribeck,
    coordinates=("velocity", "reversal"),
)
