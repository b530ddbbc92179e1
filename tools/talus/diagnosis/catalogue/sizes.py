"""How large an effect is, in words that need no formula: what an effect's `size` is made of."""

import math


def torque(x):
    return f"{1e3 * x:.3g} mNm" if abs(x) < 0.1 else f"{x:.3g} Nm"


def angle(x):
    return f"{1e3 * x:.3g} mrad ({math.degrees(x):.2g}°)"


def percent(share):
    return f"{100 * share:.3g} %"


def change(share, what):
    """A share of something, more or less than it was."""
    return f"{percent(abs(share))} {'more' if share > 0 else 'less'} {what}"


def amplitude(parameters, sine, cosine):
    """Of a wave, by its two parts; 0 where it has none."""
    return math.hypot(parameters.get(sine, 0.0), parameters.get(cosine, 0.0))


def of_friction(parameters, every, dry):
    """(share, "friction" or "Coulomb friction") of an effect that changes all friction or the dry part alone; None of others."""
    for name, what in ((every, "friction"), (dry, "Coulomb friction")):
        if name in parameters:
            return parameters[name], what
    return None
