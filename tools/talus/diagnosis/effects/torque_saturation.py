"""A torque constant that droops at high current."""

from ..catalogue.candidate import BESIDE_A_SENSOR, Family
from ..catalogue.sizes import torque
from .entry import Effect

SATURATION_POWERS = (1, 2, 3, 5)
TENTH = 0.1  # of the current, lost: so much a lab notices
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


def size(p):
    """The motor torque at which the current is a tenth more than that: droop (T - begin)^(1 + exponent) = T / 10."""
    if p.get("begin_Nm", 0.0) > 0.0 or p["exponent"] <= 0.0:
        beyond = f"beyond {torque(p.get('begin_Nm', 0.0))} at the motor"
        return f"{beyond}, {100 * p['droop_1_Nm']:.3g} % more current for further torque" if not p["exponent"] else f"droops {beyond}"
    return f"a tenth more current at {torque((TENTH / p['droop_1_Nm']) ** (1 / p['exponent']))} of the motor"


EFFECT = Effect(
    id="torque_saturation",
    words="a torque constant that droops at high current",
    candidates=candidates,
    size=size,
    coordinates=("current", "load"),
    needs="known mass",
)
