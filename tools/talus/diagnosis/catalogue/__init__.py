"""Candidates: an effect at a joint with one shape, as columns that are linear in its strengths."""

from collections import Counter

from .candidate import Candidate
from .place import Place

FEWEST_SHAPES = 4  # of an effect at a joint, that are all tried in a first look
SPARSE, SPARSE_FAMILY = 1 / 2, 1 / 3  # of more shapes every second; of those that are refined afterwards every third
GOLDEN = (5**0.5 - 1) / 2  # whose multiples have no period that a grid's loops could have, too


def sparse(every, whole=()):
    """About every second or third shape of each effect at each joint, for a first look, with every value of each of its
    loops; all of the (effect, joint) in `whole`, and all other starts: there are few, far apart."""
    count, seen, out = Counter(c.key for c in every), Counter(), []
    for candidate in every:
        share = SPARSE_FAMILY if candidate.family else SPARSE
        few = count[candidate.key] <= FEWEST_SHAPES or candidate.key in whole
        if few or seen[candidate.key] * GOLDEN % 1 < share or (candidate.family and candidate.family.start):
            out.append(candidate)
        seen[candidate.key] += 1
    return out


__all__ = ["Candidate", "Place", "sparse"]
