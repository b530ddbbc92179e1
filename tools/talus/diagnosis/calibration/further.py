"""How sure each further effect is: that it is this one rather than a rival in its place, that what it gains is not nothing, that
another low-pass shows it as well, and that it has the same size everywhere. It is judged as the first one is, in its own place beside all
the others."""

from .. import verdict as first
from .halves import is_uneven
from .thresholds import NEARLY_HALF
from .stability import survives


def judged(search, verdict, elsewhere):
    """The verdict with each further effect at its likeliest, and `further` {(effect, joint): its probability where something of
    the catalogue is the cause}. `elsewhere` holds the recordings through another low-pass, or is None."""
    for place in range(1, len(verdict.fit.chosen)):
        probability, fit, doubts = one(search, verdict.fit, place, elsewhere)
        verdict.fit, key = fit, fit.chosen[place].key
        verdict.further[key], verdict.doubts[key] = probability, doubts
    return verdict


def one(search, fit, place, elsewhere):
    """(probability, fit, doubts) of the effect at a place, or of the rival that does as well there."""
    own, others = fit.chosen[place], [c for c in fit.chosen if c is not fit.chosen[place]]
    in_front = search.fit([own, *others])
    rivals = first.rivals(search, in_front)
    shares = first.shares(search, in_front, rivals, first.other_sets(search, in_front))
    likeliest, chosen = max(zip(shares[: len(rivals)], rivals, strict=True), key=lambda pair: pair[0])
    probability = likeliest * (1.0 - search.further.get(own.key, 0.0))
    in_front = search.fit([chosen.chosen[-1], *others])
    doubts = ["uneven"] if is_uneven(search, chosen) else []
    doubts += ["lowpass"] if elsewhere and not survives(search, in_front, rivals, elsewhere) else []
    return min(probability, NEARLY_HALF if doubts else 1.0), search.fit([*others[:place], chosen.chosen[-1], *others[place:]]), doubts
