"""The zero of the torque sensor at the output."""

from ..catalogue import drive
from .entry import Effect

EFFECT = Effect(
    id="sensor_offset",
    words="a constant error of the torque sensor",
    candidates=drive.sensor_offset,
    in_offset=True,
    of_load_sensor=True,
)
