"""Transmission error of a harmonic drive, periodic in its wave generator's turn."""

from ..catalogue import drive
from .entry import Effect

EFFECT = Effect(
    id="kinematic_error",
    words="a transmission error that repeats with the motor's turn",
    candidates=drive.kinematic_error,
    coordinates=("motor_angle",),
    trajectory="fast_multisine",
    several=True,
)
