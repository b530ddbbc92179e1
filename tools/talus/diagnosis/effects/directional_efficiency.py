"""A gear's losses in proportion to power, which differ between driving and back-driving."""

import math

from ..catalogue.candidate import COLUMN_PENALTY
from ..catalogue.carried_load import carried_loads, of_other_shares
from ..catalogue.sizes import percent
from .entry import Effect

LARGEST_SHARE = 0.6  # of the load, lost in one direction


def candidates(at):
    """Losses in both directions. What they differ by is a share of the load, which inertia and gravity of a single joint take up: there
    losses in one direction alone may stand for any two."""
    if not at.carries_both_ways:
        return
    both = [{"driving": 1.0}, {"back_driving": 1.0}]
    for name, shares in carried_loads(at):
        yield losses(at, name, both, shares)
        if at.load_is_free:
            yield losses(at, f"{name}, driving alone", both[:1], shares)
            yield losses(at, f"{name}, driven alone", both[1:], shares)


def losses(at, form, columns, shares):
    """One alone is as likely as both."""
    return at.of_law("directional_efficiency", form, columns, shares, low=(0.0,) * len(columns), high=(LARGEST_SHARE,) * len(columns),
                     prior=lambda x: math.exp(COLUMN_PENALTY * (len(columns) - 2)),
                     family=of_other_shares(at, shares, lambda moved: losses(at, form, columns, moved)))  # fmt: skip


def size(p):
    return f"loses {percent(p['driving'])} of the load when driving, {percent(p['back_driving'])} when driven"


EFFECT = Effect(
    id="directional_efficiency",
    words="losses that differ between driving and being driven",
    candidates=candidates,
    size=size,
    coordinates=("load", "current"),
    needs="known mass",
)
