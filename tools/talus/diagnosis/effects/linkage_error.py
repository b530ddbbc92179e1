"""Dimensions of the ankle's linkage that are not the model's."""

from ..catalogue import leg
from .entry import Effect

EFFECT = Effect(
    id="linkage_error",
    words="a linkage whose dimensions are not the drawing's",
    candidates=leg.linkage_error,
    coordinates=("position", "encoder"),
    needs="camera",
)
