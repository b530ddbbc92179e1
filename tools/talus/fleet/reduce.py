"""All diagnoses of a fleet as one report: report.json's mapping."""

from talus import constants
from talus.diagnosis import words

from . import drift, evidence, naming, series, stand_out

FEW = 3  # robots or drifts that a sentence names one by one


def fleet(kept):
    """From [(item, ITEM.json's mapping or None)]."""
    diagnosed = [(item, one) for item, one in kept if one and one["status"] == 0]
    by_robot = series.sessions(diagnosed)
    found = {
        "schema": "talus-fleet-report/1", "version": constants.TL_VERSION, "items": len(kept), "diagnosed": len(diagnosed),
        "robots": len({item.robot for item, _ in kept}), "failed": _failed(kept),
        "waiting": [item.name for item, one in kept if one is None], "verdicts": _verdicts(diagnosed), "findings": _findings(diagnosed),
        "level": evidence.LEVEL, "effects": naming.effects(by_robot), "drift": drift.drifts(by_robot),
        "stand_out": stand_out.robots(by_robot), "changes": stand_out.changes(by_robot), "new_effects": stand_out.new_effects(by_robot),
        "sessions": _sessions(by_robot),
    }  # fmt: skip
    return {"schema": found.pop("schema"), "sentence": sentence(found), **found}


def _failed(kept):
    return [{"name": item.name, "robot": item.robot, "session": item.session, "status": one["status"], "said": one["said"]}
            for item, one in kept if one and one["status"] != 0]  # fmt: skip


def _verdicts(diagnosed):
    """{verdict: how many}; the withheld ones by themselves."""
    out = {}
    for _, one in diagnosed:
        name = "withheld" if one["verdict"].get("withheld") else words.at(one["verdict"]["effect"], one["verdict"]["joint"])
        out[name] = out.get(name, 0) + 1
    return dict(sorted(out.items(), key=lambda pair: (-pair[1], pair[0])))


def _findings(diagnosed):
    """[{id, column, grave, items, robots}], the most frequent first."""
    groups = {}
    for item, one in diagnosed:
        for finding in one["findings"]:
            groups.setdefault((finding["id"], finding["column"], finding["grave"]), []).append(item.robot)
    out = [{"id": key[0], "column": key[1], "grave": key[2], "items": len(robots), "robots": sorted(set(robots))} for key, robots in groups.items()]
    return sorted(out, key=lambda one: (not one["grave"], -one["items"], one["id"], one["column"]))


def _sessions(by_robot):
    """What the pictures draw."""
    return [{"robot": s.robot, "session": s.session, "day": s.day, "temperature_C": s.temperature_C, "diagnoses": s.count,
             "values": [{"kind": kind, "quantity": name, "value": value} for (kind, name), value in sorted(s.values.items())]}
            for own in by_robot.values() for s in own]  # fmt: skip


# ---- in words ----------------------------------------------------------------------


def sentence(found):
    """The report in plain words."""
    parts = [f"{found['diagnosed']} of {found['items']} diagnoses of {found['robots']} robot{'s' * (found['robots'] != 1)}"]
    parts += [_cause(one) for one in found["effects"] if _is_told(one)]
    moving = [one for one in found["drift"] if one["drifts"] and one["scope"] != "with the fleet"]
    parts += [drifting(one) for one in moving[:FEW]]
    if len(moving) > FEW:
        parts.append(f"{len(moving) - FEW} more drifts")
    if len(parts) == 1:
        parts.append("nothing that robots share or that sets one apart")
    return "; ".join(parts) + "."


def _is_told(one):
    return one["scope"] == "fleet" or any(robot["has"] and robot["more_than_the_others"] for robot in one["robots"])


def _cause(one):
    """Whose an effect is."""
    at = words.at(one["effect"], one["joint"])
    if one["scope"] == "fleet":
        return f"{at}: shared by the fleet ({one['having']} robots)"
    return f"{at}: {names([robot['robot'] for robot in one['robots'] if robot['has'] and robot['more_than_the_others']])} alone"


def names(robots):
    """A few by name, more by number."""
    return ", ".join(robots) if len(robots) <= 2 * FEW else f"{', '.join(robots[:FEW])} and {len(robots) - FEW} more robots"


def drifting(one):
    """A drift, by what it amounts to over what was seen."""
    unit = words.unit(one["quantity"])
    amount = f"{one['slope'] * one['span']:+.3g}{' ' * bool(unit)}{unit}"
    span = f"{one['span']:.3g} {'days' if one['over'] == 'date' else 'K'}"
    return f"{one['quantity']} of {one['robot']} drifts by {amount} over {span}{' of temperature' if one['over'] == 'temperature' else ''}"
