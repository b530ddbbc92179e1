"""What was counted of the gate: tables for people, gate.csv, gate.json and gate.html."""

import talus

from . import gate_scores
from .outputs import bars_table, percent, told, write_all

COLUMNS = ["", "cases", "plants", "named", "another grave one"]


def lines(groups):
    return [[g["value"], str(g["cases"]), str(g["plants"]), percent(g["named"]), percent(g["others"])] for g in groups]


def missed(spoiled):
    """Faults that were not named first, then those beside which another grave finding stands."""
    some = sorted((row for row in spoiled if not row["named"] or row["others"]), key=lambda row: (row["named"], row["kind"], row["case"]))
    return [[row["kind"], row["case"], row["plant"], row["expected"], row["said"] or "nothing"] for row in some]


def invented(sound):
    return [[row["case"], row["plant"], row["hidden"] or "nothing hidden", row["others"] or row["too_little"]] for row in sound
            if row["others"] or row["too_little"]]  # fmt: skip


def page_of(spoiled, sound, bars, kinds, plants):
    named = sum(row["named"] for row in spoiled)
    page = talus.Page("The gate of talus-gap on spoiled recordings",
                      f"Of {len(spoiled)} faults of {len(kinds)} kinds, {named} are named; {len(sound)} sets of recordings are sound.")  # fmt: skip
    bars_table(page, bars)
    page.heading("Kind by kind")
    page.bars("Named", "share of a kind's cases", [[g["value"], f"{g['cases']} cases"] for g in kinds], [g["named"] for g in kinds],
              ["measured" if g["named"] >= gate_scores.NAMED else "accent" for g in kinds])  # fmt: skip
    page.table("Kinds of faults", COLUMNS, lines(kinds))
    page.table("Plants and sets", COLUMNS, lines(plants))
    page.heading("Case by case")
    page.table("Not named, or not alone", ["fault", "case", "plant", "expected", "said"], missed(spoiled) or [["none", *[""] * 4]], words=True)
    page.table("Grave findings on sound recordings", ["case", "plant", "hidden", "finding"],
               invented(sound) or [["none", *[""] * 3]], words=True)  # fmt: skip
    return page


def gate(results, out):
    """Judges what the gate said, prints the tables, writes gate.csv, .json and .html."""
    judged = [gate_scores.judge(result) for result in results]
    spoiled, sound = [row for rows, _ in judged for row in rows], [row for _, row in judged]
    bars, kinds, plants = gate_scores.bars(spoiled, sound), gate_scores.by(spoiled, "kind"), gate_scores.by(spoiled, "plant")
    report = {"schema": "talus-gate/1", "bars": told(bars, COLUMNS, lines([*kinds, *plants])), "kinds": kinds, "plants": plants}
    for line in missed(spoiled):
        print(f"missed: {'; '.join(line)}")
    for line in invented(sound):
        print(f"on sound ones: {'; '.join(line)}")
    rows = [{"too_little": "", **row} for row in [*spoiled, *sound]]
    write_all(out, "gate", page_of(spoiled, sound, bars, kinds, plants), rows, report)
