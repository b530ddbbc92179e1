"""What a camera adds, counted. Nothing here reads a file."""

from ..blind.scores import rates
from .camera import CAUSES

# The catalogue's one entry for a tilt is that of a bench or of its encoders' zero: its `source` says which, if a camera tells.
TILT, ZERO = ("gravity_tilt", "base"), ("encoder_offset", "knee")
# Without a sensor at the output the catalogue has no wrong torque constant: identification takes it into masses and frictions, which
# fit in proportion, and nothing is left.
TAKEN_UP = {"torque_constant": ("none", "none")}
OTHER = {"encoder_offset": "gravity_tilt", "elasticity": "base_compliance", "torque_constant": "linkage_error"}  # of each pair
OTHER |= {second: first for first, second in OTHER.items()}
LEAST = 0.05  # probability from which the other one stays open
NAMED = 0.5  # probability from which a cause is said to be there
PARTED = 0.9  # of the cases that stay open without a camera
ALIGNED_mrad = 1.0  # to which a camera can be aligned with the bench


def named(report):
    """((effect, joint) of the verdict, what a tilt could be as well)."""
    found = report["verdict"]["effect"], report["verdict"]["joint"]
    if found != TILT:
        return found, set()
    source = next((effect["source"] for effect in report["effects"] if "source" in effect), None)
    if source is None or source["encoder"] is None:
        return TILT, {ZERO[0]}
    first, other = (ZERO, TILT) if source["encoder"] >= 0.5 else (TILT, ZERO)
    return first, {other[0]} if min(source["encoder"], source["bench"]) > LEAST else set()


def rivals(report):
    """Effects that the verdict could as well be."""
    effect = report["verdict"]["effect"]
    groups = [group["effects"] for group in report["confusable"] if effect in group["effects"]]
    return sorted({other for group in groups for other in group if other != effect} | named(report)[1])


def read(report, truth):
    """(words, named exactly, named with nothing beside it, effects that it could as well be) of one report."""
    if report is None:
        return "failed", False, False, []
    verdict, (found, _), others = report["verdict"], named(report), rivals(report)
    exact = found == truth
    words = " or ".join([f"{found[0]} {verdict['probability']:.2f}", *others])
    return words, exact, exact and not others and not verdict.get("withheld"), others


def wrong(report, truth):
    """Is a cause named that is not there, nor one that is told to be as likely?"""
    if report is None or report["verdict"]["probability"] < NAMED:
        return False
    found, alike = named(report)
    return found not in (truth, ("none", "none"), ("unknown", "none")) and truth[0] not in alike


def judge(result):
    """All that is counted of one case."""
    truth = TAKEN_UP.get(result["effect"], (result["effect"], result["joint"]))
    row = {"case": result["case"], "effect": result["effect"], "joint": result["joint"], "size": result["size"]}
    for name, report in (("without", result["without"]), ("with", result["report"])):
        row[name], row[f"exact_{name}"], row[f"alone_{name}"], others = read(report, truth)
        row[f"apart_{name}"] = row[f"exact_{name}"] and OTHER.get(result["effect"]) not in others
    row["wrong_with"] = wrong(result["report"], truth)
    return row | {"camera_less_knee_mrad": result["camera_less_knee_mrad"]}


def witnessed(row):
    """Whether the camera's mean alone says if an encoder's zero is off."""
    return (abs(row["camera_less_knee_mrad"]) > ALIGNED_mrad) == (row["effect"] == "encoder_offset")


def bars(rows):
    """What is demanded of all cases together."""
    zeros = [row for row in rows if row["effect"] in ("encoder_offset", "gravity_tilt")]
    still = [row for row in rows if not row["alone_without"]]
    paired = [row for row in rows if row["effect"] in OTHER and not row["apart_without"]]
    return [
        rates("named exactly and alone, without a camera", (row["alone_without"] for row in rows)),
        rates("named exactly and alone, with a camera", (row["alone_with"] for row in rows)),
        rates("open without a camera: then named exactly and alone", (row["alone_with"] for row in still), least=PARTED),
        rates("not told from its pair's other without a camera: then told", (row["apart_with"] for row in paired), least=PARTED),
        rates("named without a camera, and no longer with it", (not row["alone_with"] for row in rows if row["alone_without"]), most=0.0),
        rates("with a camera: a cause named that is not there", (row["wrong_with"] for row in rows), most=0.0),
        rates("offset or tilt: the mean of camera less encoder says which", map(witnessed, zeros)),
    ]


def by_cause(rows):
    """Counts of each cause that was drawn: cases, and exact and alone without and with a camera."""
    found = []
    for effect in CAUSES:
        part = [row for row in rows if row["effect"] == effect]
        if part:
            names = "exact_without", "alone_without", "exact_with", "alone_with"
            found.append({"effect": effect, "cases": len(part), **{name: sum(row[name] for row in part) for name in names}})
    return found
