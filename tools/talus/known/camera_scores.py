"""What a camera adds, counted. Nothing here reads a file."""

from ..blind.scores import rates
from .camera import CAUSES

# The catalogue's one entry for a tilt is that of a bench or of its encoders' zero: it names both, and tells neither from the other.
ALSO = {("gravity_tilt", "base"): {"encoder_offset"}}
PARTED = 0.9  # of the cases that stay open without a camera
ALIGNED_mrad = 1.0  # to which a camera can be aligned with the bench


def rivals(report):
    """Effects that the verdict could as well be."""
    verdict = report["verdict"]
    groups = [group["effects"] for group in report["confusable"] if verdict["effect"] in group["effects"]]
    also = ALSO.get((verdict["effect"], verdict["joint"]), set())
    return sorted(({effect for group in groups for effect in group} | also) - {verdict["effect"]})


def read(report, truth):
    """(words, named exactly, named with nothing beside it) of one report."""
    if report is None:
        return "failed", False, False
    verdict, others = report["verdict"], rivals(report)
    exact = (verdict["effect"], verdict["joint"]) == truth
    words = " or ".join([f"{verdict['effect']} {verdict['probability']:.2f}", *others])
    return words, exact, exact and not others and not verdict.get("withheld")


def judge(result):
    """All that is counted of one case."""
    truth = result["effect"], result["joint"]
    row = {"case": result["case"], "effect": result["effect"], "joint": result["joint"], "size": result["size"]}
    for name, report in (("without", result["without"]), ("with", result["report"])):
        row[name], row[f"exact_{name}"], row[f"alone_{name}"] = read(report, truth)
    return row | {"camera_less_knee_mrad": result["camera_less_knee_mrad"]}


def witnessed(row):
    """Whether the camera's mean alone says if an encoder's zero is off."""
    return (abs(row["camera_less_knee_mrad"]) > ALIGNED_mrad) == (row["effect"] == "encoder_offset")


def bars(rows):
    """What is demanded of all cases together."""
    zeros = [row for row in rows if row["effect"] in ("encoder_offset", "gravity_tilt")]
    still = [row for row in rows if not row["alone_without"]]
    return [
        rates("named exactly and alone, without a camera", (row["alone_without"] for row in rows)),
        rates("named exactly and alone, with a camera", (row["alone_with"] for row in rows)),
        rates("open without a camera: then named exactly and alone", (row["alone_with"] for row in still), least=PARTED),
        rates("named without a camera, and no longer with it", (not row["alone_with"] for row in rows if row["alone_without"]), most=0.0),
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
