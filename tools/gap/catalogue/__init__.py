"""Candidates: every effect of the catalogue at every joint where it makes sense, each in several shapes."""

from . import drive, friction, leg, transmission
from .candidate import Candidate, Place


def candidates(evidence, scenes, extent):
    """All candidates of a diagnosis. A new effect is one function in one of the tables EFFECTS."""
    out = []
    for number, name in enumerate(evidence.model.joints):
        at = Place(number, name, evidence, extent, scenes)
        for effect in (*friction.EFFECTS, *drive.EFFECTS, *transmission.EFFECTS):
            out.extend(effect(at))
    for effect in leg.EFFECTS if evidence.leg else ():
        out.extend(effect(evidence, scenes))
    return out


__all__ = ["Candidate", "Place", "candidates"]
