"""A torque constant that is wrong by a factor, which a torque sensor at the output shows."""

from ..catalogue import drive
from .entry import Effect

EFFECT = Effect(
    id="torque_constant",
    words="a torque constant that is not the given one",
    candidates=drive.torque_constant,
    needs="known mass",
    scales_drive=True,
)
