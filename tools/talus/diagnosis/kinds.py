"""The library's table of effects: the names, ranges and order of each one's parameters."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from talus import ffi, lib


@dataclass(frozen=True)
class Parameter:
    name: str
    low: float
    high: float
    default_value: float | None  # of one that a model file may leave out


@dataclass(frozen=True, eq=False)
class Kind:
    """An effect of the table: its strengths, and the shapes of its law."""

    struct: object
    strengths: tuple
    shapes: tuple

    @property
    def parameters(self):
        return self.strengths + self.shapes

    def shape(self, values):
        """Shapes by name, as the library takes them."""
        named = {p.name: p.default_value for p in self.shapes} | values
        assert len(named) == len(self.shapes), (sorted(values), self.shapes)
        return np.array([float(named[p.name]) for p in self.shapes])

    def number(self, name):
        """Place of a strength."""
        return [p.name for p in self.strengths].index(name)


@lru_cache(None)
def kind_of(effect):
    """The effect of that name; KeyError if the library has none."""
    struct = lib.tl_effect_find(effect.encode())
    if struct == ffi.NULL:
        raise KeyError(effect)
    every = tuple(_parameter(struct.parameter[k]) for k in range(struct.strengths + struct.shapes))
    return Kind(struct, every[:struct.strengths], every[struct.strengths:])


def ids():
    """Ids of all effects, in the library's order."""
    count = ffi.new("int *")
    table = lib.tl_effect_table(count)
    return [ffi.string(table[k].name).decode() for k in range(count[0])]


def is_known(effect):
    """Has the library an effect of that name? It has none of one's own."""
    return lib.tl_effect_find(effect.encode()) != ffi.NULL


def applies(effect, model, joint):
    """Can the effect stand at this joint of the model (by number; TL_MAX_JOINTS: the base)?"""
    return bool(lib.tl_effect_applies(kind_of(effect).struct, model.struct, joint))


def _parameter(p):
    optional = p.flags & lib.TL_PARAMETER_OPTIONAL
    return Parameter(ffi.string(p.name).decode(), p.low, p.high, p.default_value if optional else None)
