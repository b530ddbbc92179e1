"""A gear's losses in proportion to power, which differ between driving and back-driving."""

from ..catalogue import friction
from .entry import Effect

EFFECT = Effect(
    id="directional_efficiency",
    words="losses that differ between driving and being driven",
    candidates=friction.directional_efficiency,
    coordinates=("load", "current"),
    needs="known mass",
)
