"""Can an effect that pushes back be what it seems? A spring is not, whose stiffness is below 0 over most of the motion."""

import numpy as np

from ..calibration.thresholds import DEVIATIONS, HALF
from ..figures import covariance
from .drawing import beside_drawing

PLACES = 21  # over the range of the motion


def may_push_back(search, fit, candidate):
    """Is its stiffness above 0, as far as the recording tells, over half of the range? True where it has none."""
    stiffness = search.dataset.effects[candidate.effect].stiffness
    if stiffness is None:
        return True
    near, shown = beside_drawing(search, fit)  # gravity and a spring may be each other's beside any machine
    place = [c.key for c in shown.chosen].index(candidate.key)
    own, strengths = shown.chosen[place], np.array(shown.strengths[place])
    count, end = len(strengths), sum(len(c.columns) for c in shown.chosen[place + 1:])
    known = covariance(near, shown)
    known = known[len(known) - end - count:len(known) - end, len(known) - end - count:len(known) - end]
    middle, half = (x[search.dataset.model.joints.index(own.joint)] for x in (search.extent.middle, search.extent.half_range))
    q = np.linspace(middle - half, middle + half, PLACES)
    slopes = np.array([stiffness(own.parameters(one), q) * np.ones(PLACES) for one in np.eye(count)])
    error = np.sqrt(np.einsum("ij,ik,kj->j", slopes, known, slopes))
    return bool(np.mean(strengths @ slopes < -DEVIATIONS * error) <= HALF)
