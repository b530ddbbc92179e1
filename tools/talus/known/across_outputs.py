"""What effects found on one recording do to the others: a table for people, CSV and JSON for machines, and one page."""

import talus

from . import across_scores
from .across import NOT_THE_SAME
from .outputs import aligned, bars_table, told, write_all

MACHINE_COLUMNS = ["machine", "pairs", "with effects", "claimed", "lower", "lower anew", "error [%]", "with effects [%]", "anew [%]",
                   "with effects [%]"]  # fmt: skip
PAIR_COLUMNS = ["found on", "effects", "p", "told on", "error [%]", "with effects [%]", "anew [%]", "with effects [%]"]
ERRORS = ("plain", "effects", "plain_anew", "effects_anew")


def percent(value):
    return "-" if value is None else f"{value:.1f}"


def machine_lines(machines):
    return [[m["machine"] + (" (not the same)" if m["machine"] in NOT_THE_SAME else ""),
             *(str(m[name]) for name in ("pairs", "with_effects", "claimed", "lower", "lower_anew")),
             *(percent(m[name]) for name in ERRORS)] for m in machines]  # fmt: skip


def pair_lines(rows):
    return [[row["found_on"], row["listed"].replace(" ", ", ") or row["verdict"], f"{row['probability']:.2f}", row["recording"],
             *(percent(row[name]) for name in ERRORS)] for row in rows]  # fmt: skip


def page_of(rows, bars, machines):
    counted = across_scores.claimed(rows)
    lower = sum(row["lower"] for row in counted)
    page = talus.Page("Effects found on one recording, on the machine's other recordings",
                      f"Of {len(counted)} pairs with effects claimed at 0.9 or more, the error falls in {lower}.")  # fmt: skip
    bars_table(page, bars)
    page.heading("Machine by machine")
    some = [m for m in machines if m["effects"] is not None]
    page.bars("Error with effects over the error without, parameters of the first recording", "share",
              [[m["machine"], f"{m['with_effects']} pairs"] for m in some], [m["effects"] / m["plain"] for m in some],
              ["measured" if m["lower"] == m["with_effects"] else "accent" for m in some])  # fmt: skip
    page.table("Errors are medians over the pairs with effects", MACHINE_COLUMNS, machine_lines(machines), words=True)
    page.heading("Pair by pair")
    page.table("Error of the torque's RMS", PAIR_COLUMNS, pair_lines(rows), words=True)
    return page


def across(results, out):
    """Judges pairs of recordings, prints the tables, writes across.csv, .json and .html."""
    rows = across_scores.judged(results)
    bars, machines = across_scores.bars(rows), across_scores.by_machine(rows)
    report = {"schema": "talus-across/1", "bars": told(bars, MACHINE_COLUMNS, machine_lines(machines)), "machines": machines}
    print(aligned([PAIR_COLUMNS, *pair_lines(rows)]))
    write_all(out, "across", page_of(rows, bars, machines), rows, report)
