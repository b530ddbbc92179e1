"""A constant added to the measured current."""

import numpy as np

from ..catalogue.candidate import BESIDE_A_SENSOR, usual
from ..catalogue.sizes import torque
from .entry import Effect

USUAL_OFFSET_A, LARGEST_OFFSET_A = (0.02, 0.2), 0.5


def candidates(at):
    shape = "beside a sensor" if at.dataset.load_sensor else "constant"

    def prior(x):
        if at.dataset.at_motor:
            return usual(abs(x[0]) / at.dataset.tree[at.name]["torque_constant_Nm_A"], *USUAL_OFFSET_A)
        return BESIDE_A_SENSOR if at.dataset.load_sensor else 1.0

    # beside a spring with a preload an offset could be anything, and both together nearly nothing
    most = LARGEST_OFFSET_A * at.dataset.tree[at.name]["torque_constant_Nm_A"] if at.dataset.at_motor else np.inf
    yield at.of_law("current_offset", shape, [{"torque_Nm": 1.0}], low=(-most,), high=(most,), prior=prior)


def size(p):
    return f"the current shows {torque(abs(p['torque_Nm']))} too {'much' if p['torque_Nm'] > 0 else 'little'} at the motor"


EFFECT = Effect(
    id="current_offset",
    words="a constant error of the current",
    candidates=candidates,
    size=size,
    coordinates=("current", "velocity", "position"),
    needs="rest",
    in_offset=True,
)
