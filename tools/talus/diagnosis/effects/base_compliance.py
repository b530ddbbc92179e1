"""A mount that turns, sways or rises on a resonance of its own."""

from ..catalogue.candidate import Candidate, Family, named
from ..catalogue.law import BASE, column
from .entry import Effect

BASE_HZ = (2.5, 2.75, 3, 3.25, 3.5, 3.75, 4, 4.25, 4.5, 4.75, 5, 5.25, 5.5, 6, 6.5, 7, 7.5, 8, 9, 10, 11, 12, 13.5, 15)
BASE_DAMPING_RATIOS = (0.02, 0.05, 0.1)
RISING_DAMPING_RATIO = 0.05  # of a second mode, whose resonance is refined


def candidates(at):
    strength = {"turning": "compliance_rad_Nm", "swaying": "sway_m_N", "rising": "rise_m_N"}
    forms = {"turning": ("turning",), "swaying": ("swaying",), "rising": ("rising",), "both": ("turning", "swaying")}

    def mode(form, hz, damping):
        """A form at one resonance."""
        shapes = {"frequency_Hz": float(hz), "damping_ratio": float(damping)}
        own = [strength[one] for one in forms[form]]
        columns = tuple(column("base_compliance", (BASE,), {name: 1.0}, shapes) for name in own)
        return Candidate("base_compliance", at.name, f"{form}, {hz:g} Hz, damping {damping:g}", columns, named(*own, **shapes),
                         (0.0,) * len(own), family=Family(lambda hz, damping: mode(form, hz, damping), (hz, damping),
                         (1.05, 1.6), (1.5, 0.006), (25.0, 0.5)))  # fmt: skip

    for damping in BASE_DAMPING_RATIOS:
        for hz in BASE_HZ:
            yield from (mode(form, hz, damping) for form in forms if form != "rising" or damping == RISING_DAMPING_RATIO)


def size(p):
    moves = (("compliance_rad_Nm", "turns by {:.3g} mrad for 1 Nm"), ("sway_m_N", "sways by {:.3g} mm for 1 N"), ("rise_m_N", "rises by {:.3g} mm for 1 N"))
    said = [text.format(1e3 * p[name]) for name, text in moves if p.get(name)]
    return f"{' and '.join(said)}, swings at {p['frequency_Hz']:.3g} Hz"


EFFECT = Effect(
    id="base_compliance",
    words="a mount that sways",
    candidates=candidates,
    size=size,
    coordinates=("frequency", "acceleration"),
    trajectory="fast_multisine",
    several=True,
)
