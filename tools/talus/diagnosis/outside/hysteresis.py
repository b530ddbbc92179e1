"""A hose, a cable or a seal: a force that follows the motion like a spring, slips when it is stretched far enough, and comes back
another way."""

import numpy as np

from ..catalogue.candidate import Family
from .law import candidate, entry

TRAVELS = (0.15, 0.3, 0.5, 0.75, 1.0)  # of half the range, before it slips: less is friction that builds up
STEP, LEAST, MOST = 1.3, 0.1, 1.5


def deflection(q, travel):
    """Of a spring behind the motion q that slips at `travel` on either side (play operator); 0 at the begin. Between two turning points
    the motion goes one way, and the deflection with it, up to the limit."""
    way = np.sign(np.diff(q))
    way = way[way != 0]
    moving = np.flatnonzero(np.diff(q))
    ends = [0, *(moving[1:][np.diff(way) != 0]), len(q) - 1]
    out, now = np.zeros(len(q)), 0.0
    for begin, end in zip(ends, ends[1:]):
        out[begin:end + 1] = np.clip(now + q[begin:end + 1] - q[begin], -travel, travel)
        now = out[end]
    return out


def force(terms, joint, travel):
    """Of a size of one."""
    out = np.zeros((1, len(terms.t_s)))
    for part in terms.processed.parts:
        rows = slice(part["begin"], part["end"])
        out[0, rows] = deflection(terms.q[joint, rows], travel) / travel
    return out


def candidates(at):
    half_range = at.extent.half_range[at.number]

    def one(travel):
        family = Family(one, (travel,), (STEP,), (LEAST * half_range,), (MOST * half_range,))
        return candidate("hysteresis", at, force, family=family, travel_rad=travel)

    yield from (one(share * half_range) for share in TRAVELS)


def size(p):
    return f"{abs(p['size_Nm']):.3g} Nm, which slips after {p['travel_rad']:.3g} rad"


ENTRIES = [entry("hysteresis", "a force with hysteresis over much of the travel, as of a hose, a cable or a seal", candidates, size)]
