"""Transmission error of a harmonic drive, periodic in its wave generator's turn."""

from ..catalogue.ripple import FEWEST_WAVES_RAD, fades
from ..catalogue.sizes import amplitude, angle, percent, torque
from .entry import Effect


def candidates(at):
    if at.dataset.velocity_only or not at.dataset.model.facts.motor:
        return

    def ripple(form, of, shapes):
        return at.of_law("kinematic_error", form, [{f"{wave}_{of}": 1.0} for wave in ("sine", "cosine")], shapes)

    for order in (k for k in (1, 2, 4) if k * at.motor_range > FEWEST_WAVES_RAD):
        for fades_Hz in fades(at):
            name = f", fading at {fades_Hz:g} Hz" if fades_Hz else ""
            yield ripple(f"torque, {order} per turn{name}", "Nm", {"per_turn": float(order), "fades_Hz": fades_Hz})
        shapes = {"per_turn": float(order), "fades_Hz": fades(at)[-1]}
        yield ripple(f"share of the load, {order} per turn", "share", shapes)
        if at.dataset.at_motor:
            yield ripple(f"angle, {order} per turn", "rad", {"per_turn": float(order)})


def size(p):
    said = {"Nm": torque, "rad": angle, "share": lambda x: f"{percent(x)} of the load"}
    waves = {unit: amplitude(p, f"sine_{unit}", f"cosine_{unit}") for unit in said}
    return ", ".join(f"{said[unit](x)}, {p['per_turn']:.3g} times a turn of the motor" for unit, x in waves.items() if x)


EFFECT = Effect(
    id="kinematic_error",
    words="a transmission error that repeats with the motor's turn",
    candidates=candidates,
    size=size,
    coordinates=("motor_angle",),
    trajectory="fast_multisine",
    several=True,
)
