"""Motor torque that is periodic in the motor's angle, whatever the current."""

from ..catalogue.ripple import FEWEST_WAVES_RAD, fades
from ..catalogue.sizes import amplitude, torque
from .entry import Effect

COGGING_ORDERS = (*range(5, 25), 28, 30, 32, 36, 40, 42, 48, 54, 60, 72, 84)
LAST_WITH_OVERTONE = 42


def candidates(at):
    if at.dataset.velocity_only:
        return
    most = at.extent.motor_Nm[at.number] / abs(at.gear)
    ripple, overtone = ("sine_Nm", "cosine_Nm"), ("overtone_sine_Nm", "overtone_cosine_Nm")

    for order, fades_Hz in ((k, f) for k in COGGING_ORDERS for f in fades(at) if k * at.motor_range > FEWEST_WAVES_RAD):
        name = f" per turn, fading at {fades_Hz:g} Hz" if fades_Hz else " per turn"
        shapes = {"per_turn": float(order), "fades_Hz": fades_Hz}
        for orders in ((order,), (order, 2 * order)) if order <= LAST_WITH_OVERTONE else ((order,),):
            names = (ripple + overtone)[:2 * len(orders)]
            yield at.of_law("cogging", " and ".join(map(str, orders)) + name, [{n: 1.0} for n in names], shapes, low=(-most,) * len(names),
                            high=(most,) * len(names), phases_rad=tuple(k * at.motor_range for k in orders))  # fmt: skip


def size(p):
    overtone = amplitude(p, "overtone_sine_Nm", "overtone_cosine_Nm")
    more = f", and {torque(overtone)} twice as often" if overtone else ""
    return f"{torque(amplitude(p, 'sine_Nm', 'cosine_Nm'))} at the motor, {p['per_turn']:.3g} times a turn{more}"


EFFECT = Effect(
    id="cogging",
    words="a motor torque that repeats with the turn, without current",
    candidates=candidates,
    size=size,
    coordinates=("motor_angle",),
    trajectory="fast_multisine",
    several=True,
)
