"""A torque constant that is wrong by a factor, which a torque sensor at the output shows."""

from ..catalogue.candidate import Candidate, named
from ..catalogue.sizes import change
from .entry import Effect


def candidates(at):
    if not at.dataset.load_sensor:
        return
    j = at.number
    gain = at.reading_column(lambda s: s.given_drive_Nm[j])
    # the reading is the load: the drive gives (1 + excess) of what its constant says
    yield Candidate("torque_constant", at.name, "scale", (gain,), named("excess"), (-0.6,), (1.5,))


def size(p):
    return f"the drive gives {change(p['excess'], 'torque')} than its constant says"


EFFECT = Effect(
    id="torque_constant",
    words="a torque constant that is not the given one",
    candidates=candidates,
    size=size,
    needs="known mass",
    scales_drive=True,
)
