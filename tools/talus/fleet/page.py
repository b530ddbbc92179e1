"""The fleet's report as one page that needs nothing besides itself."""

import math
import tempfile
from pathlib import Path
from statistics import median

import talus
from talus import constants
from talus.diagnosis import words

from . import drift, reduce

MOST_ROWS, MOST_CHARTS, MOST_BARS = 40, 8, 12


def text(found):
    """The page's text."""
    out = talus.Page("What the fleet's recordings say", found["sentence"])
    _effects(out, found)
    _drift(out, found)
    _stand_out(out, found)
    _changes(out, found)
    _findings(out, found)
    _diagnoses(out, found)
    out.paragraph(f"talus-fleet {constants.TL_VERSION}.")
    with tempfile.TemporaryDirectory(prefix="talus-fleet-") as folder:
        path = Path(folder) / "page.html"
        out.write(path)
        return path.read_text(encoding="utf-8")


def _rows(out, caption, columns, rows):
    """A table, cut where nobody reads on; report.json has all."""
    more = f"; the first {MOST_ROWS} of {len(rows)}, report.json has all" if len(rows) > MOST_ROWS else ""
    out.table(caption + more, columns, rows[:MOST_ROWS], words=True)


def _p(p):
    """A probability of chance."""
    return "below 0.001" if p < 0.001 else f"{p:.3f}"


# ---- effects -----------------------------------------------------------------------

SCOPES = {"fleet": "shared by the fleet", "own": "some robots' own", "scattered": "no robot's in more than half of its diagnoses"}


def _effects(out, found):
    out.heading("Effects, and whose they are")
    if not found["effects"]:
        out.paragraph("No diagnosis names an effect.")
        return
    every = found["effects"][:MOST_BARS]
    out.bars("Robots that have an effect", "robots", [[words.at(one["effect"], one["joint"]), f"{one['having']} of {found['robots']}"] for one in every],
             [one["having"] for one in every], ["extended" if one["scope"] == "fleet" else "accent" for one in every])  # fmt: skip
    _rows(out, "Effect, joint and robot", ["effect", "joint", "whose", "robot", "named in", "than the others", "chance, of all tried"],
          [[words.name(one["effect"]), one["joint"], SCOPES[one["scope"]], robot["robot"], f"{robot['named']} of {robot['of']}",
            "more often" if robot["more_than_the_others"] else "", _p(robot["p_family"])]
           for one in found["effects"] for robot in sorted(one["robots"], key=lambda r: (not r["has"], r["p"], r["robot"]))])  # fmt: skip
    out.paragraph("A robot has an effect that more than half of its diagnoses name with a probability of at least 0.5. Chance is of Fisher's "
                  "exact test against the other robots, corrected for all effects and robots (Holm).")  # fmt: skip


# ---- drift -------------------------------------------------------------------------


def _drift(out, found):
    out.heading("Drift over date and temperature")
    moving = [one for one in found["drift"] if one["drifts"]]
    if found["drift"] and moving:
        _rows(out, "Slopes that are more than chance", ["figure", "robot", "whose", "over", "slope", "all intervals together 95 %", "chance, of all tried", ""],
              [_slope(one) for one in moving])  # fmt: skip
        for one in [one for one in moving if one["scope"] == "own"][:MOST_CHARTS]:
            _chart(out, found, one)
    out.paragraph(f"{len(found['drift'])} slopes were tried, {len(moving)} are more than chance: Theil and Sen's slopes of the sessions' medians "
                  f"over at least {drift.FEWEST} sessions, Kendall's test, for the fleet the regional one, corrected for all that were "
                  "tried (Holm). The tests take sessions for independent.")  # fmt: skip


def _slope(one):
    unit = words.unit(one["quantity"])
    low_high = "too few sessions" if one["interval"] is None else f"{one['interval'][0]:.3g} to {one['interval'][1]:.3g}"
    low_high = "" if one["robot"] == drift.FLEET else low_high
    together = "date and temperature went together: either may be the cause" if one["together"] else ""
    return [one["quantity"], one["robot"], one["scope"], one["over"], f"{one['slope']:.3g} {unit} per {drift.OVER[one['over']]}", low_high, _p(one["p_family"]), together]


def _chart(out, found, one):
    """A robot's figure, its slope, and the fleet's median."""
    key = "day" if one["over"] == "date" else "temperature_C"
    points = [(s["robot"], s[key], v["value"]) for s in found["sessions"] for v in s["values"]
              if (v["kind"], v["quantity"]) == (one["kind"], one["quantity"]) and s[key] is not None]  # fmt: skip
    origin = min(x for _, x, _ in points) if key == "day" else 0.0
    own = sorted((x - origin, y) for robot, x, y in points if robot == one["robot"])
    xs, middle = [x for x, _ in own], median(x for x, _ in own)
    others = median(y for robot, _, y in points if robot != one["robot"]) if any(r != one["robot"] for r, _, _ in points) else None
    level = median(y - one["slope"] * (x - middle) for x, y in own)
    lines = [("recorded sessions", "measured", xs, [y for _, y in own]),
             ("robust slope", "identified", xs, [level + one["slope"] * (x - middle) for x in xs])]  # fmt: skip
    if others is not None:
        lines.append(("median of the other robots", "noise", xs, [others] * len(xs)))
    unit = words.unit(one["quantity"])
    out.chart(f"{one['robot']}: {one['quantity']} over {one['over']}", "time [days]" if key == "day" else "temperature [°C]",
              f"{one['quantity']}{f' [{unit}]' if unit else ''}", lines)  # fmt: skip


# ---- what stands out ---------------------------------------------------------------


def _stand_out(out, found):
    out.heading("Robots that stand out")
    if found["stand_out"]:
        every = found["stand_out"][:MOST_BARS]
        out.bars("How far", "robust standard deviations of the fleet", [[one["robot"], one["quantity"]] for one in every],
                 [one["deviations"] for one in every], ["accent"] * len(every))  # fmt: skip
        _rows(out, "Medians over a robot's sessions", ["robot", "figure", "robot's", "fleet's", "deviations", "chance, of all tried"],
              [[one["robot"], one["quantity"], f"{one['value']:.4g}", f"{one['fleet']:.4g}", f"{one['deviations']:+.1f}", _p(one["p_family"])]
               for one in found["stand_out"]])  # fmt: skip
    else:
        out.paragraph("None, among all figures of all robots.")


def _changes(out, found):
    out.heading("Against the session before")
    if found["new_effects"]:
        _rows(out, "Effects that no earlier session of the robot has", ["robot", "session", "before", "effect", "named in"],
              [[one["robot"], one["session"], one["before"], words.at(one["effect"], one["joint"]), f"{one['named']} of {one['of']}"]
               for one in found["new_effects"]])  # fmt: skip
    if found["changes"]:
        _rows(out, "Changes that are unusual in this fleet", ["robot", "session", "before", "figure", "change", "deviations", "chance, of all tried"],
              [[one["robot"], one["session"], one["before"], one["quantity"], _change(one), f"{one['deviations']:+.1f}", _p(one["p_family"])]
               for one in found["changes"]])  # fmt: skip
    if not found["new_effects"] and not found["changes"]:
        out.paragraph("No session differs from the one before by more than sessions of this fleet do.")


def _change(one):
    return f"× {math.exp(one['value']):.3g}" if one["kind"] == "gap" else f"{one['value']:+.3g}"


# ---- what it was made of -------------------------------------------------------------


def _findings(out, found):
    if found["findings"]:
        out.heading("What is wrong with recordings")
        _rows(out, "Findings", ["finding", "", "column", "diagnoses", "robots"],
              [[one["id"].replace("_", " "), "grave" if one["grave"] else "", one["column"], str(one["items"]), reduce.names(one["robots"])]
               for one in found["findings"]])  # fmt: skip


def _diagnoses(out, found):
    out.heading("Diagnoses")
    _rows(out, "Verdicts", ["verdict", "diagnoses"], [[name, str(count)] for name, count in found["verdicts"].items()])
    if found["failed"]:
        _rows(out, "Failed", ["robot", "session", "what was said"], [[one["robot"], one["session"], one["said"]] for one in found["failed"]])
    if found["waiting"]:
        out.paragraph(f"{len(found['waiting'])} are not diagnosed yet.")
