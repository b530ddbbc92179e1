"""Friction that grows with the torque that the gear carries."""

import numpy as np

from ..catalogue.candidate import Family, usual
from ..catalogue.carried_load import carried_loads, of_other_shares
from ..catalogue.law import law_at
from ..catalogue.sizes import percent, torque
from .entry import Effect

LARGEST_SHARE = 0.9  # of the load: a gear that loses all of it is not driven back any more
USUAL_SHARE = 0.25  # at the most
LOAD_POWERS = (1.5, 2.0)
OWN_COEFFICIENTS, OWN_WITHIN = (0.05, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4), 1.2


def candidates(at):
    if not at.carries_both_ways:
        return
    for name, shares in carried_loads(at):
        yield _of_the_load(at, name, shares)
        scale = _usual_load(at, shares)
        for power in LOAD_POWERS:
            yield _of_the_load(at, f"{name}, power {power:g}", {"exponent": power, "scale_Nm": scale, **shares})
    for own in () if at.dataset.load_sensor else OWN_COEFFICIENTS:
        yield _of_the_motors_torque(at, own)


def _of_the_load(at, form, shapes):
    return at.of_law("load_friction", form, [{"coefficient": 1.0}], shapes, low=(0.0,), high=(LARGEST_SHARE,), prior=_prior(at),
                     family=of_other_shares(at, shapes, lambda moved: _of_the_load(at, form, moved)))  # fmt: skip


def _prior(at):
    """Where inertia and gravity take up what losses differ by in the two directions, only the size tells which of them these are."""
    return (lambda strengths: usual(strengths[0], 0.0, USUAL_SHARE)) if at.load_is_free else None


def _usual_load(at, shares):
    """RMS over all recordings: a friction that grows faster than the load is a larger share of it at its peaks."""
    grown = [law_at(terms, at.number, "load_friction", "coefficient", shares) for terms in at.all_terms]
    return float(np.sqrt(np.mean(np.concatenate(grown) ** 2))) + 1e-12


def _of_the_motors_torque(at, own):
    """Friction that the motor's torque makes carries itself: T = X + c |T| slip, solved for T with the coefficient `own`, of
    which the strength found must come near."""
    shapes = {"rotor_share": 1.0, "friction_share": 1.0, "own_coefficient": float(own)}
    make = lambda own: _of_the_motors_torque(at, own)
    return at.of_law("load_friction", f"the motor's, {own:g}", [{"coefficient": 1.0}], shapes, low=(own / OWN_WITHIN,),
                     high=(own * OWN_WITHIN,), prior=_prior(at), family=Family(make, (own,), (1.3,), (0.03,), (0.5,)))  # fmt: skip


def size(p):
    at = f" at {torque(p['scale_Nm'])}, more beyond" if p.get("exponent", 1.0) != 1.0 else ""
    return f"{percent(p['coefficient'])} of the load that the gear carries{at}"


EFFECT = Effect(
    id="load_friction",
    words="friction that grows with the load",
    candidates=candidates,
    size=size,
    coordinates=("load", "current", "acceleration"),
    needs="known mass",
)
