"""Friction that changes with time or temperature."""

import math

import numpy as np

from ..catalogue.candidate import Family, named
from ..catalogue.sizes import change, of_friction
from .entry import Effect

DRIFT_TIMES_S = (5, 10, 20, 40, 80, 200)
EVENLY, SETTLING = 1000.0, 3.0  # sessions in a time constant so long that change is even; time constants in a session
FROM_TWICE, MOST = -2.0, 3.0  # of the friction on the average: from twice that to none; cold grease drags a few times as much as warm


def _over_session(all_terms):
    """Changes over all recordings, taken one after the other in the order given: (name, time constant)."""
    if len(all_terms) > 1:
        whole_s = all_terms[0].dataset.session_s
        yield "evenly over the session", EVENLY * whole_s
        yield "settling over the session", whole_s / SETTLING


def candidates(at):
    """Strengths are shares of the friction at the fitted parameters; the model file has them in torques. What changes does
    so from the begin, so that the base parameters are the friction there, which is positive; and it stays friction."""
    j = at.number
    dry, viscous = (max(float(x[j]), 0.0) for x in (at.all_terms[0].coulomb_Nm, at.all_terms[0].viscous))
    of_all, of_dry = {"coulomb_Nm": dry, "viscous_Nms_rad": viscous}, {"coulomb_Nm": dry}
    make = lambda form, amounts, shapes, name, **more: at.of_law(
        "friction_drift", form, [amounts], shapes, parameters=named(name), **more)  # fmt: skip
    longest_s = max(float(np.ptp(s.processed.t_s)) for s in at.all_terms)

    def timed(form, amounts, name):
        def one(constant):
            shapes, come = {"time_constant_s": float(constant)}, 1.0 - math.exp(-longest_s / constant)
            return at.of_law("friction_drift", f"{form}, {constant:g} s", [amounts], shapes, parameters=named(name, **shapes),
                             low=(FROM_TWICE / come,), high=(MOST / come,),
                             family=Family(one, (constant,), (1.5,), (2.0,), (1000.0,)))  # fmt: skip
        return one

    of_time = timed("all", of_all, "share_at_end"), timed("Coulomb", of_dry, "coulomb_share_at_end")
    for constant in DRIFT_TIMES_S:
        yield from (one(constant) for one in of_time)
    warm = {"time_constant_s": 1.0}  # a later recording finds what the last one ended with
    for name, constant_s in _over_session(at.all_terms):
        whole = 1.0 - math.exp(-at.dataset.session_s / constant_s)
        shapes = {"time_constant_s": constant_s}
        for form, amounts, figure in (("all", of_all, "share_at_end"), ("Coulomb", of_dry, "coulomb_share_at_end")):
            by_end = {parameter: amount / whole for parameter, amount in amounts.items()}
            yield make(f"{form}, {name}", by_end, shapes, figure, saved=([amounts], warm), session=True, low=(FROM_TWICE,), high=(MOST,))
    sensor = f"{at.name}_temp_C"
    if all(sensor in s.columns for s in at.all_terms):
        middle = float(np.mean([np.mean(s.columns[sensor]) for s in at.all_terms]))
        shapes = {"time_constant_s": 60.0, "middle_C": middle}  # the time does not count here
        by_temperature = lambda amounts: {f"{name}_10K": amount for name, amount in amounts.items()}
        yield make("temperature", by_temperature(of_all), shapes, "share_per_10_C")
        yield make("Coulomb, temperature", by_temperature(of_dry), shapes, "coulomb_share_per_10_C")
        yield make("viscous, temperature", {"viscous_Nms_rad_10K": 1.0}, shapes, "viscous_Nms_rad_per_10_C")


def size(p):
    at_end = of_friction(p, "share_at_end", "coulomb_share_at_end")
    if at_end:
        return change(*at_end) + " in the end"
    warmer = of_friction(p, "share_per_10_C", "coulomb_share_per_10_C")
    return change(*warmer) + " for each 10 °C" if warmer else ""


EFFECT = Effect(
    id="friction_drift",
    words="friction that changes with time or temperature",
    candidates=candidates,
    size=size,
    coordinates=("time",),
    needs="warmth",
)
