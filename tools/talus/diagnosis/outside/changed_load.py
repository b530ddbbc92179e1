"""A load that changes while it is recorded: a payload that comes on or falls off, a part that comes loose."""

import numpy as np

from ..catalogue.candidate import Family
from .law import candidate, entry

FIRST_S, LAST = 3.0, 0.85  # instants that are tried: from so soon on, to this share of the longest recording
INSTANTS = 12
PARTS = ("inertia", "load", "stiffness_Nm_rad")


def load(terms, joint, at_s):
    """What is added from an instant of each recording on: an inertia, a share of the load, and a force that goes with the angle."""
    after = terms.t_s - terms.processed.recording.origin.begin_s >= at_s
    return np.array([terms.a[joint], terms.instants(joint)["load_Nm"], terms.q[joint]]) * after


def candidates(at):
    longest_s = max(terms.t_s[-1] - terms.processed.recording.origin.begin_s for terms in at.all_terms)
    last_s = LAST * longest_s
    if last_s < 2 * FIRST_S:
        return
    step = (last_s / FIRST_S) ** (1 / (INSTANTS - 1))

    def one(at_s):
        family = Family(one, (at_s,), (step**0.5,), (0.5 * FIRST_S,), (longest_s - FIRST_S,))
        return candidate("changed_load", at, load, PARTS, family, at_s=at_s)

    yield from (one(FIRST_S * step**k) for k in range(INSTANTS))


ENTRIES = [entry("changed_load", "a load that changes during the recording", candidates, lambda p: f"from {p['at_s']:.3g} s on")]
