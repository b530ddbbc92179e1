"""The model with its effects, as a file that every program reads."""

import numpy as np
import yaml

from talus import ffi, lib

NEWTON_STEPS = 20
STEP = 1e-6


def physical(model, base):
    """Parameters of base parameters: the nearest to the model's own, relative to each; None if none is near."""
    trial, names = model.copy(), list(model.parameters)
    start = np.array(list(model.parameters.values()))
    scale = np.maximum(np.abs(start), 1e-6)

    def base_of(u):
        trial.set_parameters(**dict(zip(names, start + scale * u)))
        return np.array(list(trial.base.values()))

    u, size = np.zeros(len(start)), np.maximum(np.abs(base), 1e-9)
    for _ in range(NEWTON_STEPS):
        now = base_of(u)
        slope = np.array([(base_of(u + STEP * e) - now) / STEP for e in np.eye(len(u))]).T
        # the smallest u that meets the linearised equations, not the smallest step
        u = np.linalg.lstsq(slope / size[:, None], (base - now + slope @ u) / size, rcond=1e-12)[0]
    close = np.allclose(base_of(u), base, rtol=1e-6, atol=1e-9)
    return dict(zip(names, (start + scale * u).tolist())) if close and np.all(np.isfinite(u)) else None


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


def kind_parameters(effect):
    """Parameter names of the library's effect of that name: [(name, low, high)]."""
    kind = lib.tl_effect_find(effect.encode())
    if kind == ffi.NULL:
        return []
    count = kind.strengths + kind.shapes
    return [(ffi.string(kind.parameter[k].name).decode(), kind.parameter[k].low, kind.parameter[k].high) for k in range(count)]


def saved_effects(fit):
    """(entries of the model file, notes on what was left out)."""
    entries, notes = [], []
    for candidate, strengths in zip(fit.chosen, fit.strengths):
        known = kind_parameters(candidate.effect)
        values = candidate.parameters(strengths) if candidate.saved else {}
        if not candidate.saved or not known or set(values) - {name for name, _, _ in known}:
            notes.append(f"{candidate.effect} of the {candidate.joint} ({candidate.shape}) has no counterpart in model "
                         "files and is left out")  # fmt: skip
            continue
        full = {name: float(values.get(name, 0.0)) for name, _, _ in known}
        if any(not low <= full[name] <= high for name, low, high in known):
            notes.append(f"{candidate.effect} of the {candidate.joint} is out of the model file's range and is left out")
            continue
        entries.append({"effect": candidate.effect, "joint": candidate.joint, "parameters": full})
    return entries, notes


def model_text(tree, model, diagnosis):
    """(text of the model file, notes)."""
    entries, notes = saved_effects(diagnosis.fit) if diagnosis.fit else ([], [])
    if entries and not notes:  # parameters that were fitted with the effects belong to all of them
        base = diagnosis.after.strengths[:len(model.base)]
        found = physical(model, base)
        trial = model.copy()
        if found:
            trial.set_parameters(**found)
        if found and lib.tl_model_check(trial.struct) == lib.TL_OK:
            for name, value in found.items():
                place(tree, name, value)
        else:
            notes.append("the parameters that suit the effects are not physical; the identified ones are kept")
    if entries:
        tree = {**tree, "effects": entries}
    return "# diagnosed by talus-gap\n" + yaml.safe_dump(tree, sort_keys=False, default_flow_style=None, width=1000), notes
