"""The model with its effects, as a file that every program reads."""

import copy
import difflib

import yaml

from .kinds import is_known, kind_of
from .refit import best_shapes, settled_fit

BOUND_CHI2, BOUND_SHARE = 50.0, 0.02  # that bounds may cost without a note: chi-square, and share of what effects gain


def place(tree, name, value):
    """Put a parameter of the C tables where the model file has it: under its joint or body, or in its friction."""
    bodies = [(prefix + "_", tree[prefix]) for prefix in ("shank", "foot", "ankle_motor", "knee", "ankle") if prefix in tree]
    for prefix, part in [*bodies, ("", tree), ("", tree.get("joint", {}))]:
        rest = name.removeprefix(prefix)
        if not name.startswith(prefix):
            continue
        for target in (part, part.get("friction", {})):
            if rest in target:
                target[rest] = value
                return
    if name in ("torque_offset_Nm", "force_offset_N"):  # optional in the file
        tree[name] = value
        return
    raise KeyError(name)


def saved_effects(chosen, every):
    """(entries of the model file, notes on what was left out)."""
    entries, notes = [], []
    for candidate, strengths in (piece for c, own in zip(chosen, every) for piece in c.pieces(own)):
        if not is_known(candidate.effect):
            notes.append(f"{candidate.effect} of the {candidate.joint} is a Python function, which no model file holds, and is left out")
            continue
        known, values = kind_of(candidate.effect).parameters, candidate.entry(strengths)
        if set(values) - {p.name for p in known}:  # tests hold the catalogue against this
            notes.append(f"{candidate.effect} of the {candidate.joint} ({candidate.shape}) has no counterpart in model "
                         "files and is left out")  # fmt: skip
            continue
        full = {p.name: values.get(p.name, 0.0) for p in known if p.name in values or p.default_value is None}
        if any(p.name in full and not p.low <= full[p.name] <= p.high for p in known):
            notes.append(f"{candidate.effect} of the {candidate.joint} is out of the model file's range and is left out")
            continue
        entries.append({"effect": candidate.effect, "joint": candidate.joint, "parameters": full})
    return entries, notes


def model_text(tree, model, diagnosis):
    """(text of the model file, notes); `tree` is the identified model's mapping, and stays it."""
    tree = copy.deepcopy(tree)
    fit, entries, notes = diagnosis.fit, [], []
    if fit and fit.chosen:
        chosen = best_shapes(diagnosis.search, fit.chosen)
        parameters, strengths, lost = settled_fit(diagnosis.search, chosen, model)
        entries, notes = saved_effects(chosen, strengths)
        if entries and not notes:  # parameters that were fitted with the effects belong to all of them
            for name, value in parameters.items():
                place(tree, name, value)
            if lost > BOUND_CHI2 + BOUND_SHARE * max(diagnosis.search.plain.excess - fit.excess, 0.0):
                notes.append("with the effects, parameters end at their physical bounds: the model file fits less well than "
                             "said")  # fmt: skip
    if entries:
        tree = {**tree, "effects": entries}
    return dumped(tree), notes


def dumped(tree):
    return "# diagnosed by talus-gap\n" + yaml.safe_dump(tree, sort_keys=False, default_flow_style=None, width=1000)


def patch(tree, text):
    """What a fitted model's text differs by from the identified model's mapping, as a unified diff; "" where it does not."""
    lines = dumped(tree).splitlines(), text.splitlines()
    return "\n".join(difflib.unified_diff(*lines, "identified", "with effects", lineterm="", n=1))
