"""GAP.json."""

import json
import math

from . import experiment, figures, irregular, motion, tilt_source
from .machine.drawing import beside_drawing
from .hidden import not_observable
from .kinds import is_known
from .nearest import nearest
from .outside.resembles import resembles
from .where import where
from .words import linear

SCHEMA = "talus-gap/1"


class Diagnosis:
    """All that was found: the report, what the page draws beside it, and the next experiment's trajectory as text."""

    def __init__(self, report, search=None, fit=None, before=None, after=None, maps=None, maps_after=None):
        self.trajectory = None
        self.report, self.search, self.fit = report, search, fit
        self.before, self.after, self.maps, self.maps_after = before, after, maps or {}, maps_after or {}


def diagnosis(search, verdict, seed, findings, through):
    """The diagnosis of a finished search; `findings` are those that are not grave, `through` the Lowpass."""
    dataset, before = search.dataset, figures.Residuals(search, [])
    near, fit = beside_drawing(search, verdict.fit)
    after = figures.Residuals(near, fit.chosen) if fit.chosen else before
    places, maps = where(search, before, fit.chosen[0].key if fit.chosen else None)
    maps_after = where(search, after)[1] if fit.chosen else maps
    named = verdict.probabilities[0]
    proposal = experiment.propose(search, verdict)
    why = linear(proposal.why) if dataset.model.torque_unit == "N" else proposal.why
    report = {
        "schema": SCHEMA,
        "verdict": entry(*named),
        "alternatives": [entry(*p) for p in verdict.probabilities[1:]],
        "lowpass": {"hz": through.hz, "from": through.source, "stable": verdict.stable, "inertia_bias": through.bias,
                    "window_hz": through.window_hz},
        "selection": "blocks",
        "calibrated": search.calibration is not None,
        "replicates": len(search.calibration.gains) if search.calibration else 0,
        "nearest": nearest(search),
        "resembles": resembles(search, verdict),
        "irregular": irregular.shares(search),
        "effects": [],
        "gap": figures.gap(search, near, fit.chosen, before, after, seed),
        "motion": motion.motion(near, fit, before, after),
        "where": places,
        "confusable": [
            {"effects": [named[1], effect], "joint": joint, "separation": math.log(named[0] / p)}
            for p, effect, joint in verdict.confusable()
        ],
        "not_observable": not_observable(search),
        "next_experiment": {"why": why, "trajectory": None, "needs": proposal.needs, "parts": proposal.parts},
        "findings": entries(findings),
    }
    if own := [effect for effect in dataset.effects.values() if not (is_known(effect.id) or effect.outside)]:
        report["own_effects"] = {effect.id: {"title": effect.words} for effect in own}
    listed = figures.effects(near, fit, before)
    keys = [c.key for c in fit.chosen]
    for item in listed:
        own = [p for p, effect, joint in verdict.probabilities if (effect, joint) == (item["effect"], item["joint"])]
        first = keys.index((item["effect"], item["joint"])) == 0
        # a further effect is as sure as that something explains the gap, and that it is itself part of that
        further = verdict.known * verdict.further.get((item["effect"], item["joint"]), 1.0)
        item["probability"] = own[0] if own and first else further
        item["doubts"] = verdict.doubts.get((item["effect"], item["joint"]), [])
    order = ("effect", "joint", "probability", "doubts", "parameters", "interval", "closes", "gap_before", "gap_after")
    report["effects"] = [{name: item[name] for name in order} for item in listed]
    if source := tilt_source.of(near, fit):
        report["effects"][tilt_source.place_of(near, fit)]["source"] = source
    if near is not search:
        search.gram.keep([])  # its rows are the other's, too, which gives them up when it has done
    found = Diagnosis(report, near, fit, before, after, maps, maps_after)
    found.trajectory = proposal.text
    return found


def withheld(identification, findings):
    """The report while a grave finding stands: no cause is named; figures are those of the identification, where there is one."""
    gap = {}
    for joint, error in identification["error"].items() if identification else ():
        if error["identified_rms"] is None:
            continue  # it never moved
        gap[joint] = {"unit": error["unit"], "nominal_rms": error["nominal_rms"],
                      "identified_rms": error["identified_rms"], "extended_rms": error["identified_rms"],
                      "noise_floor_rms": 0.0, "closed_fraction": 0.0, "reversal_rms": 0.0}  # fmt: skip
    return Diagnosis({"schema": SCHEMA, "verdict": {**entry(1.0, "unknown", "none"), "withheld": True}, "alternatives": [], "effects": [],
                      "lowpass": {"hz": None, "from": None, "stable": None, "inertia_bias": None, "window_hz": None}, "selection": "blocks",
                      "calibrated": False, "replicates": 0, "nearest": [], "resembles": [], "irregular": [],
                      "gap": gap, "motion": {}, "where": [], "confusable": [], "not_observable": [],
                      "next_experiment": {"why": remedy(findings[0]), "trajectory": None, "needs": None, "parts": []},
                      "findings": entries(findings)})  # fmt: skip


def remedy(finding):
    """What to do about a finding, as a sentence after what was seen."""
    begin = finding.evidence[0]
    if not finding.evidence.split()[0].endswith(":"):  # a file's name stays as it is
        begin = begin.upper()
    return f"{begin}{finding.evidence[1:]}. Next: {finding.remedy}."


def entries(findings):
    """Findings as GAP.json has them."""
    return [finding.entry() for finding in findings]


def entry(probability, effect, joint):
    return {"effect": effect, "joint": joint, "probability": probability}


def to_text(report):
    return json.dumps(report, indent=1, allow_nan=False) + "\n"
