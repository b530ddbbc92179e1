"""Candidates from a law that stands in this folder: torques at the samples."""

from collections.abc import Callable
from dataclasses import dataclass

from ..calibration.replicates import replicable
from ..catalogue.candidate import Candidate, named
from ..effects.entry import Effect


@dataclass(frozen=True)
class Torque:
    """One column: `law(terms, joint, *values)` gives the joint torque for each strength of one, at the samples; this is the
    `number`th of them."""

    law: Callable
    joint: int
    values: tuple
    number: int = 0

    def __call__(self, terms):
        """{channel: column on the grid} of one recording."""
        samples = self.law(terms, self.joint, *self.values)[self.number]
        return {f"T{self.joint}": terms.operated(samples[None], self.joint)[0]}


def candidate(effect, at, law, strengths=("size_Nm",), family=None, **shape):
    """The candidate of one shape at a joint."""
    values = tuple(float(x) for x in shape.values())
    columns = tuple(Torque(law, at.number, values, k) for k in range(len(strengths)))
    form = ", ".join(f"{name} {value:g}" for name, value in shape.items()) or "its one form"
    return Candidate(effect, at.name, form, columns, named(*strengths, **shape), family=family)


def of(name, law, shapes=({},), strengths=("size_Nm",)):
    """`candidates` of a law in some shapes."""
    return lambda at: [candidate(name, at, law, strengths, **shape) for shape in shapes]


def entry(name, words, candidates, size=lambda parameters: ""):
    """An entry of this folder; `candidates(at)` is asked at every joint, `size` says how large it is. Laws as rough as these are trusted
    only where replicates say what they gain from nothing."""

    def tried(at):
        return candidates(at) if replicable(at.dataset) else ()

    return Effect(id=name, words=words, candidates=tried, size=size, outside=True)
