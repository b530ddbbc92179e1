"""An encoder's error that is periodic in the turn of the joint or of the motor."""

from ..catalogue.candidate import Candidate, named
from ..catalogue.law import column
from ..catalogue.sizes import amplitude, angle
from .entry import Effect

JOINT_ENCODER_ORDERS = (*range(1, 33), 36, 40, 48, 64)


def candidates(at):
    def waves(sensor, order):
        names = f"{sensor}_sine_rad", f"{sensor}_cosine_rad"
        shapes = {f"{sensor}_per_turn": float(order)}
        columns = tuple(column("encoder_eccentricity", (at.number,), {name: 1.0}, shapes) for name in names)
        return Candidate("encoder_eccentricity", at.name, f"{sensor} encoder, {order} per turn", columns, named(*names, **shapes))

    if "E" in at.dataset.kinds:
        yield from (waves("joint", order) for order in JOINT_ENCODER_ORDERS)
    yield from (waves("motor", order) for order in (1, 2))


def size(p):
    sensor = "joint" if "joint_per_turn" in p else "motor"
    error = amplitude(p, f"{sensor}_sine_rad", f"{sensor}_cosine_rad")
    return f"the {sensor}'s encoder is off by up to {angle(error)}, {p[f'{sensor}_per_turn']:.3g} times a turn"


EFFECT = Effect(
    id="encoder_eccentricity",
    words="an encoder that is mounted off its centre",
    candidates=candidates,
    size=size,
    coordinates=("encoder", "position", "motor_angle"),
    needs="camera",
)
