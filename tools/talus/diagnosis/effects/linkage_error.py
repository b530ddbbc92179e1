"""Dimensions of the ankle's linkage that are not the model's."""

from talus import lib

from ..catalogue.candidate import Candidate, named
from ..catalogue.law import column
from ..catalogue.sizes import angle
from ..kinds import kind_of
from .entry import Effect


def candidates(at):
    if at.dataset.transmissions[at.number].struct.kind != lib.TL_TRANSMISSION_SCREW_LINKAGE:
        return
    known = {parameter.name: parameter for parameter in kind_of("linkage_error").strengths}
    made = {name: column("linkage_error", (at.number,), {name: 1.0}, {}) for name in known}
    for names in (("AB_m",), ("BO_m",), ("AC_m",), ("BOF_rad",), ("AB_m", "BO_m"), ("BO_m", "AC_m")):
        low, high = zip(*((known[name].low, known[name].high) for name in names))  # two lengths far off make a wave together
        yield Candidate("linkage_error", at.name, " and ".join(names), tuple(made[n] for n in names), named(*names), low, high)


def size(p):
    lengths = {name: x for name, x in p.items() if name.endswith("_m")}
    said = [f"{name.removesuffix('_m')} is {1e3 * abs(x):.3g} mm {'longer' if x > 0 else 'shorter'}" for name, x in lengths.items() if x]
    if p.get("BOF_rad"):
        said.append(f"the angle BOF is off by {angle(p['BOF_rad'])}")
    return ", ".join(said)


EFFECT = Effect(
    id="linkage_error",
    words="a linkage whose dimensions are not the drawing's",
    candidates=candidates,
    size=size,
    coordinates=("position", "encoder"),
    needs="camera",
)
