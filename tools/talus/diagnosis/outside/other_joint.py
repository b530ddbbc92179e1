"""Torques of one joint that follow the other joint: a cable or a muscle over both, a disturbed current sensor."""

from dataclasses import dataclass

import numpy as np

from ..calibration.replicates import replicable
from ..catalogue.candidate import Candidate, named
from ..effects.entry import Effect
from .law import entry, of

OWN_SHARES = (0.0, 1.0, -1.0)  # of the joint's own angle, beside the other's


def angles(terms, joint, own):
    """A spring that is stretched by both joints' angles."""
    return (terms.q[1 - joint] + own * terms.q[joint])[None]


def speed(terms, joint):
    return terms.v[1 - joint][None]


def product_of_speeds(terms, joint):
    return (terms.v[0] * terms.v[1])[None]


def torque(terms, joint):
    """What the current's sensor shows of the other drive."""
    return terms.joint_Nm[1 - joint][None]


def friction(terms, joint):
    """Friction that varies with the other joint's angle: linearly, and with its square."""
    q = terms.q[1 - joint]
    return terms.slip[joint] * np.array([q, q * q])


def beside_another(name, law, shapes=({},), strengths=("size",)):
    every = of(name, law, shapes, strengths)
    return lambda at: every(at) if at.dataset.joints > 1 else []


@dataclass(frozen=True)
class Shared:
    """Torques of one term of the energy that both joints' angles share: their product, times a joint's angle or not."""

    further: int | None = None

    def __call__(self, terms):
        """{channel: column on the grid} of one recording."""
        first, second = terms.q[0], terms.q[1]
        slope = {None: (second, first), 0: (2.0 * first * second, first**2), 1: (second**2, 2.0 * first * second)}[self.further]
        return {f"T{joint}": terms.operated(slope[joint][None], joint)[0] for joint in range(2)}


def shared_energy(at):
    """A cable over both joints: what it does to one follows from what it does to the other, for both come from one energy."""
    if at.number == 1 and replicable(at.dataset):
        strengths = named("product_Nm_rad", "first_Nm_rad2", "second_Nm_rad2")
        yield Candidate("shared_energy", at.name, "its one form", tuple(Shared(x) for x in (None, 0, 1)), strengths)


ENTRIES = [
    Effect(id="shared_energy", words="a spring that the other joint stretches too, as of a cable over both", candidates=shared_energy, outside=True,
           size=lambda p: f"{abs(p['product_Nm_rad']):.2g} Nm/rad"),
    entry("coupled_angles", "a torque that goes with the other joint's angle, as of a cable over both",
          beside_another("coupled_angles", angles, [{"own": x} for x in OWN_SHARES]), lambda p: f"{abs(p['size']):.2g} Nm/rad"),
    entry("coupled_speeds", "a torque that goes with the other joint's speed", beside_another("coupled_speeds", speed),
          lambda p: f"{abs(p['size']):.2g} Nms/rad"),
    entry("product_of_speeds", "a torque that goes with the product of both joints' speeds",
          beside_another("product_of_speeds", product_of_speeds), lambda p: f"{abs(p['size']):.2g} Nms²/rad²"),
    entry("cross_talk", "a current reading that shows the other joint's", beside_another("cross_talk", torque),
          lambda p: f"{100 * abs(p['size']):.2g} % of the torque there"),
    entry("coupled_friction", "friction that goes with the other joint's angle",
          beside_another("coupled_friction", friction, strengths=("linear_Nm_rad", "square_Nm_rad2"))),
]  # fmt: skip
