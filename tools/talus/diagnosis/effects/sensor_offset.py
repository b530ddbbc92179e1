"""The zero of the torque sensor at the output."""

from ..catalogue.sizes import torque
from .entry import Effect


def candidates(at):
    if at.dataset.load_sensor:
        yield at.of_law("sensor_offset", "constant", [{"offset_Nm": 1.0}])


def size(p):
    return f"the sensor shows {torque(abs(p['offset_Nm']))} too {'much' if p['offset_Nm'] > 0 else 'little'}"


EFFECT = Effect(
    id="sensor_offset",
    words="a constant error of the torque sensor",
    candidates=candidates,
    size=size,
    in_offset=True,
    of_load_sensor=True,
)
