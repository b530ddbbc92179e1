"""A torque constant that droops at high current."""

from ..catalogue.candidate import BESIDE_A_SENSOR, Family
from .entry import Effect

SATURATION_POWERS = (1, 2, 3, 5)
LARGEST_DROOP = 0.8  # of the torque at the largest current
LARGEST_DROOP_SEEN = 0.35  # where a sensor shows the torque itself, and a wrong constant could pass for droop
SATURATION_KNEES = (0.3, 0.5, 0.7)  # of the largest torque


def candidates(at):
    largest = at.extent.motor_Nm[at.number]
    most = LARGEST_DROOP_SEEN if at.dataset.load_sensor else LARGEST_DROOP
    likely = lambda x: BESIDE_A_SENSOR if at.dataset.load_sensor else 1.0

    def bent(power):
        unit = {"droop_1_Nm": abs(at.gear / largest) ** power}  # a share of the largest torque
        return at.of_law("torque_saturation", f"power {power:g}", [unit], {"exponent": float(power)}, low=(0.0,), high=(most,),
                         prior=likely, family=Family(bent, (power,), (1.5,), (0.5,), (8.0,)))  # fmt: skip

    def kinked(knee):
        begin = float(knee * largest)
        shapes = {"exponent": 0.0, "begin_Nm": begin / abs(at.gear)}
        return at.of_law("torque_saturation", f"beyond {begin:.3g} Nm", [{"droop_1_Nm": 1.0}], shapes, low=(0.0,),
                         high=(most / (1 - knee),), family=Family(kinked, (knee,), (0.1,), (0.05,), (0.9,)))  # fmt: skip

    yield from map(bent, SATURATION_POWERS)
    if not at.dataset.load_sensor:
        yield from map(kinked, SATURATION_KNEES)


EFFECT = Effect(
    id="torque_saturation",
    words="a torque constant that droops at high current",
    candidates=candidates,
    coordinates=("current", "load"),
    needs="known mass",
)
