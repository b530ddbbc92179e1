"""What effects found on one recording do to the others: a table for people, CSV and JSON for machines, and one page."""

import talus

from ..diagnosis import words
from . import across_scores
from .across import NOT_THE_SAME
from .outputs import aligned, bars_table, told, write_all

MACHINE_COLUMNS = ["machine", "pairs", "with effects", "claimed", "lower as saved", "lower anew", "error as saved [%]", "error anew [%]"]
FOUND_COLUMNS = ["recording", "probability", "effects"]
PAIR_COLUMNS = ["found on", "tested on", "error as saved [%]", "error anew [%]"]
MEANING = ("An error is that of the torque (RMS), on a recording that neither the effects nor the choice have seen: without the effects → with them. "
           "As saved: all parameters are those of the recording that the effects were found on. Anew: inertia, gravity and plain friction are identified "
           "on the other recording, the effects stay as they were found. Claimed: the first cause has a probability of 0.9 or more.")  # fmt: skip
NOT_COUNTED = "Not counted are pairs whose machine was not the same in both recordings (docs/across.md)."


def change(row, before, after):
    """Of an error in percent."""
    return "-" if row[before] is None else f"{row[before]:.1f} → {row[after]:.1f}"


def changes(row):
    return [change(row, "plain", "effects"), change(row, "plain_anew", "effects_anew")]


def machine_lines(machines):
    return [[m["machine"] + (" (not counted)" if m["machine"] in NOT_THE_SAME else ""),
             *(str(m[name]) for name in ("pairs", "with_effects", "claimed", "lower", "lower_anew")), *changes(m)] for m in machines]  # fmt: skip


def found_lines(rows):
    """Each recording once: its verdict's probability, and the effects."""
    once = {row["found_on"]: row for row in rows}
    return [[name, words.share(row["probability"]), row["listed"].replace(" ", ", ") or row["verdict"]] for name, row in once.items()]


def pair_lines(rows):
    return [[row["found_on"], row["recording"], *changes(row)] for row in rows]


def page_of(rows, bars, machines):
    counted = across_scores.claimed(rows)
    lower = sum(row["lower"] for row in counted)
    page = talus.Page("Effects found on one recording, on the machine's other recordings",
                      f"Of {len(counted)} pairs with effects claimed at 0.9 or more, the error falls in {lower}.")  # fmt: skip
    bars_table(page, bars)
    page.paragraph(MEANING)
    page.heading("Machine by machine")
    some = [m for m in machines if m["effects"] is not None]
    said = ["not counted" if m["machine"] in NOT_THE_SAME else f"pairs: {m['with_effects']}" for m in some]
    page.bars("Error with effects over the error without, as saved; blue: not lower in every pair", "share",
              [[m["machine"], text] for m, text in zip(some, said, strict=True)], [m["effects"] / m["plain"] for m in some],
              ["measured" if m["lower"] == m["with_effects"] else "accent" for m in some])  # fmt: skip
    page.table("Errors are medians over the pairs with effects", MACHINE_COLUMNS, machine_lines(machines), words=True)
    page.paragraph(NOT_COUNTED)
    page.heading("Pair by pair")
    page.table("What was found; the probability is that of the first effect", FOUND_COLUMNS, found_lines(rows), words=True)
    page.table("Error without → with the effects", PAIR_COLUMNS, pair_lines(rows), words=True)
    return page


def across(results, out):
    """Judges pairs of recordings, prints the tables, writes across.csv, .json and .html."""
    rows = across_scores.judged(results)
    if not rows:
        raise RuntimeError("no recording has a report")
    bars, machines = across_scores.bars(rows, results), across_scores.by_machine(rows)
    report = {"schema": "talus-across/1", "bars": told(bars, MACHINE_COLUMNS, machine_lines(machines)), "machines": machines}
    print(aligned([FOUND_COLUMNS, *found_lines(rows)]), aligned([PAIR_COLUMNS, *pair_lines(rows)]), sep="\n")
    write_all(out, "across", page_of(rows, bars, machines), rows, report)
