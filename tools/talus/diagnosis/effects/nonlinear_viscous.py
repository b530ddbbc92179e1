"""Viscous friction that is not linear in speed."""

from ..catalogue import friction
from .entry import Effect

EFFECT = Effect(
    id="nonlinear_viscous",
    words="viscous friction that is not proportional to speed",
    candidates=friction.nonlinear_viscous,
    coordinates=("velocity",),
)
