"""Torques of one joint that follow the other joint: a cable or a muscle over both, a disturbed current sensor."""

import numpy as np

from .law import candidate, entry

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


def of(name, law, shapes=({},), strengths=("size",)):
    def candidates(at):
        if at.dataset.joints > 1:
            yield from (candidate(name, at, law, strengths, **shape) for shape in shapes)

    return candidates


ENTRIES = [
    entry("coupled_angles", "a torque that goes with the other joint's angle, as of a cable over both",
          of("coupled_angles", angles, [{"own": x} for x in OWN_SHARES])),
    entry("coupled_speeds", "a torque that goes with the other joint's speed", of("coupled_speeds", speed)),
    entry("product_of_speeds", "a torque that goes with the product of both joints' speeds", of("product_of_speeds", product_of_speeds)),
    entry("cross_talk", "a current reading that shows the other joint's", of("cross_talk", torque)),
    entry("coupled_friction", "friction that goes with the other joint's angle",
          of("coupled_friction", friction, strengths=("linear_Nm_rad", "square_Nm_rad2"))),
]  # fmt: skip
