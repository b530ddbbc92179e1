"""Effects beside the machine that the model file draws. A line less gravity's sine is a cube: beside a gravity that is free a spring of
another form does as well, and its size says little."""

import math

from ..shapes import refined
from .pushes_back import pushes_away


def against(search, fit, temperature, least=-math.inf):
    """Twice the logarithm of how unlikely a fit is: what it leaves, `least` or more, and a machine that is not the model file's."""
    return max(fit.excess, least) / temperature + search.off_drawing(fit, temperature)


def shaped(search, fit, place, temperature):
    """The fit with one effect in the shape of the grid that is likeliest with its machine, or as it is."""
    old, others = fit.chosen[place], [*fit.chosen[:place], *fit.chosen[place + 1:]]
    best, least = fit, against(search, fit, temperature)
    shapes = search.beside(others, [c for c in search.gram.candidates if c.key == old.key])
    for one in sorted(shapes, key=lambda one: one.excess):
        if one.excess / temperature >= least:
            break
        if (found := against(search, one, temperature)) < least:
            best, least = one.last_moved(place), found
    return best


def of_torques(search, fit):
    """Likelihood temperature of the torques alone, which tell inertia and gravity: a fine encoder's gap can be a million times theirs."""
    plain, mine = search.held_out_excess([]), search.held_out_excess(fit.chosen)
    torques = [kind for kind in search.dataset.kinds if kind[0] == "T"]
    return search.temperature(sum(mine[k] - search.tolerated_of[k] for k in torques), sum(plain[k] for k in torques))


def beside_drawing(search, fit):
    """(search, fit) that sizes are told by: the effects in the shapes that are likeliest with their machine, and with inertia and gravity
    near the drawn ones where a drawing is likelier than a first guess: not beside a spring that would push away for gravity's sake."""
    temperature, found = of_torques(search, fit), fit
    for place in range(len(fit.chosen)):
        found = shaped(search, found, place, temperature)
    if not fit.chosen or not search.gram.is_drawn(search.columns(found.chosen), temperature):
        return search, fit
    near = search.as_drawn(temperature)
    beside = near.fit(found.chosen)
    for place, old in enumerate(fit.chosen):
        if found.chosen[place] is not old:
            beside = refined(near, beside, place)
    odd = [c.key for c in fit.chosen if pushes_away(near, beside, c.key) and not pushes_away(search, fit, c.key)]
    return (near, beside) if beside.is_physical() and not odd else (search, fit)
