"""Friction that changes with time or temperature."""

from ..catalogue import friction
from .entry import Effect

EFFECT = Effect(
    id="friction_drift",
    words="friction that changes with time or temperature",
    candidates=friction.friction_drift,
    coordinates=("time",),
    needs="warmth",
)
