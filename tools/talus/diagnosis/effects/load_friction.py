"""Friction that grows with the torque that the gear carries."""

from ..catalogue import friction
from .entry import Effect

EFFECT = Effect(
    id="load_friction",
    words="friction that grows with the load",
    candidates=friction.load_friction,
    coordinates=("load", "current", "acceleration"),
    needs="known mass",
)
