"""What is right: verdicts against labels, bar by bar. Nothing here reads a file."""

from statistics import mean, median

from .effects import SHOWS

NO_CAUSE = ("none", "unknown")
CLOSABLE = 1.1  # identified error over noise from which there is something to close


def cause(entry):
    return entry["effect"], entry["joint"]


def exact_answers(label):
    """Verdicts that are right."""
    if label["kind"] in ("none", "unknown"):
        right = {(label["kind"], "none")}
    else:
        right = {cause(effect) for effect in label["effects"]}
    if not label["observable"]:
        right.add(("none", "none"))
    return right


def group_answers(label):
    """Verdicts that are right up to what such recordings cannot tell apart."""
    return exact_answers(label) | {tuple(alias) for effect in label["effects"] for alias in effect["alias_with"]}


def pooled(rms, floor):
    """Sum over joints of the squared error over the noise's."""
    return sum((rms[joint] / floor[joint]) ** 2 for joint in floor)


def floor_of(label, unseen):
    """What the best model leaves of the unseen recording, for each joint: the noise's share, and all. In the wide protocol the
    recording without effect holds the noise already."""
    whole = label["reconstruction"]
    if "protocol" in label:
        return whole, whole
    noise = {j: unseen["unit_noise"][j] * label["noise"][f"{j}_torque_Nm"] for j in whole}
    return noise, {j: (noise[j] ** 2 + whole[j] ** 2) ** 0.5 for j in noise}


def shrinkage(label, result):
    """What was closed of what can be closed on the unseen recording: pooled and for each joint; None without any."""
    unseen = result.get("unseen")
    if not unseen:
        return None
    noise, floor = floor_of(label, unseen)
    before, after = (pooled(unseen[name], floor) for name in ("identified", "extended"))
    least = len(floor)
    out = {"pooled": (before - after) / (before - least) if before > least * CLOSABLE**2 else None, "joints": {},
           "before": before, "after": after}  # fmt: skip
    for joint, least in floor.items():
        b, a = unseen["identified"][joint], unseen["extended"][joint]
        part = (b**2 - a**2) / (b**2 - least**2) if b > CLOSABLE * least else None
        out["joints"][joint] = {"identified": b, "extended": a, "noise": noise[joint], "floor": least, "closed": part}
    return out


def claim(gap):
    """The closed fraction that is claimed of a joint; 0 where by its own figures there is nothing to close."""
    return gap["closed_fraction"] if gap["identified_rms"] > CLOSABLE * gap["noise_floor_rms"] else 0.0


def named_wrongly(report, group):
    """Is any effect, first or further, named with a probability of 0.5 or more that is not there?"""
    said = [report["verdict"], *report["effects"]]
    return any(e["effect"] not in (*NO_CAUSE, "failed") and e.get("probability", 0.0) >= 0.5 and cause(e) not in group for e in said)


def confusable_with(report, label):
    """Does the report itself say that its verdict may be the truth under another name?"""
    groups = [set(g["effects"]) for g in report["confusable"] if report["verdict"]["effect"] in g["effects"]]
    return any(effect["effect"] in group for group in groups for effect in label["effects"])


def covered(report, shrunk):
    """For each joint of which an interval is claimed and something could be closed: does the interval hold what was closed?
    By chance of the noise that can be a little more than all, which no one claims; and no interval goes below -1."""
    out = []
    for joint, part in (shrunk or {"joints": {}})["joints"].items():
        interval = report["gap"].get(joint, {}).get("closed_interval")
        if interval and part["closed"] is not None and report["effects"]:
            out.append(interval[0] <= min(max(part["closed"], -1.0), 1.0) <= interval[1])
    return out


def judge(label, result):
    """All that is counted of one case."""
    report = result["report"]
    if report is None:
        report = {
            "verdict": {"effect": "failed", "joint": "none", "probability": 0.0},
            "alternatives": [],
            "effects": [],
            "gap": {},
            "motion": {},
            "where": [],
            "confusable": [],
        }
    verdict = report["verdict"]
    said, named = cause(verdict), verdict["effect"] not in (*NO_CAUSE, "failed")
    listed = [cause(effect) for effect in report["effects"]]
    group, joints = group_answers(label), {effect["joint"] for effect in label["effects"]}
    first = report["where"][0] if report["where"] else None
    groups = [g for g in report["confusable"] if verdict["effect"] in g["effects"]]
    shrunk = shrinkage(label, result)
    return {
        "case": label["case"],
        "kind": label["kind"],
        "observable": label["observable"],
        "verdict": list(said),
        "probability": verdict["probability"],
        "named": named,
        "exact": said in exact_answers(label),
        "group": said in group,
        "joint_right": verdict["joint"] in joints,
        "wrong": named and verdict["probability"] >= 0.5 and said not in group,
        "wrong_strict": named and verdict["probability"] >= 0.5 and said not in exact_answers(label),
        "confusable": max((len(g["effects"]) - 1 for g in groups), default=0),
        "found": [c in listed or c == said for c in map(cause, label["effects"])],
        "found_group": [
            any(c in {cause(e), *map(tuple, e["alias_with"])} for c in {*listed, said}) for e in label["effects"]
        ],
        "invented": len([c for c in listed if c not in group]) > 0 or len(listed) > max(2, len(label["effects"])),
        "where_right": bool(first) and _where_right(first, label["effects"]),
        "wrong_listed": named_wrongly(report, group),
        "group_reported": said in group or confusable_with(report, label),
        "covered": covered(report, shrunk),
        "findings": [f["id"] for f in report.get("findings", []) if f.get("grave")],
        "protocol": label.get("protocol"),
        "shrinkage": shrunk,
        "claimed": {j: claim(g) for j, g in report["gap"].items()},
        "each_observable": [effect["observable"] for effect in label["effects"]],
        "motion": _motion(report["motion"], joints),
        "listed": [list(c) for c in listed],
        "processor_s": result["processor_s"],
        "wall_s": result["wall_s"],
        "peak_MB": result["peak_MB"],
        "truth": [list(cause(effect)) for effect in label["effects"]],
        "hidden": (label["hidden"] or {}).get("form"),
        "detectability": label["detectability"],
    }


def _where_right(entry, effects):
    return any(
        entry["coordinate"] in SHOWS[e["effect"]] and (e["joint"] == "base" or entry["joint"] in (e["joint"], "base"))
        for e in effects
    )


def _motion(motion, joints):
    """Whether the motion's gap shrank at the joints of what was hidden; None where none is reported."""
    own = [m for joint, m in motion.items() if joint in joints or "base" in joints]
    own = [m["extended_rms"] / m["identified_rms"] for m in own if m.get("identified_rms")]
    return sum(x**2 for x in own) < len(own) if own else None


def share(flags):
    flags = list(flags)
    return (sum(flags) / len(flags) if flags else None), len(flags)


def quantile(values, part):
    """Linear between order statistics."""
    values = sorted(values)
    at = part * (len(values) - 1)
    low = int(at)
    return values[low] + (at - low) * (values[min(low + 1, len(values) - 1)] - values[low])


class Bar:
    """One line of the table: what, figure, number of cases, and what is demanded."""

    def __init__(self, name, value, count, least=None, most=None):
        self.name, self.value, self.count, self.least, self.most = name, value, count, least, most

    @property
    def met(self):
        if self.value is None or (self.least is None and self.most is None):
            return None
        return (self.least is None or self.value >= self.least) and (self.most is None or self.value <= self.most)

    def row(self):
        return {
            "name": self.name,
            "value": self.value,
            "cases": self.count,
            "least": self.least,
            "most": self.most,
            "met": self.met,
        }


def rates(name, flags, **demand):
    return Bar(name, *share(flags), **demand)


def verdict_bars(cases):
    singles = [c for c in cases if c["kind"] == "single" and c["observable"]]
    named = [c for c in cases if c["named"]]
    unknown = [c for c in cases if c["kind"] == "unknown"]
    return [
        rates("wrong cause named with probability >= 0.5", (c["wrong"] for c in cases), most=0.03),
        rates("the same, with an alias counted as wrong", (c["wrong_strict"] for c in cases)),
        rates("the same, with further effects counted like the first", (c["wrong_listed"] for c in cases)),
        rates(
            "none said where it is true", (c["verdict"][0] == "none" for c in cases if c["kind"] == "none"), least=0.95
        ),
        rates("unknown said where it is true", (c["exact"] for c in unknown), least=0.85),
        rates("single, observable: effect and joint", (c["exact"] for c in singles), least=0.92),
        rates("single, observable: up to the alias group", (c["group"] for c in singles), least=0.96),
        rates("single, observable: up to what the report calls confusable", (c["group_reported"] for c in singles)),
        rates("single, observable: joint", (c["joint_right"] for c in singles), least=0.99),
        rates(
            "single, too weak: none or the effect",
            (c["group"] for c in cases if c["kind"] == "single" and not c["observable"]),
        ),
        Bar(
            "confusable beside the named, most", max((c["confusable"] for c in named), default=None), len(named), most=3
        ),
        Bar(
            "confusable beside the named, mean",
            mean(c["confusable"] for c in named) if named else None,
            len(named),
            most=1.5,
        ),
    ]


def pair_bars(cases):
    pairs = [c for c in cases if c["kind"] == "pair" and c["observable"]]
    both = [c for c in pairs if all(c["each_observable"])]
    return [
        rates("pair: at least one right (alias counts)", (any(c["found_group"]) for c in pairs), least=0.97),
        rates("pair, both observable: both right (alias counts)", (all(c["found_group"]) for c in both), least=0.65),
        rates("pair, both observable: both exactly right", (all(c["found"]) for c in both)),
        rates("pair: no third invented", (not c["invented"] for c in pairs), least=0.90),
    ]


def closing_bars(cases):
    known = [c for c in cases if c["kind"] in ("single", "pair") and c["shrinkage"]]
    closed = [c["shrinkage"]["pooled"] for c in known if c["shrinkage"]["pooled"] is not None]
    off, empty = [], []
    for c in cases:
        for joint, part in (c["shrinkage"] or {"joints": {}})["joints"].items():
            claimed = c["claimed"].get(joint, 0.0)
            if part["closed"] is not None and c["listed"]:
                off.append(abs(claimed - part["closed"]))
            empty.append(claimed > 0.2 and part["closed"] is not None and part["closed"] < 0.05)
    motion = [c["motion"] for c in known if c["motion"] is not None and c["shrinkage"]["pooled"] is not None]
    return [
        Bar("closed on the unseen recording, median", median(closed) if closed else None, len(closed), least=0.97),
        Bar(
            "closed on the unseen recording, worst tenth",
            quantile(closed, 0.1) if closed else None,
            len(closed),
            least=0.80,
        ),
        Bar("claimed closed_fraction off by, median", median(off) if off else None, len(off), most=0.05),
        rates("claimed interval holds what was closed", (flag for c in known for flag in c["covered"])),
        rates("closing claimed where none is closed", empty, most=0.0),
        rates("motion's gap shrinks", motion, least=0.90),
    ]


def other_bars(cases):
    singles = [c for c in cases if c["kind"] == "single" and c["observable"]]
    scored = [(c["probability"], c["group"]) for c in cases]
    time, memory = [c["processor_s"] for c in cases], [c["peak_MB"] for c in cases]
    return [
        rates("first entry of where right", (c["where_right"] for c in singles), least=0.85),
        Bar("Brier score", mean((p - right) ** 2 for p, right in scored) if scored else None, len(scored), most=0.08),
        Bar("expected calibration error", calibration_error(cases), len(scored)),
        Bar("processor time a case, median [s]", median(time) if time else None, len(time), most=5.0),
        Bar("processor time a case, worst [s]", max(time, default=None), len(time)),
        Bar("peak memory, worst [MB]", max(memory, default=None), len(memory), most=200.0),
    ]


def bars(cases, followed=()):
    """The whole table; `followed` are the proposed experiments that were made."""
    separated = (bool(one.get("separated")) for one in followed)
    next_bar = rates("proposed experiment separates what was open", separated, least=0.70)
    return verdict_bars(cases) + pair_bars(cases) + closing_bars(cases) + [next_bar] + other_bars(cases)


def confusion(cases):
    """Truth (single effects at a joint's name, and the kinds) against verdicts: {truth: {verdict: count}}."""
    table = {}
    for c in cases:
        truth = c["truth"][0][0] if c["kind"] == "single" else c["kind"]
        if c["kind"] == "single" and not c["observable"]:
            truth = "too weak"
        said = (
            c["verdict"][0]
            if c["joint_right"] or c["verdict"][0] in NO_CAUSE or c["kind"] != "single"
            else "other joint"
        )
        row = table.setdefault(truth, {})
        row[said] = row.get(said, 0) + 1
    return table


def by_effect(cases):
    """For each effect and joint of the observable singles, and each kind of unknown: cases, how many exact, up to the
    alias group, the median of what was closed, and what was said instead."""
    groups = {}
    for c in cases:
        if c["kind"] == "single" and c["observable"]:
            groups.setdefault(" ".join(c["truth"][0]), []).append(c)
        elif c["kind"] == "unknown":
            groups.setdefault(f"unknown: {c['hidden']}", []).append(c)
    rows = []
    for name, part in sorted(groups.items(), key=lambda item: (item[0].startswith("unknown"), item[0])):
        closed = [c["shrinkage"]["pooled"] for c in part if c["shrinkage"] and c["shrinkage"]["pooled"] is not None]
        instead = sorted(" ".join(c["verdict"]) for c in part if not c["exact"])
        rows.append({"hidden": name, "cases": len(part), "exact": sum(c["exact"] for c in part),
                     "group": sum(c["group"] for c in part), "closed": median(closed) if closed else None,
                     "instead": instead})  # fmt: skip
    return rows


def reliability(cases, edges=(0.0, 0.3, 0.5, 0.7, 0.85, 0.95, 0.99, 1.0001)):
    """For each range of probability: how many verdicts, their mean probability, and how many were right."""
    rows = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        part = [c for c in cases if low <= c["probability"] < high]
        if part:
            rows.append(
                {
                    "from": low,
                    "to": min(high, 1.0),
                    "cases": len(part),
                    "said": mean(c["probability"] for c in part),
                    "right": mean(bool(c["group"]) for c in part),
                }
            )
    return rows


def calibration_error(cases):
    """Mean distance of said probability and share of right verdicts over the table of reliability, weighted by its cases."""
    rows = reliability(cases)
    return sum(r["cases"] * abs(r["said"] - r["right"]) for r in rows) / len(cases) if cases else None
