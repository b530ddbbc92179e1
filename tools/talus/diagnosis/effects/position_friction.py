"""Friction that depends on the joint's angle."""

from ..catalogue import friction
from .entry import Effect

EFFECT = Effect(
    id="position_friction",
    words="friction that depends on the position",
    candidates=friction.position_friction,
    coordinates=("position",),
)
