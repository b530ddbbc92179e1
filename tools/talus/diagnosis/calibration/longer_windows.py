"""Looking again, through a slower low-pass, where what the readings do hides what the machine does.

Steps of a coarse encoder become accelerations that grow with the square of the frequency. The inertia may come out right beside them, and still
an elastic effect gains more of them than the machine's own effect of what it leaves: replicates gain as much. Through windows of the motion
as long as the low-pass the steps weigh less than what moves slowly, though reversals are smeared.
"""

from .thresholds import HALF


def hidden_by_readings(search, verdict):
    """Do replicates leave more than the noise, and gain as much of it as the recordings do, while nothing is said with confidence but that there
    is no effect?"""
    calibration = search.calibration
    if not calibration or not calibration.outdone() or sum(calibration.excess.values()) < search.freedom:
        return False
    return verdict.effect == "none" or verdict.probabilities[0][0] < HALF


def look_again(first, others, look):
    """The `first` (Lowpass, search, verdict), or of the `others`, slower or with longer windows, the first one that the readings do not outdo,
    where it names a cause that shows through yet another low-pass; `others` gives (Lowpass, dataset), `look` a look at it."""
    if not hidden_by_readings(*first[1:]):
        return first
    for through, dataset in others:
        _, search, verdict = found = look(through, dataset)
        if search.calibration and not search.calibration.outdone() and verdict.stable is not False:
            return found if verdict.names_a_cause else first
    return first
