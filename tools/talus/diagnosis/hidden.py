"""Effects that these recordings could not show: identification takes them up, or nothing in them moves what they change."""

import math

import numpy as np

from .effects import EFFECTS, places
from .gram import RIDGE
from .kinds import is_known, kind_of
from .words import linear

LARGEST = 0.1  # of the measured torque (RMS): an effect that must be larger to show is called not observable
OFFSETS = {"torque_offset": "torque_offset_Nm", "force_offset": "force_offset_N"}  # base parameters of single joints
LAST_SHARE = 0.01  # of a column's squares, that the base parameters leave: less, and they are what takes it up


def least_shares(search):
    """For each (effect, joint) the torque, of the measured one, at which its best shape would pass the detection threshold, and the
    share of that column's squares which base parameters leave. Effects that show in an encoder alone need no torque."""
    gram = search.gram
    plain, beside = sum(gram.plain_grams).sum(0), gram.beside_plain.sum(0)
    seen = gram.base
    known = plain[np.ix_(seen, seen)] + gram.prior_products()
    scale = np.sqrt(np.diag(known))
    taken = np.linalg.solve(known / np.outer(scale, scale) + RIDGE * np.eye(len(seen)), beside[seen] / scale[:, None])
    each, whole = gram.column_squares, sum(gram.column_squares.values())
    measured = {kind: np.sum(gram.reading(kind) ** 2) for kind in each if kind[0] == "T"}
    left = np.maximum(whole - np.einsum("ij,ij->j", beside[seen] / scale[:, None], taken), 0.0)
    out = {}
    for candidate in gram.candidates:
        for column in gram.of(candidate):
            torque = max(each[kind][column] / measured[kind] for kind in measured)
            least = math.sqrt(search.detection_threshold * torque / left[column]) if left[column] > 0 else math.inf
            found = least, left[column] / whole[column]
            out[candidate.key] = min(out.get(candidate.key, (math.inf, 0.0)), found)
    return out


def applicable(model, load_sensor, effects=EFFECTS):
    """Every (effect, joint) that the model can have, and whether it lacks a sensor at the output."""
    for effect, _, joint in places(model, {name: one for name, one in effects.items() if not one.outside}):
        needs = is_known(effect.id) and bool(kind_of(effect.id).struct.needs_load_sensor)
        yield (effect.id, joint), needs and not load_sensor


def not_observable(search):
    """`not_observable` of the report."""
    dataset, shares, out = search.dataset, least_shares(search), []
    for key, lacks_sensor in applicable(dataset.model, dataset.load_sensor, dataset.effects):
        effect = dataset.effects[key[0]]
        took = offset(dataset) if effect.in_offset else ""
        why = reason(shares.get(key), lacks_sensor, took)
        if why and not (lacks_sensor and effect.of_load_sensor):  # there is none that could be wrong
            out.append({"effect": key[0], "joint": key[1], "why": linear(why) if dataset.model.torque_unit == "N" else why})
    return out


def offset(dataset):
    """Where the zero of a current or sensor went: the model's own parameter, and what identification makes of it."""
    for name, given, found in zip(dataset.model.base, dataset.prior, dataset.identified):
        if name in OFFSETS:
            return f"; {OFFSETS[name]} goes from {given:.3g} to {found:.3g}"
    return ""


def reason(found, lacks_sensor, took=""):
    """Why an effect would not be seen, or None; `took` says what has it where the model's own parameters take it up."""
    if lacks_sensor:
        return "the model's own parameters take it up; a torque sensor at the output would show it"
    if found is None:
        return "nothing in these recordings moves what it changes"
    least, left = found
    if least <= LARGEST:
        return None
    size = f"would have to be {100 * least:.0f} % of the measured torque" if least < 1 else "would be lost at any size"
    return f"the model's own parameters take it up: it {size}{took}" if left < LAST_SHARE else f"too little moves it: it {size}"
