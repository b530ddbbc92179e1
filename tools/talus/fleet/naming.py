"""Effect x joint x robot: what the fleet shares, and what is some robots' own."""

from . import evidence

MOST = 0.5  # a robot has an effect that more than this share of its diagnoses names; so does a fleet of robots


def effects(by_robot):
    """[{effect, joint, scope, robots}], the most widespread first. `scope`: `fleet`, at least half of the robots have it; `own`,
    some robots have it; `scattered`, no robot has it in more than half of its diagnoses."""
    of = {robot: sum(session.count for session in own) for robot, own in by_robot.items()}
    causes = sorted({cause for own in by_robot.values() for session in own for cause in session.named})
    out = []
    for effect, joint in causes:
        counts = {robot: sum(s.named.get((effect, joint), 0) for s in own) for robot, own in by_robot.items()}
        robots = [_robot(robot, counts, of) for robot in counts if counts[robot]]
        having = [one for one in robots if one["has"]]
        scope = "fleet" if len(having) >= 2 and len(having) >= MOST * len(of) else "own" if having else "scattered"
        out.append({"effect": effect, "joint": joint, "scope": scope, "having": len(having), "robots": robots})
    _judge(out)
    return sorted(out, key=lambda one: (-one["having"], -sum(r["named"] for r in one["robots"]), one["effect"], one["joint"]))


def _robot(robot, counts, of):
    """How often one robot's diagnoses name an effect, and how that compares with the others'."""
    here, elsewhere = counts[robot], sum(counts.values()) - counts[robot]
    p = evidence.more_often(here, of[robot], elsewhere, sum(of.values()) - of[robot])
    return {"robot": robot, "named": here, "of": of[robot], "has": here > MOST * of[robot], "p": p}


def _judge(found):
    """Within the family of all effects and robots, is a robot's count more than chance?"""
    every = [robot for one in found for robot in one["robots"]]
    for robot, p in zip(every, evidence.holm([robot["p"] for robot in every]) if every else []):
        robot["p_family"], robot["more_than_the_others"] = float(p), bool(p < evidence.LEVEL)
