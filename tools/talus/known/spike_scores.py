"""What came of spikes, counted against the recording as it is. Nothing here reads a file."""

from statistics import mean, median

from ..blind.scores import NO_CAUSE, Bar, rates
from . import spike_sizes
from .spikes import FORMS, SHARES

NAMED = 0.5
SEEN = 0.045  # of the torque: from here on the effect should be named (0.05, as near as strengths are searched)


def names(report, least):
    """Effects of verdict and list with at least this probability."""
    every = [report["verdict"], *report["effects"]]
    return {e["effect"] for e in every if e["effect"] not in NO_CAUSE and e["probability"] >= least}


def judge(result, control):
    """All that is counted of one spike; `control` is the result of the recording as it is."""
    setting, report = result["setting"], result["report"]
    row = {"case": result["case"], **setting, "leaves": result["leaves"], "verdict": "", "probability": None,
           **dict.fromkeys(("named", "exact", "there_before", "first_wrong", "further", "size", "size_off", "size_within")),
           "outcome": "failed"}  # fmt: skip
    if report is None or control["report"] is None:
        return row
    before = names(control["report"], 0.0)
    own = {setting["effect"], *FORMS[setting["form"]].alias}
    said, verdict = names(report, NAMED), report["verdict"]
    allowed = own | before
    first = verdict["effect"] if verdict["effect"] in said else None
    further = sorted(said - allowed - {first})
    size = spike_sizes.told(FORMS[setting["form"]].size, setting["effect"], report) if setting["effect"] in said else None
    if size and result["size"]:
        low, value, high = size
        row |= {"size": result["size"], "size_off": value / result["size"] - 1, "size_within": low <= result["size"] <= high}
    return row | {"verdict": verdict["effect"], "probability": verdict["probability"], "named": bool(own & said),
                  "exact": setting["effect"] in said, "there_before": bool(own & before),
                  "first_wrong": first is not None and first not in allowed, "further": " ".join(further), "outcome": "judged"}  # fmt: skip


def judged(results):
    """A row for each spike, each against its control."""
    controls = {r["setting"]["machine"]: r for r in results if not r["setting"]["form"]}
    return [judge(r, controls[r["setting"]["machine"]]) for r in results if r["setting"]["form"]]


def new(rows):
    """Spikes of effects that the recording does not show as it is."""
    return [row for row in rows if row["outcome"] == "judged" and not row["there_before"]]


def seen(rows):
    return [row for row in rows if row["leaves"] >= SEEN]


def bars(rows):
    told, fresh = [row for row in rows if row["outcome"] == "judged"], new(rows)
    sized = [row for row in fresh if row["size"] is not None]
    return [
        rates("leaves >= 5 % of the torque: named, or its alias", (row["named"] for row in seen(fresh)), least=0.90),
        rates("... named exactly", (row["exact"] for row in seen(fresh))),
        rates("leaves less: named, or its alias", (row["named"] for row in fresh if row not in seen(fresh))),
        rates("first name wrong", (row["first_wrong"] for row in told), most=0.015),
        rates("a further effect that neither spike nor control has", (bool(row["further"]) for row in told), most=0.05),
        rates("named rightly, and of the added form: size within its interval", (row["size_within"] for row in sized), least=0.90),
        Bar("... off by (median, of the size)", median(abs(row["size_off"]) for row in sized) if sized else None, len(sized)),
        rates("effect that the control has already (not in the first lines)", (row["there_before"] for row in told)),
        rates("no report", (row["outcome"] == "failed" for row in rows), most=0.0),
    ]


def groups(rows):
    """[(what, value, rows)]: by size, effect and set of recordings."""
    for share in SHARES:
        yield "leaves", f"{100 * share:g} %", [row for row in rows if row["share"] == share]
    for axis, of in (("effect", lambda row: row["effect"]), ("machine", lambda row: row["machine"].split("_")[0])):
        for value in sorted({of(row) for row in rows}):
            yield axis, value, [row for row in rows if of(row) == value]


def by_group(rows):
    """[{figures}] of each group; `named` of effects that the control does not have."""
    out = []
    for axis, value, part in groups([row for row in rows if row["outcome"] == "judged"]):
        fresh = new(part)
        if part:
            out.append({"axis": axis, "value": value, "cases": len(part), "new": len(fresh),
                        "named": mean(r["named"] for r in fresh) if fresh else None,
                        "first_wrong": mean(r["first_wrong"] for r in part),
                        "further": mean(bool(r["further"]) for r in part)})  # fmt: skip
    return out
