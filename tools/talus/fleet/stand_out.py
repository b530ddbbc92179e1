"""Robots that stand out of the fleet, and sessions that stand out of what a robot did the session before."""

import math
from statistics import median

from . import evidence
from .series import all_quantities

FEWEST_ROBOTS, FEWEST_CHANGES = 6, 12  # with fewer, nothing is known of what is usual


def robots(by_robot):
    """[{robot, kind, quantity, value, fleet, deviations, p, p_family}] of robots whose median over their sessions lies off the fleet's."""
    found = []
    for quantity in all_quantities(by_robot):
        own = {robot: [s.values[quantity] for s in sessions if quantity in s.values] for robot, sessions in by_robot.items()}
        at = {robot: median(values) for robot, values in own.items() if values}
        if len(at) >= FEWEST_ROBOTS:
            found += _apart(quantity, [{"robot": robot} for robot in at], list(at.values()))
    return _kept(found)


def changes(by_robot):
    """[{robot, session, before, kind, quantity, value, fleet, ...}] of changes from one session to the next that lie off the changes
    that the fleet, and the robot, are used to; a gap's change is of its logarithm, and only one that grew counts."""
    found = []
    for kind, name in all_quantities(by_robot):
        places, values = [], []
        for robot, sessions in by_robot.items():
            own = [s for s in sessions if (kind, name) in s.values]
            for before, after in zip(own, own[1:]):
                change = _change(kind, before.values[kind, name], after.values[kind, name])
                if change is not None:
                    places.append({"robot": robot, "session": after.session, "before": before.session})
                    values.append(change)
        if len(values) >= FEWEST_CHANGES:
            found += _apart((kind, name), places, values, [place["robot"] for place in places])
    return [one for one in _kept(found) if one["kind"] != "gap" or one["deviations"] > 0]


def _change(kind, before, after):
    if kind != "gap":
        return after - before
    return math.log(after / before) if before > 0 and after > 0 else None


def _apart(quantity, places, values, robots=None):
    """Each value, how far it lies from the others, and how surely."""
    deviations, p = evidence.apart(values, robots)
    usual = median(values)
    return [{**place, "kind": quantity[0], "quantity": quantity[1], "value": float(value), "fleet": float(usual), "deviations": float(off),
             "p": float(one)} for place, value, off, one in zip(places, values, deviations, p)]  # fmt: skip


def _kept(found):
    """Those that stand out among all that were looked at."""
    for one, p in zip(found, evidence.holm([one["p"] for one in found]) if found else []):
        one["p_family"] = float(p)
    return sorted((one for one in found if one["p_family"] < evidence.LEVEL), key=lambda one: (one["p_family"], one["p"], one["robot"]))


def new_effects(by_robot):
    """[{robot, session, before, effect, joint, named, of}] of effects that most of a session's diagnoses name and none of an earlier
    session's did."""
    out = []
    for robot, sessions in by_robot.items():
        known = set(sessions[0].named)
        for before, after in zip(sessions, sessions[1:]):
            for effect, joint in sorted(set(after.named) - known):
                count = after.named[effect, joint]
                if 2 * count > after.count:
                    out.append({"robot": robot, "session": after.session, "before": before.session, "effect": effect, "joint": joint,
                                "named": count, "of": after.count})  # fmt: skip
            known |= set(after.named)
    return sorted(out, key=lambda one: (one["session"], one["robot"], one["effect"]), reverse=True)
