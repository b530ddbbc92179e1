"""Opens the seal after the last verdict, and writes what came of it: words, JSON, and one page."""

import hashlib
import json
import math
from pathlib import Path

import talus

from . import running, scores, strata


class Sealed(Exception):
    """The seal cannot be opened: why."""


def labels(folder):
    """The labels, if they are those whose checksum was printed, and every case has its verdict."""
    text = (folder / "sealed" / "labels.json").read_bytes()
    expected = (folder / "seal.sha256").read_text().split()[0]
    found = hashlib.sha256(text).hexdigest()
    if found != expected:
        raise Sealed(f"{folder}/sealed/labels.json: its checksum is {found}, but {expected} was sealed")
    cases = json.loads(text)["cases"]
    missing = [c["case"] for c in cases if not (folder / "results" / f"{c['case']}.json").exists()]
    if missing:
        raise Sealed(f"{folder}: {len(missing)} cases have no verdict yet ({missing[0]}, ...): run first")
    return cases, found


def read_followed(folder):
    """What became of the proposed experiments, where `next` has run."""
    path = folder / "results" / "next.json"
    return json.loads(path.read_text()) if path.exists() else []


def read(folders):
    """Every case judged, and the seals' checksums."""
    cases, seals, versions, followed = [], {}, set(), []
    for folder in folders:
        answers, seals[folder.name] = labels(folder)
        for label in answers:
            recording = folder / "sealed" / f"{label['case']}.csv.gz"
            result = json.loads((folder / "results" / f"{label['case']}.json").read_text())
            if result.get("unseen"):  # else nothing is compared with it
                label["reconstruction"] = running.reconstruction(recording.with_name(f"{label['case']}.yaml"), recording)
            versions.add(result["version"])
            case = scores.judge(label, result)
            case["case"] = f"{folder.name}/{label['case']}"
            case["size"] = "; ".join(
                e["size"] for e in label["effects"] or ([label["hidden"]] if label["hidden"] else [])
            )
            cases.append(case)
        followed += read_followed(folder)
    return cases, seals, sorted(versions), followed


def figure(value):
    return "-" if value is None else f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"


def demand(bar):
    if bar.least is not None:
        return f">= {bar.least:g}"
    return f"<= {bar.most:g}" if bar.most is not None else ""


def words(found):
    """The table for people."""
    lines = [f"{'':58} {'figure':>8} {'bar':>8} {'cases':>6}"]
    for bar in found:
        mark = {True: "  met", False: "  NOT met", None: ""}[bar.met]
        lines.append(f"{bar.name:58} {figure(bar.value):>8} {demand(bar):>8} {bar.count:>6}{mark}")
    return "\n".join(lines)


def confusion_table(page, cases):
    table = scores.confusion(cases)
    said = sorted({name for row in table.values() for name in row}, key=lambda n: (n in scores.NO_CAUSE, n))
    rows = [[truth, *(str(table[truth].get(name, "")) for name in said)] for truth in sorted(table)]
    page.table(
        "Verdicts (across) against what was hidden (down); single effects, and the kinds", ["hidden", *said], rows
    )


def effect_table(page, cases):
    """Effect by effect."""
    rows = [
        [r["hidden"], str(r["cases"]), str(r["exact"]), str(r["group"]), figure(r["closed"]), ", ".join(r["instead"])]
        for r in scores.by_effect(cases)
    ]
    page.table(
        "Single effects that can be seen, and kinds of unknown",
        ["hidden", "cases", "exact", "alias group", "closed, median", "said instead"],
        rows or [["none", *[""] * 5]],
    )


def closing_charts(page, cases):
    """Closed of what can be closed: true against claimed, cases in order."""
    pairs = []
    for c in cases:
        for joint, part in (c["shrinkage"] or {"joints": {}})["joints"].items():
            if part["closed"] is not None and c["kind"] in ("single", "pair"):
                pairs.append((part["closed"], c["claimed"].get(joint, 0.0)))
    pairs.sort()
    if pairs:
        x = [(i + 0.5) / len(pairs) for i in range(len(pairs))]
        page.chart(
            "How far the gap closes on a recording that was never given",
            "share of the cases' joints",
            "closed fraction",
            [
                ("claimed", "predicted", x, [p[1] for p in pairs]),
                ("true", "measured", x, [max(p[0], -1.0) for p in pairs]),
            ],
        )


def missed_table(page, cases):
    rows = [
        [
            c["case"],
            c["kind"] + (f" ({c['hidden']})" if c["hidden"] else ""),
            ", ".join(f"{e} {j}" for e, j in c["truth"]),
            c["size"],
            f"{c['verdict'][0]} {c['verdict'][1]}",
            f"{c['probability']:.2f}",
            f"{c['detectability']:.0f}",
        ]
        for c in cases
        if not c["group"]
    ]
    page.table(
        "Every verdict that was not right",
        ["case", "kind", "hidden", "size", "verdict", "probability", "detectability"],
        rows or [["none", *[""] * 6]],
    )


def strata_tables(page, rows):
    """One table for each axis."""
    names = list(rows[0]["figures"])
    for axis in dict.fromkeys(row["axis"] for row in rows):
        page.table(
            f"By {axis}" if axis != "all" else "All",
            ["", "cases", *names],
            [[r["stratum"], str(r["cases"]), *(strata.shown(r["figures"][n]) for n in names)] for r in rows if r["axis"] == axis],
        )


def write_page(path, cases, found, seals, versions, rows):
    right = sum(bool(c["group"]) for c in cases)
    met = [bar.met for bar in found if bar.met is not None]
    page = talus.Page(
        "talus-gap on withheld effects",
        f"Of {len(cases)} benches, {right} got the right verdict; {sum(met)} of {len(met)} bars are met.",
    )
    page.table(
        "Bars",
        ["what", "figure", "bar", "cases", ""],
        [
            [b.name, figure(b.value), demand(b), str(b.count), {True: "met", False: "not met", None: ""}[b.met]]
            for b in found
        ],
    )
    page.heading("Which")
    confusion_table(page, cases)
    effect_table(page, cases)
    if rows:
        page.heading("On which bench")
        page.paragraph("Rates with the number of cases that each is of: wrong is an effect named with a probability of 0.5 or more that is not there.")
        strata_tables(page, rows)
    page.heading("How far")
    closing_charts(page, cases)
    page.heading("How sure")
    rows = scores.reliability(cases)
    page.chart(
        "Verdicts that were right, against the probability they were given",
        "mean probability said",
        "share right",
        [
            ("as it should be", "noise", [0.0, 1.0], [0.0, 1.0]),
            ("verdicts", "measured", [r["said"] for r in rows], [r["right"] for r in rows]),
        ],
    )
    page.table(
        "Reliability",
        ["probability", "cases", "mean said", "right"],
        [[f"{r['from']:g} to {r['to']:g}", str(r["cases"]), f"{r['said']:.3f}", f"{r['right']:.3f}"] for r in rows],
    )
    page.heading("Case by case")
    missed_table(page, cases)
    for name, checksum in seals.items():
        page.paragraph(f"Labels of {name}: SHA-256 {checksum}, printed before the diagnosis began.")
    page.paragraph(f"Versions of the diagnosis among the verdicts: {', '.join(versions)}.")
    page.write(path)


def finite(value):
    """JSON has no NaN."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list):
        return [finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def open_seal(folders, out):
    """Judges all cases; prints the table, writes blind.json and blind.html into `out`."""
    cases, seals, versions, followed = read([Path(folder) for folder in folders])
    found = scores.bars(cases, followed)
    for name, checksum in seals.items():
        print(f"{name}: seal opened, SHA-256 {checksum} as printed before")
    if len(versions) > 1:
        print(f"note: the verdicts come from {len(versions)} versions of the diagnosis")
    print(words(found))
    wide = [case for case in cases if case["protocol"]]
    rows = strata.table(wide) if wide else []
    if rows:
        print(strata.words(rows))
    out.mkdir(parents=True, exist_ok=True)
    report = {
        "schema": "talus-blind/1",
        "seals": seals,
        "versions": versions,
        "bars": [b.row() for b in found],
        "confusion": scores.confusion(cases),
        "effects": scores.by_effect(cases),
        "followed": followed,
        "strata": rows,
        "reliability": scores.reliability(cases),
        "cases": cases,
    }
    (out / "blind.json").write_text(json.dumps(finite(report), indent=1))
    write_page(out / "blind.html", cases, found, seals, versions, rows)
    print(f"written: {out / 'blind.json'}, {out / 'blind.html'}")
