"""The zero of the torque sensor at the output."""

from .entry import Effect


def candidates(at):
    if at.dataset.load_sensor:
        yield at.of_law("sensor_offset", "constant", [{"offset_Nm": 1.0}])


EFFECT = Effect(
    id="sensor_offset",
    words="a constant error of the torque sensor",
    candidates=candidates,
    in_offset=True,
    of_load_sensor=True,
)
