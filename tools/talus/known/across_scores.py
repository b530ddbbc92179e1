"""What effects found on one recording do to the error on another one of the machine. Nothing here reads a file."""

from statistics import median

from ..blind.scores import NO_CAUSE, rates
from .across import NOT_THE_SAME

CLAIMED = 0.9


def judged(results):
    """A row for each pair of recordings: where the effects were found, and where they are tested."""
    rows = []
    for result in (one for one in results if one["report"]):
        verdict, effects = result["report"]["verdict"], result["report"]["effects"]
        named = verdict["effect"] not in NO_CAUSE
        first = {"machine": result["setting"]["machine"], "found_on": result["case"], "verdict": verdict["effect"],
                 "probability": verdict["probability"], "claimed": named and verdict["probability"] >= CLAIMED,
                 "listed": " ".join(effect["effect"] for effect in effects)}  # fmt: skip
        for other in result["others"]:
            rows.append({**first, **other, "lower": other["effects"] < other["plain"],
                         "lower_anew": other["effects_anew"] < other["plain_anew"]})  # fmt: skip
    return rows


def claimed(rows):
    """Pairs that count: effects claimed, and a machine that is the same in both recordings."""
    return [row for row in rows if row["claimed"] and row["machine"] not in NOT_THE_SAME]


def bars(rows, results):
    named = [row for row in rows if row["listed"] and not row["claimed"] and row["machine"] not in NOT_THE_SAME]
    return [
        rates("claimed with p >= 0.9: lowers the error on another recording", (row["lower"] for row in claimed(rows)), least=1.0),
        rates("... whose parameters are identified anew", (row["lower_anew"] for row in claimed(rows)), least=1.0),
        rates("named with less: lowers it", (row["lower"] for row in named)),
        rates("... whose parameters are identified anew", (row["lower_anew"] for row in named)),
        rates("no report", (one["report"] is None for one in results), most=0.0),
    ]


def by_machine(rows):
    """[{figures}] of each machine; errors are medians over its pairs, of those with effects."""
    out = []
    for machine in dict.fromkeys(row["machine"] for row in rows):
        part = [row for row in rows if row["machine"] == machine]
        some = [row for row in part if row["listed"]]
        middle = lambda name, some=some: median(row[name] for row in some) if some else None
        out.append({"machine": machine, "pairs": len(part), "with_effects": len(some), "claimed": sum(row["claimed"] for row in part),
                    "lower": sum(row["lower"] for row in some), "lower_anew": sum(row["lower_anew"] for row in some),
                    **{name: middle(name) for name in ("plain", "effects", "plain_anew", "effects_anew")}})  # fmt: skip
    return out
