"""What amplifier, supply and current sensor do to the torque beyond the catalogue's constant, droop, offset and delay."""

import numpy as np

from ..catalogue.candidate import Family
from .law import candidate, entry, of

EDGES = (0.05, 0.2)  # of the torque's RMS, within which a dead zone's edge is passed
EDGE_STEP, NARROWEST, WIDEST = 1.5, 0.01, 1.0


def power_loss(terms, joint):
    """Torque that is lost in proportion to the speed: the supply sags under load."""
    return (terms.joint_Nm[joint] * np.abs(terms.v[joint]))[None]


def gain_by_sign(terms, joint):
    """What a half bridge or sensor gives more in one direction."""
    return np.abs(terms.joint_Nm[joint])[None]


def dead_zone(terms, joint, share):
    """What a controller withholds on either side of 0."""
    torque = terms.joint_Nm[joint]
    edge = share * np.sqrt(np.mean(torque[terms.processed.inside] ** 2)) + 1e-12
    return np.tanh(torque / edge)[None]


def dead_zones(at):
    def one(share):
        family = Family(one, (share,), (EDGE_STEP,), (NARROWEST,), (WIDEST,))
        return candidate("dead_zone", at, dead_zone, family=family, share=share)

    yield from map(one, EDGES)


ENTRIES = [
    entry("power_loss", "a drive that loses torque at high power, as under a supply that sags", of("power_loss", power_loss),
          lambda p: f"{100 * abs(p['size_Nm']):.2g} % for each rad/s"),
    entry("gain_by_sign", "a drive or current sensor whose gain differs by sign", of("gain_by_sign", gain_by_sign),
          lambda p: f"{200 * abs(p['size_Nm']):.2g} % between the signs"),
    entry("dead_zone", "a drive with a dead zone about zero current", dead_zones, lambda p: f"{abs(p['size_Nm']):.2g} Nm"),
]  # fmt: skip
