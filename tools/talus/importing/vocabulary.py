"""Which words of a header name which quantity, and which quantity is which column of which plant."""

import functools
import re

from talus.model import Model

# Whole words, and parts of words that languages put together ("Motorstrom"); the longest part decides.
WHOLE = {
    "time": {"t", "time", "ts", "stamp", "timestamp", "zeit", "temps", "tiempo", "tempo", "clock", "uhrzeit", "sec", "seconds"},
    "angle": {"q", "pos", "position", "positions", "angle", "theta", "phi", "enc", "encoder", "alpha", "q1", "th"},
    "velocity": {"vel", "velocity", "speed", "omega", "qd", "dq", "qdot", "w", "rpm", "velocities"},
    "current": {"i", "iq", "cur", "curr", "current", "amp", "amps", "courant", "corriente"},
    "torque": {"torque", "tau", "effort", "moment", "couple", "trq"},
    "load": {"load", "messwelle", "loadcell"},
    "force": {"force", "kraft", "f"},
    "temperature": {"temp", "temperature", "temperatur"},
    "voltage": {"vbus", "ubus", "voltage", "bus", "spannung", "u"},
    "valid": {"valid"},
}
PARTS = {
    "zeit": "time", "timestamp": "time", "时间": "time", "winkel": "angle", "position": "angle", "角度": "angle", "位置": "angle",
    "geschwindigkeit": "velocity", "velocity": "velocity", "drehzahl": "velocity", "速度": "velocity", "strom": "current",
    "current": "current", "电流": "current", "drehmoment": "torque", "moment": "torque", "torque": "torque", "力矩": "torque",
    "扭矩": "torque", "temperatur": "temperature", "温度": "temperature", "spannung": "voltage", "voltage": "voltage",
    "电压": "voltage", "kraft": "force", "weg": "angle", "angle": "angle", "ángulo": "angle", "encoder": "angle",
    "vitesse": "velocity", "courant": "current",
}  # fmt: skip
ORDERED = {"cmd", "command", "commanded", "target", "soll", "setpoint", "ref", "reference", "desired", "des", "goal"}
NOT_MEASURED = {"error", "err", "fehler", "limit", "limits", "max", "min", "status", "seq", "id", "index", "count"}
JOINTS = {"knee": ("knee", "knie", "膝"), "ankle": ("ankle", "knöchel", "knoechel", "sprunggelenk", "踝"), "shank": ("shank", "unterschenkel"),
          "foot": ("foot", "fuß", "fuss")}  # fmt: skip


def words(name):
    """The words of a name, at capitals too: "motorCurrent_A" is motor, current, a."""
    parted = re.sub(r"([a-zäöüß0-9])([A-ZÄÖÜ])", r"\1 \2", name)
    return [word for word in re.split(r"[^0-9a-zäöüßáéíóúñ一-鿿]+", parted.lower()) if word]


def quantity(name):
    """(quantity or None, how sure: 2 a whole word, 1 a part of one)."""
    said = words(name)
    found = [kind for word in said for kind, known in WHOLE.items() if word in known]
    if "load" in found or "output" in said and "torque" in found or "sensor" in said and "torque" in found:
        return "load", 2
    if found:
        return found[-1], 2
    parts = [(len(part), kind, part) for part, kind in PARTS.items() if part in name.lower()]
    if not parts:
        return None, 0
    _, kind, part = max(parts)
    return kind, 2 if any(word.endswith(part) for word in said) else 1  # a compound is what its last part is


def is_ordered(name):
    return any(word in ORDERED or word.startswith(("soll", "cmd")) for word in words(name))


def is_no_measurement(name):
    return bool(NOT_MEASURED & set(words(name)))


@functools.cache
def _has_several_joints(plant):
    return len(Model(plant).joints) > 1


@functools.cache
def _is_linear(plant):
    """Does it move along a line, and not about an axis?"""
    return Model(plant).coordinate_unit == "m"


def ordered_column(plant, kind):
    """The column of what such a quantity was ordered to be, or None."""
    return "slider_command_m" if _is_linear(plant) and kind in ("angle", "length") else None


def caution(plant, kind, name):
    """Why a quantity of this name may not be the recording's, or None."""
    said = set(words(name))
    single = plant and not _has_several_joints(plant) and not _is_linear(plant)
    if single and kind in ("angle", "velocity") and said & {"motor", "rotor"}:
        return "may be the rotor's (ratio x joint), and not the joint's"
    if kind == "current" and said & {"bus", "supply", "battery", "dc", "input"}:
        return "may be the supply's current, and not the motor's"
    return None


def joint_of(name):
    return next((joint for joint, known in JOINTS.items() if any(part in name.lower() for part in known)), None)


def column_of(plant, kind, name):
    """The column of a plant's recording that such a quantity is, or None."""
    if kind == "time" or kind == "valid":
        return {"time": "time_s", "valid": "valid"}[kind]
    if kind == "voltage":
        return "bus_V" if not _is_linear(plant) else None
    if _is_linear(plant):
        return {"angle": "slider_m", "length": "slider_m", "force": "slider_force_N"}.get(kind)
    if not _has_several_joints(plant):
        return {"angle": "joint_rad", "velocity": "joint_velocity_rad_s", "current": "joint_current_A", "torque": "joint_torque_Nm",
                "load": "joint_load_Nm", "temperature": "joint_temp_C"}.get(kind)  # fmt: skip
    joint = joint_of(name)
    if joint in ("shank", "foot"):
        return f"{joint}_rad" if kind == "angle" else None
    if joint is None:
        return None
    if kind == "angle":
        at_joint = {"joint", "gelenk", "abs", "absolute", "output"} & set(words(name))
        return "ankle_joint_rad" if joint == "ankle" and at_joint else None if at_joint else f"{joint}_motor_rad"
    return {"current": f"{joint}_current_A", "temperature": f"{joint}_temp_C"}.get(kind)
