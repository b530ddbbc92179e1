"""A gear's losses in proportion to power, which differ between driving and back-driving."""

import math

from ..catalogue.candidate import COLUMN_PENALTY, usual
from ..catalogue.carried_load import carried_loads, of_other_shares
from ..catalogue.sizes import percent
from .entry import Effect

LARGEST_SHARE = 0.6  # of the load, lost in one direction
USUAL_SHARE = 0.43  # at the most: an efficiency of 70 %
NOT_SIMPLE = 0.98  # as likely as one loss for both directions, where nothing tells them apart


def candidates(at):
    """Losses in both directions, or in one alone: readings may give the other one a loss below nothing. What they differ by is a share
    of the load, which inertia and gravity of a single joint take up: there all pairs of losses are alike, and two stand for them."""
    if not at.carries_both_ways:
        return
    driving, driven = {"driving": 1.0}, {"back_driving": 1.0}
    for name, shares in carried_loads(at):
        if at.load_is_free:
            yield losses(at, f"{name}, more when driving", [{"driving": 1.0, "back_driving": 0.5}], shares)
            yield losses(at, f"{name}, more when driven", [{"driving": 0.5, "back_driving": 1.0}], shares)
            continue
        yield losses(at, name, [driving, driven], shares)
        if not at.dataset.load_sensor:  # beside which a wrong constant would do the same
            yield losses(at, f"{name}, driving alone", [driving], shares)
            yield losses(at, f"{name}, driven alone", [driven], shares)


def losses(at, form, columns, shares):
    return at.of_law("directional_efficiency", form, columns, shares, low=(0.0,) * len(columns), high=(LARGEST_SHARE,) * len(columns),
                     prior=lambda x: _likely(at, x),
                     family=of_other_shares(at, shares, lambda moved: losses(at, form, columns, moved)))  # fmt: skip


def _likely(at, strengths):
    """By the size alone where nothing else tells it from one loss for both directions; else one alone is as likely as both."""
    if at.load_is_free:
        return NOT_SIMPLE * usual(strengths[0], 0.0, USUAL_SHARE)
    return math.exp(COLUMN_PENALTY * (len(strengths) - 2))


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
