"""Looking again, through longer windows of the motion, where what the readings do hides what the machine does, or another low-pass
contradicts what is found.

Differentiated over short windows, the steps of a coarse encoder become large accelerations. A spring or a gap behind the motor filters these,
and so explains much of what they do, in replicates that have neither as in the recordings: what the machine does itself is less than
that. Windows as long as the low-pass leave less of the steps, though they smear reversals.
"""

import gc

from .thresholds import HALF


def hidden_by_readings(search, verdict):
    """Do replicates leave more than the noise, and gain as much of it as the recordings do, while the verdict is `none` or unsure?"""
    calibration = search.calibration
    if not calibration or not calibration.outdone() or sum(calibration.excess.values()) < search.freedom:
        return False
    return verdict.effect == "none" or verdict.probabilities[0][0] < HALF


def contradicted(verdict):
    """Does another low-pass not show the cause that this one does, or not of that size?"""
    return verdict.stable is False


def look_again(first, others, look):
    """The `first` look (Lowpass, search, verdict), or another: of the `others` (Lowpass, dataset) the first one in which something gains more than
    replicates do and that another low-pass does not contradict, where it names a cause. `look` makes a look of one."""
    if not contradicted(first[2]) and not hidden_by_readings(*first[1:]):
        return first
    for one in others:
        found = look(*one)
        if tells(*found[1:]):
            return found if found[2].names_a_cause else first
        del found, one  # no more than two searches are held at once
        gc.collect()  # their candidates hold torque terms in circles
    return first


def tells(search, verdict):
    """Does something gain more than the readings alone do, and show through another low-pass as well?"""
    return bool(search.calibration and not search.calibration.outdone() and not contradicted(verdict))
