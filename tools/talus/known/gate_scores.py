"""What came of the gate on spoiled and on sound recordings, counted. Nothing here reads a file."""

from statistics import mean

from ..blind.scores import Bar, rates
from .null_scores import TOO_LITTLE

NAMED = 0.95  # of the cases of a kind
FOLLOWS = {"coarse": {"too_little_motion"}}  # an encoder of few steps shows no speed


def entry(finding):
    return f"{finding['id']} {finding['column']}".strip()


def others(one):
    """Grave findings on a spoiled recording beside the right one, [words]."""
    right = (one["finding"], one["column"])
    return [entry(f) for f in one["findings"] if f["grave"] and (f["id"], f["column"]) != right
            and f["id"] not in FOLLOWS.get(one["finding"], ())]  # fmt: skip


def judge(result):
    """[row] of a case's faults, and one row of the case as it is."""
    base = {"case": result["case"], **result["setting"]}
    rows = []
    for one in result["spoiled"]:
        found = any((f["id"], f["column"]) == (one["finding"], one["column"]) for f in one["findings"])
        rows.append({**base, "kind": one["kind"], "expected": f"{one['finding']} {one['column']}".strip(), "named": found, "others": ", ".join(others(one)),
                     "said": ", ".join(entry(f) for f in one["findings"])})  # fmt: skip
    return rows, sound_row(base, result["sound"])


def entry_of_sound(findings, little):
    return ", ".join(entry(f) for f in findings if f["grave"] and (f["id"] in TOO_LITTLE) == little)


def sound_row(base, findings):
    """`invented`: a fault that is not there; that a recording shows too little is none."""
    return {**base, "kind": "", "expected": "", "named": None, "others": entry_of_sound(findings, False),
            "said": ", ".join(entry(f) for f in findings), "too_little": entry_of_sound(findings, True)}  # fmt: skip


def by(rows, axis):
    """[{figures}] of each value of an axis, in order of their first case."""
    out = []
    for value in dict.fromkeys(row[axis] for row in rows):
        part = [row for row in rows if row[axis] == value]
        out.append({"axis": axis, "value": value, "cases": len(part), "plants": len({row["plant"] for row in part}),
                    "named": mean(row["named"] for row in part), "others": mean(bool(row["others"]) for row in part)})  # fmt: skip
    return out


def bars(spoiled, sound):
    """What is demanded: each kind found by name, no other grave finding beside it, and none on what is sound."""
    kinds = by(spoiled, "kind")
    worst = min(kinds, key=lambda kind: kind["named"], default=None)
    return [
        rates("kinds of faults that are named in 95 % of their cases", (kind["named"] >= NAMED for kind in kinds), least=1.0),
        Bar(f"... the worst kind: {worst['value']}" if worst else "... the worst kind", worst and worst["named"],
            worst["cases"] if worst else 0, least=NAMED),
        rates("faults that are named", (row["named"] for row in spoiled), least=NAMED),
        rates("faults beside which another grave finding stands", (bool(row["others"]) for row in spoiled), most=1 - NAMED),
        rates("sound recordings with a grave finding", (bool(row["others"]) for row in sound), most=0.0),
        rates("sound recordings that show too little", (bool(row["too_little"]) for row in sound)),
    ]  # fmt: skip
