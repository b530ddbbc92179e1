"""Viscous friction that is not linear in speed."""

from ..catalogue.candidate import Family
from ..catalogue.sizes import torque
from .entry import Effect

VISCOUS_EXPONENTS = (0.33, 0.5, 0.7, 1.5, 2.0, 3.0)
VISCOUS_KNEES = (0.1, 0.2, 0.4, 0.7)  # of the largest speed


def candidates(at):
    j, speed = at.number, at.extent.speed[at.number]

    def bent(power):
        # below 1 a negative strength would be friction that falls with speed: stribeck's
        low, limits = ((0.0,), ((0.2,), (0.85,))) if power < 1 else (None, ((1.2,), (3.0,)))
        return at.of_law("nonlinear_viscous", f"power {power:g}", [{"size_Nm": 1.0}], {"exponent": power}, low=low,
                         family=Family(bent, (power,), (1.3,), *limits))  # fmt: skip

    def saturating(width):
        return at.of_law("nonlinear_viscous", f"saturating at {width:.3g} rad/s", [{"size_Nm": 1.0}],
                         {"exponent": 1.0, "saturation_rad_s": width}, low=(0.0,),
                         family=Family(saturating, (width,), (1.5,), (0.05 * speed,), (1.5 * speed,)))  # fmt: skip

    yield from map(bent, VISCOUS_EXPONENTS)
    yield from (saturating(float(knee * speed)) for knee in VISCOUS_KNEES)


def size(p):
    if p.get("saturation_rad_s"):
        return f"grows to {torque(p['size_Nm'])}, hardly more beyond {p['saturation_rad_s']:.3g} rad/s"
    return f"{torque(p['size_Nm'])} at 1 rad/s, with the speed to the power of {p['exponent']:.3g}"


EFFECT = Effect(
    id="nonlinear_viscous",
    words="viscous friction that is not proportional to speed",
    candidates=candidates,
    size=size,
    coordinates=("velocity",),
)
