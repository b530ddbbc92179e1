"""What came of benches without any effect, counted. Nothing here reads a file."""

from statistics import mean

from ..blind.scores import NO_CAUSE, Bar, rates
from .nulls import AXES

# Findings by which a report is withheld because the recording shows too little. Any other one accuses a sound recording, as
# `saturated` does where no drive was at its limit.
TOO_LITTLE = {"too_short", "too_slow", "too_little_motion", "coarse"}
NAMED, SURE = 0.5, 0.9
SHORT_OF_TRUTH = 0.05  # by which P(none) may lie below what comes true


def probability(report, effect):
    """Of a verdict or an alternative, over all joints."""
    return sum(e["probability"] for e in [report["verdict"], *report["alternatives"]] if e["effect"] == effect)


def cause(report):
    """(effect, its largest probability): of the verdict and of all that is listed; (None, 0) without any."""
    every = [(e["effect"], e["probability"]) for e in [report["verdict"], *report["effects"]] if e["effect"] not in NO_CAUSE]
    return max(every, key=lambda e: e[1], default=(None, 0.0))


def judge(result):
    """All that is counted of one case."""
    report = result["report"]
    row = {"case": result["case"], **result["setting"], "verdict": "failed", "probability": 0.0, "outcome": "failed",
           "cause": "", "cause_probability": 0.0, "p_none": None, "p_unknown": None, "finding": "",
           "processor_s": result["processor_s"], "peak_MB": result["peak_MB"]}  # fmt: skip
    if report is None:
        return row
    verdict = report["verdict"]
    name, size = cause(report)
    row |= {"verdict": verdict["effect"], "probability": verdict["probability"], "cause": name or "", "cause_probability": size}
    if verdict.get("withheld"):
        grave = [finding["id"] for finding in report["findings"] if finding["grave"]]
        row["finding"] = " ".join(grave)
        true = TOO_LITTLE | ({"saturated"} if "current limit" in result["bench"] else set())
        row["outcome"] = "shows too little" if grave and set(grave) <= true else "accused"
    else:
        row |= {"outcome": verdict["effect"] if verdict["effect"] in NO_CAUSE else "cause",
                "p_none": probability(report, "none"), "p_unknown": probability(report, "unknown")}  # fmt: skip
    return row


def is_none(row):
    return row["outcome"] in ("none", "shows too little")


def bars(rows):
    """What is demanded of all cases together. With nothing hidden `none` always comes true, so that P(none) is short by what is
    missing to 1; a withheld report states none."""
    stated = [row["p_none"] for row in rows if row["p_none"] is not None]
    return [
        rates("none, or says that the recording shows too little", map(is_none, rows), least=0.97),
        rates("... of these: shows too little", (row["outcome"] == "shows too little" for row in rows)),
        rates("unknown", (row["outcome"] == "unknown" for row in rows)),
        rates("a cause named with probability >= 0.5", (row["cause_probability"] >= NAMED for row in rows), most=0.01),
        rates("a cause named with probability >= 0.9", (row["cause_probability"] >= SURE for row in rows), most=0.0),
        rates("withheld for a fault that is not there", (row["outcome"] == "accused" for row in rows), most=0.0),
        rates("no report", (row["outcome"] == "failed" for row in rows), most=0.0),
        Bar("mean P(none), where stated (1 comes true)", mean(stated) if stated else None, len(stated), least=1 - SHORT_OF_TRUTH),
    ]


def strata(rows):
    """[(axis, value, its rows)], every value that was drawn."""
    for axis, values in AXES.items():
        for value in values:
            part = [row for row in rows if row[axis] == value]
            if part:
                yield axis, value, part


def reliability(rows, edges=(0.0, 0.2, 0.5, 0.8, 0.95, 1.0001)):
    """[(from, to, cases, mean P(none), share of them that end as none)]: what is said, and what is done with it."""
    found = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        part = [row for row in rows if row["p_none"] is not None and low <= row["p_none"] < high]
        if part:
            found.append((low, min(high, 1.0), len(part), mean(r["p_none"] for r in part), mean(is_none(r) for r in part)))
    return found


def by_stratum(rows):
    """[{figures}] of each stratum."""
    out = []
    for axis, value, part in strata(rows):
        stated = [row["p_none"] for row in part if row["p_none"] is not None]
        out.append({"axis": axis, "value": "exact" if axis == "bits" and not value else value, "cases": len(part),
                    "none": mean(map(is_none, part)), "too_little": mean(r["outcome"] == "shows too little" for r in part),
                    "unknown": mean(r["outcome"] == "unknown" for r in part),
                    "cause_50": mean(r["cause_probability"] >= NAMED for r in part),
                    "cause_90": mean(r["cause_probability"] >= SURE for r in part),
                    "p_none": mean(stated) if stated else None})  # fmt: skip
    return out
