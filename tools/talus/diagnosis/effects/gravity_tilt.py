"""A bench, or its encoders' zero, that is tilted against gravity."""

from ..catalogue import leg
from .entry import Effect

EFFECT = Effect(
    id="gravity_tilt",
    words="a bench that is not upright",
    candidates=leg.gravity_tilt,
    coordinates=("position",),
    needs="turned base",
    one_form=True,
)
