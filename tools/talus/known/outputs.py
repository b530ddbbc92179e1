"""What was counted: a table for people, CSV and JSON for machines, and one page."""

import csv
import io
import json
from pathlib import Path

import talus

from ..blind.unseal import demand, figure, finite, words
from . import camera_scores, null_scores, running, spike_scores

MET = {True: "met", False: "not met", None: ""}


def percent(value):
    return "-" if value is None else f"{100 * value:.0f} %"


def as_csv(rows):
    text = io.StringIO()
    table = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    table.writeheader()
    table.writerows({name: "" if value is None else value for name, value in row.items()} for row in rows)
    return text.getvalue()


def aligned(table):
    """A table of words for people, columns as wide as they must be; the first column stands left."""
    widths = [max(len(line[k]) for line in table) for k in range(len(table[0]))]
    lines = [[line[0].ljust(widths[0]), *(cell.rjust(w) for cell, w in zip(line[1:], widths[1:], strict=True))] for line in table]
    return "\n".join("  ".join(line).rstrip() for line in lines)


def bars_table(page, bars):
    page.table("Bars", ["what", "figure", "bar", "cases", ""],
               [[b.name, figure(b.value), demand(b), str(b.count), MET[b.met]] for b in bars])  # fmt: skip


def told(bars, columns, lines):
    """The bars and a table, printed; the bars as the report has them."""
    print(words(bars))
    print(aligned([columns, *lines]))
    return [b.row() for b in bars]


def write_all(out, stem, page, rows, report):
    """STEM.csv, STEM.json and STEM.html in a folder."""
    out = Path(out)
    running.write(out / f"{stem}.csv", as_csv(rows))
    running.write(out / f"{stem}.json", json.dumps(finite({**report, "cases": rows}), indent=1) + "\n")
    page.write(out / f"{stem}.html.tmp")
    (out / f"{stem}.html.tmp").replace(out / f"{stem}.html")
    print(f"written: {', '.join(str(out / f'{stem}.{kind}') for kind in ('csv', 'json', 'html'))}")


# ---- benches without any effect ------------------------------------------------------

NULL_COLUMNS = ["", "cases", "none", "too little", "unknown", "cause >= 0.5", "cause >= 0.9", "mean P(none)"]


def null_lines(strata):
    return [[f"{s['axis'].replace('_', ' ')} {s['value']}", str(s["cases"]), percent(s["none"]), percent(s["too_little"]),
             percent(s["unknown"]), percent(s["cause_50"]), percent(s["cause_90"]), figure(s["p_none"])] for s in strata]  # fmt: skip


def wrong_lines(rows):
    """What did not end as `none`, the surest names first."""
    wrong = sorted((r for r in rows if not null_scores.is_none(r)), key=lambda r: -r["cause_probability"])
    return [[r["case"], r["outcome"], r["verdict"], f"{r['probability']:.2f}", r["cause"], f"{r['cause_probability']:.2f}",
             r["finding"]] for r in wrong]  # fmt: skip


def null_page(rows, bars, strata):
    right = sum(map(null_scores.is_none, rows))
    page = talus.Page("talus-gap where nothing is hidden",
                      f"Of {len(rows)} benches without any effect, {right} end as none.")  # fmt: skip
    bars_table(page, bars)
    page.heading("Where")
    page.bars("Share that ends as none (or shows too little)", "share",
              [[f"{s['axis'].replace('_', ' ')} {s['value']}", f"{s['cases']} cases"] for s in strata], [s["none"] for s in strata],
              ["measured" if s["none"] >= 0.97 else "accent" for s in strata])  # fmt: skip
    page.table("Plant, rate, encoder, excitation, length", NULL_COLUMNS, null_lines(strata))
    page.heading("How sure")
    page.table("P(none) as stated, and what ends as none; none is true of all", ["P(none)", "cases", "mean", "end as none"],
               [[f"{low:g} to {high:g}", str(n), f"{said:.3f}", percent(right)]
                for low, high, n, said, right in null_scores.reliability(rows)] or [["none stated", "0", "", ""]])  # fmt: skip
    page.heading("Case by case")
    page.table("What did not end as none", ["case", "outcome", "verdict", "probability", "cause", "its probability", "finding"],
               wrong_lines(rows) or [["all did", *[""] * 6]], words=True)  # fmt: skip
    return page


def nulls(results, out):
    """Judges benches without any effect, prints the tables, writes nulls.csv, .json and .html."""
    rows = [null_scores.judge(result) for result in results]
    bars, strata = null_scores.bars(rows), null_scores.by_stratum(rows)
    report = {"schema": "talus-nulls/1", "bars": told(bars, NULL_COLUMNS, null_lines(strata)), "strata": strata}
    for line in wrong_lines(rows):
        print(f"not none: {' '.join(cell for cell in line if cell)}")
    write_all(out, "nulls", null_page(rows, bars, strata), rows, report)


# ---- real recordings with an effect added ------------------------------------------------

SPIKE_COLUMNS = ["", "cases", "not in control", "of these named", "first name wrong", "a further one"]


def spike_lines(groups):
    return [[f"{g['axis']} {g['value']}", str(g["cases"]), str(g["new"]), percent(g["named"]), percent(g["first_wrong"]),
             percent(g["further"])] for g in groups]  # fmt: skip


def missed_lines(rows):
    """Wrong names first, then what should have been named."""
    told = [row for row in rows if row["outcome"] == "judged"]
    missed = {row["case"] for row in spike_scores.seen(spike_scores.new(rows)) if not row["named"]}
    some = [row for row in told if row["first_wrong"] or row["further"] or row["case"] in missed]
    some.sort(key=lambda row: (not row["first_wrong"], not row["further"], row["case"]))
    return [[row["case"], row["effect"], f"{row['verdict']} {row['probability']:.2f}", "wrong" if row["first_wrong"] else "",
             row["further"], "missed" if row["case"] in missed else ""] for row in some]  # fmt: skip


def control_lines(results):
    """What the recordings say as they are."""
    lines = []
    for result in (r for r in results if not r["setting"]["form"]):
        listed = result["report"]["effects"] if result["report"] else []
        lines.append([result["setting"]["machine"], running.said(result),
                      ", ".join(f"{e['effect']} {e['probability']:.2f}" for e in listed) or "none"])  # fmt: skip
    return lines


def spike_page(rows, bars, groups, results):
    told = spike_scores.seen(spike_scores.new(rows))
    named = sum(row["named"] for row in told)
    page = talus.Page("talus-gap on effects added to real recordings",
                      f"Of {len(told)} effects that leave at least 5 % of the torque, {named} are named.")  # fmt: skip
    bars_table(page, bars)
    page.heading("How large")
    sizes = [g for g in groups if g["axis"] == "leaves" and g["named"] is not None]
    page.bars("Named, by how much of the torque the effect leaves beyond the plain model", "share named",
              [[f"leaves {g['value']}", f"{g['new']} cases"] for g in sizes], [g["named"] for g in sizes],
              ["measured"] * len(sizes))  # fmt: skip
    page.table("By size, effect and set", SPIKE_COLUMNS, spike_lines(groups) or [["none", *[""] * 5]])
    page.heading("Case by case")
    page.table("Wrong or missed", ["spike", "effect", "verdict", "first name", "further", ""],
               missed_lines(rows) or [["none", *[""] * 5]], words=True)  # fmt: skip
    page.table("Controls: the recordings as they are", ["recording", "verdict", "effects"], control_lines(results), words=True)
    return page


def spikes(results, out):
    """Judges spikes, prints the tables, writes spike.csv, .json and .html."""
    rows = spike_scores.judged(results)
    bars, groups = spike_scores.bars(rows), spike_scores.by_group(rows)
    report = {"schema": "talus-spike/1", "bars": told(bars, SPIKE_COLUMNS, spike_lines(groups)), "groups": groups}
    for machine, verdict, effects in control_lines(results):
        print(f"control: {machine} {verdict}; effects: {effects}")
    for line in missed_lines(rows):
        print(f"wrong or missed: {' '.join(cell for cell in line if cell)}")
    controls = [dict(zip(("recording", "verdict", "effects"), line, strict=True)) for line in control_lines(results)]
    write_all(out, "spike", spike_page(rows, bars, groups, results), rows, {**report, "controls": controls})


# ---- what a camera adds ------------------------------------------------------------------

CAMERA_COLUMNS = ["cause", "cases", "exact without", "... and alone", "exact with", "... and alone"]


def camera_lines(groups):
    return [[str(value) for value in group.values()] for group in groups]


def camera_cases(rows):
    return [[row["case"], row["joint"], row["size"], row["without"], row["with"], f"{row['camera_less_knee_mrad']:+.2f}"] for row in rows]


def camera_page(rows, bars, groups):
    parted = sum(row["alone_with"] for row in rows)
    page = talus.Page("What a camera tells talus-gap",
                      f"Of {len(rows)} benches, {parted} causes are named exactly and alone with the camera's angles.")  # fmt: skip
    bars_table(page, bars)
    page.table("Cause by cause", CAMERA_COLUMNS, camera_lines(groups))
    page.table("Case by case; the last column is the mean of camera less knee encoder [mrad]",
               ["case", "joint", "size", "without", "with", "camera"], camera_cases(rows), words=True)  # fmt: skip
    return page


def camera(results, out):
    """Judges benches with and without a camera, prints the tables, writes camera.csv, .json and .html."""
    rows = [camera_scores.judge(result) for result in results]
    bars, groups = camera_scores.bars(rows), camera_scores.by_cause(rows)
    report = {"schema": "talus-camera/1", "bars": told(bars, CAMERA_COLUMNS, camera_lines(groups)), "causes": groups}
    print(aligned([["case", "joint", "size", "without", "with", "camera mrad"], *camera_cases(rows)]))
    write_all(out, "camera", camera_page(rows, bars, groups), rows, report)
