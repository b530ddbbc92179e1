"""The diagnosis as one page that needs nothing besides itself."""

import hashlib
import tempfile
from pathlib import Path

import numpy as np

import talus
from talus import constants

COORDINATE_LABELS = {
    "position": "position [rad]", "velocity": "velocity [rad/s]", "acceleration": "acceleration [rad/s²]",
    "load": "load at the joint [Nm]", "current": "motor torque [Nm]", "time": "time [s]",
    "reversal": "time since the last stop [s]",
}  # fmt: skip
MOST_POINTS = 1500  # of a line: more than a screen shows


def sentence(found):
    """The diagnosis in plain words."""
    verdict, gaps = found["verdict"], found["gap"]
    sure = f"(probability {verdict['probability']:.2f})"
    if verdict["effect"] == "none":
        return f"The model explains these recordings down to their noise; no further effect is needed {sure}."
    if verdict["effect"] == "unknown":
        return f"A gap remains that no known effect explains, or the recordings cannot tell {sure}."
    joint = verdict["joint"] if verdict["joint"] in gaps else max(gaps, key=lambda j: gaps[j]["closed_fraction"])
    closed = 100 * gaps[joint]["closed_fraction"]
    return (f"The gap is caused by {verdict['effect'].replace('_', ' ')} at the {verdict['joint']} {sure}; modelling it "
            f"closes {closed:.0f} % of the {joint}'s systematic torque error.")  # fmt: skip


def page(found, options):
    """The page's text."""
    out = talus.Page("Where the gap lies", sentence(found.report))
    _bars(out, found.report)
    _ranking(out, found.report)
    if found.search:
        _maps(out, found)
        _over_time(out, found)
    out.heading("Next experiment")
    out.paragraph(found.report["next_experiment"]["why"])
    _inputs(out, options)
    with tempfile.TemporaryDirectory(prefix="talus-gap-") as folder:
        path = Path(folder) / "page.html"
        out.write(path)
        return path.read_text(encoding="utf-8")


def _bars(out, report):
    out.heading("The gap")
    rows = []
    for joint, gap in report["gap"].items():
        figures = [gap[f"{name}_rms"] for name in ("nominal", "identified", "extended", "noise_floor")]
        labels = ["as given", "identified", "with effects", "noise floor"]
        out.bars(f"{joint}: error on data held out", f"RMS [{gap['unit']}]", labels, figures)
        rows.append([joint, *(f"{x:.4g} {gap['unit']}" for x in figures), f"{100 * gap['closed_fraction']:.1f} %"])
    out.table("RMS residual on data held out", ["joint", *labels, "closed"], rows)


def _ranking(out, report):
    out.heading("The causes")
    every = [report["verdict"], *report["alternatives"]]
    out.table("What could explain it", ["effect", "joint", "probability"],
              [[e["effect"], e["joint"], f"{e['probability']:.4f}"] for e in every[:10]])  # fmt: skip
    for effect in report["effects"]:
        figures = ", ".join(f"{name} = {value:.4g}" for name, value in effect["parameters"].items())
        out.paragraph(f"{effect['effect']} of the {effect['joint']}: {figures}. Error {effect['gap_before']:.4g} before, "
                      f"{effect['gap_after']:.4g} after.")  # fmt: skip
    if report["where"]:
        out.table("Where it lies", ["joint", "coordinate", "share", "range"],
                  [[w["joint"], w["coordinate"], f"{100 * w['share']:.0f} %", f"{w['range'][0]:.4g} to {w['range'][1]:.4g}"]
                   for w in report["where"][:8]])  # fmt: skip


def _maps(out, found):
    out.heading("Maps of the error")
    evidence = found.search.evidence
    for number, joint in enumerate(evidence.model.joints):
        slider = evidence.model.plant == "slider"
        milli = 1000 * evidence.sigma[f"T{number}"]
        after = {m.coordinate: m for m in found.maps_after.get(joint, [])}
        for one in sorted(found.maps.get(joint, []), key=lambda m: -m.energy)[:3]:
            lines = [("identified", "identified", one.centre, one.mean * milli)]
            if found.fit.chosen and one.coordinate in after:
                other = after[one.coordinate]
                lines.append(("with effects", "extended", other.centre, other.mean * milli))
            label = COORDINATE_LABELS[one.coordinate]
            label = label.replace("Nm", "N").replace("rad", "m") if slider else label
            out.chart(f"{joint}: mean error over {one.coordinate}", label, "error [mN]" if slider else "error [mNm]", lines)


def _over_time(out, found):
    out.heading("Measured against predicted")
    evidence = found.search.evidence
    for number, joint in enumerate(evidence.model.joints):
        track = evidence.tracks[0]
        thin = slice(0, len(track.grid_t_s), max(1, len(track.grid_t_s) // MOST_POINTS))
        t, target = track.grid_t_s[thin], track.target[number][thin]
        before, after = (r.of[0, f"T{number}"][thin] for r in (found.before, found.after))
        hidden = np.where(track.kind[number][thin] == 1, 0.0, np.nan)
        unit = found.report["gap"][joint]["unit"]
        out.chart(f"{joint}: {Path(track.name).name}", "time [s]", f"measured [{unit}]",
                  [("measured", "measured", t, target), ("with effects", "extended", t, target - after)],
                  below=(f"error [{unit}]", [("identified", "identified", t, before + hidden),
                                   ("with effects", "extended", t, after + hidden)]))  # fmt: skip


def _inputs(out, options):
    out.heading("Inputs")
    rows = []
    for path in (options.flags["--model"], *options.recordings):
        rows.append([Path(path).name, hashlib.sha256(Path(path).read_bytes()).hexdigest()])
    out.table("SHA-256", ["file", "checksum"], rows)
    out.paragraph(f"talus-gap {constants.TL_VERSION}, seed {options.seed}.")
