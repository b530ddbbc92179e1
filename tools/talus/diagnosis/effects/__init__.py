"""The catalogue of effects: each file in this folder is one effect, and nothing else lists them.

A file defines EFFECT, an object of the class Effect of entry.py. docs/effects.md shows how one is added.
"""

import importlib
import pkgutil

from talus import constants

from ..catalogue.place import Place
from ..kinds import applies, ids, is_known
from .entry import Effect

BASE = (constants.TL_MAX_JOINTS, "base")


def _found():
    """The effects by id, in the library's order."""
    names = [module.name for module in pkgutil.iter_modules(__path__) if module.name != "entry"]
    every = {effect.id: effect for effect in (importlib.import_module(f"{__name__}.{name}").EFFECT for name in names)}
    if lacking := every.keys() - ids():
        raise ImportError(f"the library has no effect {', '.join(sorted(lacking))}: build it with that file in lib/effects")
    return {name: every[name] for name in ids() if name in every}


EFFECTS = _found()


def known(ids):
    """The effects with these ids; what is no effect ("none", "unknown") is left out."""
    return [EFFECTS[name] for name in ids if name in EFFECTS]


def places(model, effects=EFFECTS):
    """(effect, number of the joint, its name) of every effect that a model can have, at each joint and at the base."""
    for effect in effects.values():
        yield from ((effect, *place) for place in [*enumerate(model.joints), BASE] if _stands(effect, model, place))


def _stands(effect, model, place):
    """Can the effect stand there? One's own can at every joint."""
    return applies(effect.id, model, place[0]) if is_known(effect.id) else place != BASE


def candidates(dataset, all_terms, extent):
    """All candidates of a diagnosis."""
    at = {place: Place(*place, dataset, extent, all_terms) for place in [*enumerate(dataset.model.joints), BASE]}
    return [one for effect, *place in places(dataset.model, dataset.effects) for one in effect.candidates(at[tuple(place)])]


def torque_constant_error(chosen, every):
    """What the drive gives beyond current times constant, by the strengths of the chosen effects."""
    return sum(float(own[0]) for c, own in zip(chosen, every) if c.effect in EFFECTS and EFFECTS[c.effect].scales_drive)


__all__ = ["EFFECTS", "Effect", "candidates", "known", "places", "torque_constant_error"]
