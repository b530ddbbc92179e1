"""Friction that differs between the two directions."""

from ..catalogue import friction
from .entry import Effect

EFFECT = Effect(
    id="asymmetric_friction",
    words="friction that differs between the two directions",
    candidates=friction.asymmetric_friction,
    coordinates=("velocity",),
    one_form=True,
)
