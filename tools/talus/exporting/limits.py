"""--limits, as every program takes it: knee.position=-0.9:0.1,knee.speed=4,knee.torque=60 [rad, rad/s, Nm at the joint]."""

from __future__ import annotations

from dataclasses import dataclass

from talus import Model
from talus.refused import Refused

KINDS = ("position", "speed", "torque", "acceleration")


@dataclass
class Limits:
    """By joint; None where none was given."""

    position: list[tuple[float, float] | None]
    speed: list[float | None]
    torque: list[float | None]


def read(text: str, model: Model) -> Limits:
    n = len(model.joints)
    out = Limits([None] * n, [None] * n, [None] * n)
    for part in filter(None, text.split(",")):
        key, _, value = part.partition("=")
        joint, _, kind = key.strip().partition(".")
        if joint not in model.joints or kind not in KINDS:
            raise Refused(2, f"--limits: {key}: expected one of {', '.join(model.joints)} and of {', '.join(KINDS)}, as in {model.joints[0]}.speed=4")
        numbers = _numbers(key, value, 2 if kind == "position" else 1)
        if kind == "position":
            out.position[model.joints.index(joint)] = (numbers[0], numbers[1])
        elif kind != "acceleration":
            (out.speed if kind == "speed" else out.torque)[model.joints.index(joint)] = numbers[0]
    return out


def _numbers(key: str, value: str, count: int) -> list[float]:
    try:
        numbers = [float(x) for x in value.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(abs(x) < 1e9 for x in numbers) or (numbers[0] >= numbers[1] if count == 2 else numbers[0] <= 0):
        raise Refused(2, f"--limits: {key}: expected {'LOW:HIGH' if count == 2 else 'a number above 0'}, found '{value}'")
    return numbers
