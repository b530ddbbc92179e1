"""Angles that two columns tell: a velocity beside an angle, an encoder on either side of a drive."""

import numpy as np

from talus import ffi, lib

from .finding import Finding

TOLERANCE = 0.1  # of the slope of one column over the other
AGREES = 0.9  # correlation of two columns that show the same motion
FACTORS = {"units": ((180 / np.pi, "in degrees"), (1 / (2 * np.pi), "in turns")), "sign": ((-1.0, "with the other sign"),)}
COARSE_STEPS = 30  # of the encoder over the whole motion: fewer, and speed and acceleration are noise


def angle_findings(model, name, recording):
    """Findings of one recording's angles beside each other, and of their resolution."""
    for joint, joint_name in enumerate(model.joints):
        yield from _velocity(joint_name, name, recording)
        yield from _encoder(model, joint, joint_name, name, recording)
    yield from _coarse(name, recording)


def _slope(x, y):
    """Slope of y over x, and their correlation."""
    x, y = x - np.mean(x), y - np.mean(y)
    return float(x @ y / (x @ x + 1e-300)), float(abs(x @ y) / np.sqrt((x @ x) * (y @ y) + 1e-300))


def _named(slope, gear):
    """(id, words) of a slope that is not 1."""
    for name, factors in FACTORS.items():
        for factor, words in factors:
            if abs(slope / factor - 1) < TOLERANCE:
                return name, words
    if gear > 1.5 and (abs(abs(slope) * gear - 1) < TOLERANCE or abs(abs(slope) / gear - 1) < TOLERANCE):
        return "ratio", "on the other side of the gear"
    return None


def _velocity(joint, name, recording):
    """The velocity's column over the angle's rate."""
    angle, velocity = (recording.columns.get(f"{joint}_{what}") for what in ("rad", "velocity_rad_s"))
    if angle is None or velocity is None:
        return
    step = max(1, round(0.02 / recording.step_s))
    rate = (angle[step:] - angle[:-step]) / (recording.t[step:] - recording.t[:-step])
    slope, agrees = _slope(rate, velocity[step // 2:len(velocity) - step + step // 2])
    found = _named(slope, 1.0) if agrees > AGREES else None
    if found:
        yield Finding(found[0], True, f"{joint}_velocity_rad_s", f"{name}: {slope:.3g} times the rate of {joint}_rad: {found[1]}",
                      "convert one of the two columns")  # fmt: skip


def _encoder(model, joint, joint_name, name, recording):
    """The encoder at the joint over the motor's angle through the drive."""
    motor, at_joint = (recording.columns.get(f"{joint_name}_{what}") for what in ("motor_rad", "joint_rad"))
    if motor is None or at_joint is None:
        return
    drive, sample = ffi.addressof(model.struct.drive[joint], "transmission"), slice(None, None, max(1, len(motor) // 2000))
    through = np.array([lib.tl_transmission_joint_angle(drive, x) for x in motor[sample]])
    if not np.isfinite(through).all():
        return
    slope, agrees = _slope(through, at_joint[sample])
    raw, raw_agrees = _slope(motor[sample], at_joint[sample])
    gear = abs(float(np.polyfit(through, motor[sample], 1)[0])) if np.ptp(through) > 1e-9 else 1.0
    if raw_agrees > AGREES and abs(raw - 1) < TOLERANCE and gear > 1.5:
        yield Finding("ratio", True, f"{joint_name}_motor_rad", f"{name}: the same angle as {joint_name}_joint_rad, and the drive's ratio is {gear:.0f}",
                      "give the motor's angle in the motor's column and the joint's in the joint's")  # fmt: skip
        return
    found = _named(slope, gear) if agrees > AGREES else None
    if found:
        yield Finding(found[0], True, f"{joint_name}_joint_rad",
                      f"{name}: {slope:.3g} times the motor's angle through the drive: {found[1]}", "convert one of the two columns")  # fmt: skip


def _coarse(name, recording):
    """Few steps of the encoder over the whole motion."""
    for column, x in recording.columns.items():
        if column.endswith("_rad") and np.ptp(x) > 0:
            steps = np.abs(np.diff(x))
            finest = np.min(steps[steps > 1e-9 * np.ptp(x)], initial=np.inf)
            if np.ptp(x) < COARSE_STEPS * finest:
                yield Finding("coarse", False, column, f"{name}: the whole motion is {np.ptp(x) / finest:.0f} steps of {finest:.3g} rad",
                              "move farther, or use a finer encoder")  # fmt: skip
