"""A drive's torque beside a sensor at the output: where the two go together, they do so nearly one to one."""

import numpy as np

from talus import ffi, lib

from .finding import Finding

TOGETHER = 0.9  # correlation of the two; elsewhere inertia and friction decide
FAR, NEAR = 3.5, 2.2  # times, of a torque constant: out of the question, and plausible
EACH_SIGN = 0.15  # of the sensor's rows, that either sign must have


def load_findings(model, name, recording):
    """Findings of a joint's current against the sensor at its output."""
    load, joint = recording.columns.get("joint_load_Nm"), model.joints[0]
    column = next((c for c in (f"{joint}_torque_Nm", f"{joint}_current_A") if c in recording.columns), None)
    if load is None or column is None or np.ptp(recording.columns[column]) == 0 or np.ptp(load) == 0:
        return
    torque = recording.columns[column] * (_torque_per_ampere(model) if column.endswith("_A") else 1.0)
    if np.min(torque) >= 0 and _is_unsigned(torque, load):
        yield Finding("unsigned", True, column, f"{name}: never negative, while the sensor at the output changes its sign",
                      "record the current with its sign")  # fmt: skip
    elif abs(np.corrcoef(torque, load)[0, 1]) > TOGETHER:
        yield from _scaled(name, column, float(np.polyfit(load, torque, 1)[0]))


def _torque_per_ampere(model):
    """At the joint."""
    drive, ratio, slope = model.struct.drive[0], ffi.new("double *"), ffi.new("double *")
    lib.tl_transmission_ratio(ffi.addressof(drive, "transmission"), 0.0, ratio, slope)
    return drive.torque_constant_Nm_A * ratio[0]


def _is_unsigned(torque, load):
    if min(np.mean(load > 0), np.mean(load < 0)) < EACH_SIGN:
        return False
    return np.corrcoef(torque * np.sign(load), load)[0, 1] > TOGETHER > abs(np.corrcoef(torque, load)[0, 1])


def _scaled(name, column, slope):
    """A torque so many times the sensor's."""
    told = f"{name}: its torque is {slope:.3g} times that of the sensor at the output"
    if 1 / NEAR < 1e-3 * abs(slope) < NEAR:
        yield Finding("units", True, column, f"{told}, as if it were in thousandths", "convert the column to the unit of its name")
    elif slope < -1 / FAR:
        yield Finding("sign", True, column, told, "turn the sign of one of the two")
