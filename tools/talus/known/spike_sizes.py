"""How large an added effect is, in the parameter that a report has for it; for forms of which both laws are the same."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

LATEST_S = 0.01  # of a current


@dataclass(frozen=True)
class Size:
    """`added(machine, motion, strength)` in the unit of the report's `parameter`; `same(parameters)`: did the report take this form?"""

    added: Callable
    parameter: str
    same: Callable = lambda parameters: True

    def said(self, effect):
        """(low, value, high) of a report's effect; None where it has another form."""
        parameters, interval = effect["parameters"], effect.get("interval", {})
        if not self.same(parameters) or self.parameter not in interval:
            return None
        low, high = interval[self.parameter]
        return low, parameters[self.parameter], high


class Amplitude(Size):
    """Of a wave that the report has as sine and cosine."""

    def said(self, effect):
        parameters, interval = effect["parameters"], effect.get("interval", {})
        names = ("sine_Nm", "cosine_Nm")
        if not self.same(parameters) or not all(name in interval for name in names):
            return None
        value = math.hypot(*(parameters[name] for name in names))
        half = math.hypot(*(parameters[name] * 0.5 * (interval[name][1] - interval[name][0]) for name in names)) / value
        return value - half, value, value + half


def torque(machine, strength):
    return strength * machine.rms(machine.measured())


def bumper(machine, motion, strength):
    low, high = np.quantile(motion.position[machine.used], (0.001, 0.999))
    return torque(machine, strength) * 2 / (high - low)


ASYMMETRY = Size(lambda m, x, s: torque(m, s) / x.top, "viscous_Nms_rad", lambda p: not p.get("coulomb_Nm"))
OF_LOAD = Size(lambda m, x, s: torque(m, s) / m.rms(m.fitted()[1]), "coefficient", lambda p: p.get("exponent", 1.0) == 1.0)
BUMPER = Size(bumper, "bumper_Nm_rad", lambda p: p.get("bumper_Nm_rad", 0.0) > 0)
TEETH = Amplitude(lambda m, x, s: torque(m, s), "", lambda p: "per_turn_2" not in p)
LATE = Size(lambda m, x, s: s * LATEST_S, "delay_s")


def added(size, machine, strength):
    """Of a spike in the unit of the report's parameter; None where the report has no such one."""
    return float(size.added(machine, machine.motion(), strength)) if size else None


def told(size, effect, report):
    """(low, value, high) that a report says of a spike's effect; None where it says none."""
    mine = [one for one in report["effects"] if one["effect"] == effect]
    return size.said(mine[0]) if size and mine else None
