"""Friction with memory: a spring over a small travel after each reversal (Dahl)."""

from ..catalogue import friction
from .entry import Effect

EFFECT = Effect(
    id="presliding",
    words="friction that acts like a spring before it slides",
    candidates=friction.presliding,
    coordinates=("reversal",),
)
