"""A bench, or its encoders' zero, that is tilted against gravity."""

from ..catalogue.candidate import Candidate, named, usual
from ..catalogue.law import column
from ..catalogue.sizes import angle
from .entry import Effect

USUAL_TILT_RAD = (0.017, 0.087)


def candidates(at):
    tilt = column("gravity_tilt", (0, 1), {"tilt_rad": 1.0}, {})
    yield Candidate("gravity_tilt", at.name, "tilt", (tilt,), named("tilt_rad"), (-0.2,), (0.2,),
                    prior=lambda x: usual(abs(x[0]), *USUAL_TILT_RAD))  # fmt: skip


def size(p):
    return f"leans by {angle(p['tilt_rad'])}"


EFFECT = Effect(
    id="gravity_tilt",
    words="a bench that is not upright",
    candidates=candidates,
    size=size,
    coordinates=("position",),
    needs="turned base",
    turns_gravity=True,
)
