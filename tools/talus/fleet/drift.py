"""Drift of figures over date and temperature: robust slopes, and which of them are more than chance among all that were tried."""

import numpy as np

from . import evidence
from .series import all_quantities

FEWEST = 5  # sessions that a slope is made of
FEWEST_ROBOTS = 3  # that a slope of the whole fleet is made of
OVER = {"date": "day", "temperature": "K"}
FLEET = "the fleet"
SCOPES = ("fleet", "own", "with the fleet")


def drifts(by_robot):
    """[{robot, kind, quantity, over, slope, interval, sessions, p, p_family, drifts, scope, together}] of all that was tried: the
    fleet's, then robots' own, then those that go with the fleet, each the surest first."""
    found = [one for robot, own in by_robot.items() for one in _of_robot(robot, own, all_quantities(by_robot))]
    found += _of_fleet(found, len(by_robot))
    if not found:
        return []
    for one, p in zip(found, evidence.holm([one["p"] for one in found])):
        one["p_family"], one["drifts"] = float(p), bool(p < evidence.LEVEL)
        x, y = one.pop("x"), one.pop("y")
        if x is not None:  # each interval at a level at which all of them hold together
            one["interval"] = evidence.slope(x, y, evidence.LEVEL / len(found))[1]
    _place(found)
    return sorted(found, key=lambda one: (SCOPES.index(one["scope"]), one["p_family"], one["p"], one["robot"], one["quantity"], one["over"]))


def _place(found):
    """`scope`: a slope of the fleet, one robot's own, or a robot's that goes the way the fleet goes."""
    ways = {(one["quantity"], one["over"], one["slope"] > 0) for one in found if one["robot"] == FLEET and one["drifts"]}
    for one in found:
        along = (one["quantity"], one["over"], one["slope"] > 0) in ways
        one["scope"] = "fleet" if one["robot"] == FLEET else "with the fleet" if along else "own"


def _of_robot(robot, own, quantities):
    """Each quantity of a robot over date and temperature."""
    together = _together(own)
    for kind, quantity in quantities:
        if kind == "gap":
            continue
        for over in OVER:
            x, y = _points(own, (kind, quantity), over)
            if len(x) < FEWEST or len(np.unique(x)) < FEWEST or np.ptp(y) == 0:
                continue
            yield {"robot": robot, "kind": kind, "quantity": quantity, "over": over, "slope": evidence.slope(x, y)[0], "interval": None,
                   "sessions": len(x), "span": float(np.ptp(x)), "median": float(np.median(y)), "p": evidence.trend(x, y),
                   "together": together, "x": x, "y": y}  # fmt: skip


def _points(own, quantity, over):
    at = [(s.day if over == "date" else s.temperature_C, s.values[quantity]) for s in own if quantity in s.values]
    at = [(x, y) for x, y in at if x is not None]
    return np.array([x for x, _ in at]), np.array([y for _, y in at])


def _together(own):
    """Did temperature move along with the date? Then a slope over one may be the other's."""
    at = [(s.day, s.temperature_C) for s in own if s.temperature_C is not None]
    return len(at) >= FEWEST and evidence.trend(*zip(*at)) < evidence.LEVEL


def _of_fleet(found, robots):
    """What the robots have in common: the median of their slopes, and whether they go one way."""
    groups = {}
    for one in found:
        groups.setdefault((one["kind"], one["quantity"], one["over"]), []).append(one)
    for (kind, quantity, over), own in groups.items():
        if len(own) < max(FEWEST_ROBOTS, robots / 2):
            continue
        yield {"robot": FLEET, "kind": kind, "quantity": quantity, "over": over, "slope": float(np.median([one["slope"] for one in own])),
               "interval": None, "sessions": sum(one["sessions"] for one in own), "span": max(one["span"] for one in own),
               "median": float(np.median([one["median"] for one in own])), "p": evidence.common_trend([(one["x"], one["y"]) for one in own]),
               "together": any(one["together"] for one in own), "x": None, "y": None}  # fmt: skip
