"""Friction that differs between the two directions."""

from ..catalogue.candidate import usual
from ..catalogue.sizes import torque
from .entry import Effect

USUAL_ASYMMETRY = (0.1, 0.4)  # of Coulomb friction
CONSTANT_BY_FRICTION, CONSTANT_OF_A_SHARE = 0.4, 2.5
HARDLY_GROWS = 0.5  # of the constant difference, that the viscous one adds at full speed


def candidates(at):
    dry, viscous, j = {"coulomb_Nm": 1.0}, {"viscous_Nms_rad": 1.0}, at.number
    hardly_grows = lambda constant, slope: abs(slope) * at.extent.speed[j] < HARDLY_GROWS * abs(constant)

    def constant(size):
        """A constant torque is a current's zero more often than friction's: of asymmetries a third do not grow with speed,
        and large ones are as frequent as small ones, while a zero is as often of one order of magnitude as of another."""
        if not at.dataset.at_motor:
            return CONSTANT_BY_FRICTION
        share = abs(size) / at.coulomb_Nm
        return usual(share, *USUAL_ASYMMETRY) * min(CONSTANT_OF_A_SHARE * share, 1.0)

    yield at.of_law("asymmetric_friction", "viscous", [viscous])
    yield at.of_law("asymmetric_friction", "Coulomb", [dry], prior=lambda x: constant(x[0]))
    yield at.of_law("asymmetric_friction", "both", [dry, viscous],
                    prior=lambda x: constant(x[0]) if hardly_grows(*x) else 1.0)  # fmt: skip


def size(p):
    """Its parameters are half of the difference."""
    parts = [(p["coulomb_Nm"], torque, "", "friction"), (p["viscous_Nms_rad"], "{:.3g} Nms/rad".format, "viscous ", "friction")]
    return ", ".join(f"{said(2 * abs(x))} more {kind}{what} in the {'positive' if x > 0 else 'negative'} direction"
                     for x, said, kind, what in parts if x)  # fmt: skip


EFFECT = Effect(
    id="asymmetric_friction",
    words="friction that differs between the two directions",
    candidates=candidates,
    size=size,
    coordinates=("velocity",),
)
