"""A torque constant that droops at high current."""

from ..catalogue import drive
from .entry import Effect

EFFECT = Effect(
    id="torque_saturation",
    words="a torque constant that droops at high current",
    candidates=drive.torque_saturation,
    coordinates=("current", "load"),
    needs="known mass",
)
