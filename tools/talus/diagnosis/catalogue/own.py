"""Effects of one's own (talus.Effect) as entries of the catalogue: their columns are a Python function's, not the library's."""

from dataclasses import dataclass

import numpy as np

import talus

from ..effects.entry import Effect
from ..gram import LARGEST
from ..torque_terms import rows_of
from .candidate import Candidate, named

FROM_INSTANTS = ("q", "v", "slip", "load_Nm", "friction_Nm", "motor_rad", "temp_C")  # of tl_effect_instant


@dataclass(frozen=True)
class OwnColumn:
    """One parameter's column: `shape` is its place among the effect's."""

    effect: talus.Effect
    joint: int
    parameter: int
    shape: int
    sign: float

    def __call__(self, terms):
        """{channel: column on the grid} of one recording."""
        key = self.effect, self.joint, self.shape
        every = terms.once(key, lambda: terms.operated(_samples(terms, *key), self.joint))
        return {f"T{self.joint}": self.sign * every[self.parameter]}


def entries(effects):
    """{id: entry} of talus.Effects; InputError where two have one id."""
    out = {}
    for effect in effects:
        if not isinstance(effect, talus.Effect):
            raise talus.InputError(f"effects: expected talus.Effect, found {type(effect).__name__}")
        if effect.id in out:
            raise talus.InputError(f"effect {effect.id!r}: there are two of that id")
        out[effect.id] = Effect(id=effect.id, words=effect.title, candidates=_candidates_of(effect))
    return out


def _candidates_of(effect):
    """What an entry asks for: the effect at a joint, in every shape."""

    def candidates(at):
        for number, shape in enumerate(effect.shapes):
            values = {name: float(value) for name, value in shape.items()}
            form = ", ".join(f"{name} {value:g}" for name, value in values.items()) or "its one form"
            columns = tuple(OwnColumn(effect, at.number, k, number, at.sign) for k in range(len(effect.parameters)))
            yield Candidate(effect.id, at.name, form, columns, named(*effect.parameters, **values))

    return candidates


def _samples(terms, effect, joint, shape):
    """Torque at the joint per unit of each parameter, at the samples (parameters, n); 0 outside the segments."""
    out = np.zeros((len(effect.parameters), len(terms.t_s)))
    for number, part in enumerate(terms.processed.parts):
        segment = terms.once(("seen", number), lambda rows=slice(part["begin"], part["end"]): _seen(terms, rows))
        out[:, part["begin"]:part["end"]] = effect.columns(segment, joint, effect.shapes[shape]).T
    _check_size(effect, out)
    return out


def _check_size(effect, columns):
    """A search leaves such columns out without a word, as it must those of a link that has run away."""
    largest = np.abs(columns).max(axis=1)
    for name, size in zip(effect.parameters, largest):
        if size >= LARGEST:
            raise talus.InputError(f"effect {effect.id!r}: its function returned {size:.3g} for {name}, expected less than {LARGEST:g}: "
                                   "choose a smaller unit")  # fmt: skip


def _seen(terms, rows):
    """A part of the recording as the function sees it."""
    instants = [terms.instants(j)[rows] for j in range(terms.dataset.joints)]
    seen = {name: rows_of(instants, name) for name in FROM_INSTANTS}
    seen |= {"t_s": instants[0]["t_s"].copy(), "a": terms.a[:, rows].copy()}
    if terms.dataset.velocity_only:
        seen["q"][:] = np.nan
        seen["motor_rad"][:] = np.nan
    joints = terms.dataset.model.joints
    seen["temp_C"][[f"{name}_temp_C" not in terms.columns for name in joints]] = np.nan
    for values in seen.values():
        values.flags.writeable = False
    return talus.Segment(tuple(joints), **seen)
