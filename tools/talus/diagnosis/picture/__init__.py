"""The diagnosis as one page that needs nothing besides itself."""

import hashlib
import tempfile
from pathlib import Path

import talus
from talus import constants

from .. import tilt_source, words
from ..calibration.lowpass import Lowpass
from ..calibration.thresholds import GIVES_UP
from ..words import Scale, sentence
from . import maps
from .maps import coordinate_unit

__all__ = ["page", "sentence"]

GAP = {"nominal": "as given", "identified": "identified", "extended": "with effects", "noise_floor": "noise floor"}
ROLES = {"nominal": "nominal", "identified": "identified", "extended": "extended", "noise_floor": "noise"}
MOST_CAUSES, MOST_PLACES, LEAST_SHOWN = 8, 8, 0.005
SHOWS = {True: " The named effect shows at {:.3g} Hz, too.",
         False: " At {:.3g} Hz the named effect does not show, or has another size: its probability is lowered."}
SAME_SIZE = {True: " The named effect has the same size at half and at twice of that frequency.",
             False: " At half or at twice of it the named effect has another size: its probability is lowered."}  # fmt: skip
MOST_POINTS = 1500  # of a trajectory: more than a screen shows


def page(found, options, steps, patch):
    """The page's text; `steps` to the next experiment, `patch` from the identified model to the one with effects."""
    report = found.report
    out = talus.Page(f"Where the gap lies: {_named(options.recordings)}", sentence(report))
    poor = words.is_poor(report)
    _findings(out, report["findings"])
    _gap(out, report, poor)
    _motion(out, report)
    if not poor:
        _causes(out, report)
        _where(out, report)
    if found.search:
        maps.maps(out, found)
        maps.over_time(out, found)
    _next(out, found, steps)
    if patch:
        out.heading("The model with effects")
        out.code("What it differs by from the identified one; --save-model writes it", patch)
    _inputs(out, options)
    with tempfile.TemporaryDirectory(prefix="talus-gap-") as folder:
        path = Path(folder) / "page.html"
        out.write(path)
        return path.read_text(encoding="utf-8")


def _named(recordings):
    """The recordings, by the first one's name."""
    first, more = Path(recordings[0]).name, len(recordings) - 1
    return f"{first} and {more} more" if more else first


def _findings(out, findings):
    """What makes the recordings doubtful."""
    if not findings:
        return
    out.heading("What is wrong with the recordings")
    rows = [[f["id"].replace("_", " "), "grave" if f["grave"] else "", f["column"], f"{f['evidence']}; {f['remedy']}"] for f in findings]
    out.table("No cause is named while a grave one stands", ["finding", "", "column", "what was seen, and what to do"], rows, words=True)


def _bars(out, title, unit, labels, values, roles):
    """Bars that carry their figures."""
    scale = Scale(unit, values)
    out.bars(title, f"RMS [{scale.unit}]", [[label, scale.text(x)] for label, x in zip(labels, values)],
             [scale(x) for x in values], roles)  # fmt: skip


def _closed(gap):
    """The closed share and its interval."""
    if "closed_interval" not in gap:
        return f"{100 * gap['closed_fraction']:.1f} %", ""
    low, high = gap["closed_interval"]
    return f"{100 * gap['closed_fraction']:.1f} %", f"{100 * low:.1f} to {100 * high:.1f} %"


def _of_measured(gap):
    """Errors as shares of the measured torque."""
    if not gap.get("measured_rms"):
        return []
    return [" → ".join(f"{100 * gap[f'{k}_rms'] / gap['measured_rms']:.2f}" for k in ("identified", "extended")) + " %"]


def _gap(out, report, poor):
    if not report["gap"]:
        return
    out.heading("The gap")
    shown = ["nominal", "identified"] if poor else list(GAP)
    with out.side_by_side():
        for joint, gap in report["gap"].items():
            kind = "torque" if gap["unit"] == "Nm" else "force"
            _bars(out, f"{joint}: {kind} error", gap["unit"], [GAP[k] for k in shown], [gap[f"{k}_rms"] for k in shown],
                  [ROLES[k] for k in shown])  # fmt: skip
    _gap_table(out, report["gap"], shown, poor)
    for said in words.worse_than_given(report):
        out.paragraph(said)
    if not poor:
        out.paragraph("All on blocks that the fit has not seen. Closed is the share of the systematic part, identified² − noise², "
                      "that the effects take away; an interval from next to nothing to nearly all says that there was "
                      "hardly anything above the noise to take away. The floor is an estimate: an error a little below "
                      "it is as good as at it. Near standstill friction has any value between its two levels: those "
                      "samples are reported apart.")  # fmt: skip


def _gap_table(out, gaps, shown, poor):
    """The same figures, with what was closed."""
    keys, rows = [*(f"{k}_rms" for k in shown), "reversal_rms"], []
    scale = Scale(next(iter(gaps.values()))["unit"], [gap[key] for gap in gaps.values() for key in keys[:-1]])
    for joint, gap in gaps.items():
        closed = [] if poor else [*_closed(gap), *_of_measured(gap)]
        rows.append([joint, *(scale.number(gap[key]) for key in keys), *closed])
    columns = ["joint", *(GAP[k] for k in shown), "near standstill", "closed", "in another motion (95 %)", "of the measured"]
    out.table(f"RMS of measured − predicted [{scale.unit}]", columns[:max(map(len, rows))], rows)


def _motion(out, report):
    if not report["motion"]:
        return
    out.heading("The motion")
    rows = []
    with out.side_by_side():
        for joint, motion in report["motion"].items():
            figures = [motion["identified_rms"], motion["extended_rms"]]
            unit = motion.get("unit", "rad")
            _bars(out, f"{joint}: motion error", unit, ["identified", "with effects"], figures, ["identified", "extended"])
            scale = Scale(unit, figures)
            change = f"{100 * (figures[1] / figures[0] - 1):+.1f} %" if figures[0] else ""
            rows.append([joint, *map(scale.text, figures), change])
    out.table("RMS of simulated − recorded motion", ["joint", "identified", "with effects", "change"], rows)
    out.paragraph("The model is moved forward in time by the recorded torque, from the recorded state anew every quarter of a "
                  "second.")  # fmt: skip


def _causes(out, report):
    out.heading("The causes")
    every = [report["verdict"], *report["alternatives"]][:MOST_CAUSES]
    every = [e for e in every if e["probability"] >= LEAST_SHOWN]
    of = lambda e: words.name(e["effect"]) + ("" if e["joint"] == "none" else f", {e['joint']}")  # noqa: E731
    out.bars("What could explain the gap", "probability", [[of(e), words.share(e["probability"])] for e in every],
             [e["probability"] for e in every], ["accent" if k == 0 else "measured" for k in range(len(every))])  # fmt: skip
    out.paragraph(_calibration(report))
    with out.side_by_side():
        for number, effect in enumerate(report["effects"], 1):
            _effect(out, number, effect, report)
    _doubts(out, report)
    _resembles(out, report)
    _nearest(out, report)
    if report["confusable"]:
        rows = [[" and ".join(words.name(e) for e in one["effects"]), one["joint"], f"{one['separation']:.2f}"]
                for one in report["confusable"]]  # fmt: skip
        out.table("Not told apart by these recordings", ["effects", "joint", "logarithm of the odds"], rows)
    if report["not_observable"]:
        rows = [[words.name(one["effect"]), one["joint"], one["why"]] for one in report["not_observable"]]
        out.table("What these recordings cannot show", ["effect", "joint", "why"], rows, words=True)


def _doubts(out, report):
    """Why effects are no surer, below their tables."""
    for said in filter(None, map(words.doubts, report["effects"])):
        out.paragraph(said)


def _resembles(out, report):
    """What the gap looks like beyond the catalogue."""
    if not report["resembles"]:
        return
    rows = [[one["joint"], words.share(one["probability"]), "" if one["closes"] is None else f"{100 * one['closes']:.0f} %",
             words.looks(one, words.is_linear(report))] for one in report["resembles"]]  # fmt: skip
    out.table("What it looks like beyond the catalogue", ["joint", "probability", "of the gap", "like"], rows, words=True)


def _nearest(out, report):
    """What each effect alone would do."""
    if not report["nearest"]:
        return
    beside = ["chi-square in replicates"] if report["calibrated"] else []
    rows = [[words.at(one["effect"], one["joint"]), f"{100 * one['closes']:.0f} %", words.figure(one["gain"]),
             *(words.figure(one["replicates"]) for _ in beside)] for one in report["nearest"]]  # fmt: skip
    out.table("What each effect alone would take away", ["effect", "of the gap", "chi-square", *beside], rows)


def _calibration(report):
    """How far the probabilities are set against these very recordings, and what they were seen through."""
    seen = f"All figures are seen through a low-pass of {report['lowpass']['hz']:.3g} Hz"
    bias = report["lowpass"]["inertia_bias"]
    seen += "." if bias is None else f"; resolution and noise of the angles alone change the inertia by {100 * bias:+.1f} % there."
    if report["lowpass"]["window_hz"]:
        seen += " The motion is differentiated over windows of one period of that; shorter ones lose more to steps and noise of the angles."
    if bias is not None and abs(bias) > GIVES_UP:
        seen += " That is so much that an effect may stand for it: one counts only for what it gains beyond anything in replicates."
    other_hz = Lowpass(report["lowpass"]["hz"], report["lowpass"]["from"]).other_hz
    if not other_hz:
        seen += " Half of that is too slow for rivals to be tried there."
    stable = report["lowpass"]["stable"]
    if stable is not None:
        seen += SHOWS[stable].format(other_hz) if other_hz else SAME_SIZE[stable]
    if not report["calibrated"]:
        return f"{seen} The probabilities are not calibrated on these recordings: there are no replicates of them."
    return (f"{seen} Each gain in chi-square is set beside that of {report['replicates']} replicates: the same motion, simulated by the identified "
            "model without any effect, and recorded by the same sensors.")  # fmt: skip


def _effect(out, number, effect, report):
    """What was added, with its parameters."""
    gap = report["gap"].get(effect["joint"]) or next(iter(report["gap"].values()))
    scale = Scale(gap["unit"], [effect["gap_before"], effect["gap_after"]])
    straight = words.is_linear(report)
    rows = [[name, _value(value, effect["interval"].get(name)), words.unit(name, straight)] for name, value in effect["parameters"].items()]
    rows += [["probability", words.share(effect["probability"]), ""], ["error before", scale.number(effect["gap_before"]), scale.unit],
             ["error after", scale.number(effect["gap_after"]), scale.unit]]  # fmt: skip
    rows += [[f"closes of the {joint}'s gap", f"{100 * share:.0f}", "%"] for joint, share in effect["closes"].items()]
    size = words.size(effect["effect"], effect["parameters"], straight)
    cause = words.cause(effect["effect"], effect["joint"], straight, words.titles(report))
    out.table(f"{number}. {cause}{f': {size}' if size else ''}", ["parameter", "value", "unit"], rows)
    if "source" in effect:
        said = tilt_source.words(effect["source"])
        out.paragraph(f"{said[0].upper()}{said[1:]}.")


def _value(value, interval):
    """A parameter, with half of its 95 % interval where there is one."""
    return f"{value:.4g}" if interval is None else f"{value:.4g} ± {0.5 * (interval[1] - interval[0]):.2g}"


def _where(out, report):
    if not report["where"]:
        return
    out.heading("Where it lies")
    rows = []
    for one in report["where"][:MOST_PLACES]:
        share, (low, high) = f"{100 * one['share']:.1f} %", one["range"]
        interval = " to ".join(f"{100 * x:.1f}" for x in one["interval"]) + " %" if "interval" in one else ""
        deviations = words.figure(one["deviations"]) if "deviations" in one else ""
        unit = coordinate_unit(one["coordinate"], report["gap"][one["joint"]]["unit"] == "N")
        place = f"{low:.4g} to {high:.4g} {unit}"
        rows.append([f"{one['joint']}, {words.name(one['coordinate'])}", share, interval, deviations, place])
    out.table("Before any effect is added", ["joint, over", "share", "95 % interval", "deviations", "mostly in"], rows)
    out.paragraph("Share is of the systematic energy: the first of a joint has all that it explains, the others at most what "
                  "that leaves. Deviations say how far it stands above what noise alone would show.")


def _next(out, found, steps):
    proposed = found.report["next_experiment"]
    out.heading("Next experiment")
    out.paragraph(proposed["why"])
    if steps:
        out.steps(steps)
    if not (found.trajectory and proposed["trajectory"]):
        return
    names, t, angles = _trajectory(found.trajectory)
    unit = "m" if names[0].endswith("_m") else "rad"
    roles = ["identified", "residual"]
    out.chart(f"Trajectory, {Path(proposed['trajectory']).name}", "time [s]", f"position [{unit}]",
              [(name.rsplit("_", 1)[0], roles[k % 2], t, q) for k, (name, q) in enumerate(zip(names, angles))])  # fmt: skip


def _trajectory(text):
    """(names of the columns, times, columns) of a trajectory's file, thinned for a screen."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = [[float(x) for x in line.split(",")] for line in lines[1:]]
    t, *columns = zip(*rows[::max(1, len(rows) // MOST_POINTS)])
    return lines[0].split(",")[1:], t, columns


def _inputs(out, options):
    out.heading("Inputs")
    rows = []
    for path in (options.flags["--model"], *options.recordings):
        rows.append([Path(path).name, hashlib.sha256(Path(path).read_bytes()).hexdigest()])
    out.table("SHA-256", ["file", "checksum"], rows)
    out.paragraph(f"talus-gap {constants.TL_VERSION}, seed {options.seed}.")
