"""Can an effect that pushes back be what it seems? A spring is not, whose stiffness is below 0 over most of the motion."""

import numpy as np

from ..calibration.thresholds import DEVIATIONS, HALF
from ..figures import covariance

PLACES = 21  # over the range of the motion


def pushes_away(search, fit, key):
    """Is the stiffness of a fit's effect below 0, as far as the recording tells, over more than half of the range? False where it has none."""
    stiffness = search.dataset.effects[key[0]].stiffness
    if stiffness is None:
        return False
    place = [c.key for c in fit.chosen].index(key)
    own, strengths = fit.chosen[place], np.array(fit.strengths[place])
    count, end = len(strengths), sum(len(c.columns) for c in fit.chosen[place + 1:])
    known = covariance(search, fit)
    known = known[len(known) - end - count:len(known) - end, len(known) - end - count:len(known) - end]
    middle, half = (x[search.dataset.model.joints.index(own.joint)] for x in (search.extent.middle, search.extent.half_range))
    q = np.linspace(middle - half, middle + half, PLACES)
    slopes = np.array([stiffness(own.parameters(one), q) * np.ones(PLACES) for one in np.eye(count)])
    error = np.sqrt(np.einsum("ij,ik,kj->j", slopes, known, slopes))
    return bool(np.mean(strengths @ slopes < -DEVIATIONS * error) > HALF)
