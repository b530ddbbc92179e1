"""The figures of a fleet over its sessions: each identified parameter, each named effect's parameters, what is left unexplained."""

from dataclasses import dataclass, field
from statistics import median

from .table import days

NAMED = 0.5  # probability from which an effect counts as named


@dataclass
class Session:
    """What the diagnoses of one robot and session found: medians of their figures, and the effects that they named."""

    robot: str
    session: str
    day: float
    temperature_C: float | None
    count: int
    values: dict = field(default_factory=dict)  # by quantity
    named: dict = field(default_factory=dict)  # (effect, joint): in how many diagnoses


def named(kept):
    """{(effect, joint): probability} that a diagnosis names."""
    verdict = kept["verdict"]
    out = {(one["effect"], one["joint"]): one["probability"] for one in kept["effects"] if one["probability"] >= NAMED}
    if verdict["effect"] not in ("none", "unknown") and verdict["probability"] >= NAMED:
        out.setdefault((verdict["effect"], verdict["joint"]), verdict["probability"])
    return out


def quantities(kept):
    """{(kind, name): value} of a diagnosis."""
    out = {("parameter", name): value for name, value in kept["parameters"].items()}
    for effect in kept["effects"]:
        if effect["probability"] >= NAMED:
            of = f"{effect['effect']} at the {effect['joint']}"
            out |= {("effect", f"{of}: {name}"): value for name, value in effect["parameters"].items()}
    if kept["parameters"]:  # identified: no grave finding
        out |= {("gap", f"{joint}: gap"): gap["extended_rms"] for joint, gap in kept["gap"].items()}
    return out


def sessions(diagnosed):
    """{robot: [Session]} in order of time, from [(item, ITEM.json's mapping)]. Recordings of a session share its state, so that
    they are one sample of it."""
    groups = {}
    for item, kept in diagnosed:
        groups.setdefault(item.robot, {}).setdefault(item.session, []).append((item, kept))
    return {robot: sorted((_session(robot, name, own) for name, own in by.items()), key=lambda s: s.day) for robot, by in sorted(groups.items())}


def _session(robot, name, own):
    temperatures = [item.temperature_C for item, _ in own if item.temperature_C is not None]
    out = Session(robot, name, days(name), median(temperatures) if temperatures else None, len(own))
    values = {}
    for _, kept in own:
        for quantity, value in quantities(kept).items():
            values.setdefault(quantity, []).append(value)
        for cause in named(kept):
            out.named[cause] = out.named.get(cause, 0) + 1
    out.values = {quantity: median(found) for quantity, found in values.items()}
    return out


def all_quantities(by_robot):
    """Every quantity of the fleet, sorted."""
    return sorted({quantity for own in by_robot.values() for session in own for quantity in session.values})
