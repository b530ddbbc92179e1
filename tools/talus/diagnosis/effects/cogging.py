"""Motor torque that is periodic in the motor's angle, whatever the current."""

from ..catalogue import drive
from .entry import Effect

EFFECT = Effect(
    id="cogging",
    words="a motor torque that repeats with the turn, without current",
    candidates=drive.cogging,
    coordinates=("motor_angle",),
    trajectory="fast_multisine",
    several=True,
)
