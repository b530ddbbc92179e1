"""Angles that two columns tell: a velocity beside an angle, an encoder on either side of a drive."""

import numpy as np

from talus import ffi, lib

from .finding import Finding
from .samples import finest_step, shows

TOLERANCE = 0.1  # of the slope of one column over the other
ANOTHER_RATIO = 0.25  # of the slope: no play, twist or wrong length of a linkage makes so much
AGREES = 0.9  # correlation of two columns that show the same motion
SURELY, SAME = 0.98, 1e-6  # two correlations that differ by rounding: a drive of constant ratio bends no angle
DEGREES, TURNS = 180 / np.pi, 1 / (2 * np.pi)
UNITS = ((DEGREES, "in degrees"), (TURNS, "in turns"))
RATES_OVER_S, FEWEST_RATES = (0.02, 0.1, 0.5), 100
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


def _is(slope, factor):
    return abs(slope / factor - 1) < TOLERANCE


def _named(slope, column, other, other_words):
    """(id, column, words) of a slope of `column` over `other` that is not 1, where a unit or a sign explains it."""
    for factor, words in UNITS:
        if _is(slope, factor):
            return "units", column, f"it is {words}"
        if _is(slope, 1 / factor):
            return "units", other, f"{other_words} is {words}"
    return ("sign", column, "it is with the other sign") if _is(slope, -1.0) else None


def _velocity(joint, name, recording):
    """The velocity's column over the angle's rate."""
    columns = [f"{joint}_velocity_rad_s", f"{joint}_rad"]
    velocity, angle = map(recording.columns.get, columns)
    if angle is None or velocity is None or not (shows(angle) and shows(velocity)):
        return
    slope, agrees = max((_rates(recording, angle, velocity, over_s) for over_s in RATES_OVER_S), key=lambda one: one[1])
    found = _named(slope, *columns, "the angle") if agrees > AGREES else None
    if found:
        yield Finding(found[0], True, found[1], f"{name}: {columns[0]} is {slope:.3g} times the rate of {columns[1]}: {found[2]}",
                      "convert one of the two columns")  # fmt: skip
    elif agrees > SURELY and abs(np.log(abs(slope) + 1e-300)) > np.log(1 + ANOTHER_RATIO):
        yield Finding("units", False, columns[0], f"{name}: {columns[0]} is {slope:.3g} times the rate of {columns[1]}",
                      "find out which of angle, speed and time is scaled; the angle and the time were used")  # fmt: skip


def _rates(recording, angle, velocity, over_s):
    """Slope and correlation of the velocity's mean over the angle's rate, both over so many seconds: short ones show a fast motion,
    long ones a slow motion through a coarse encoder."""
    t, step = recording.t, max(1, round(over_s / recording.step_s))
    way = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(t))])
    took = t[step:] - t[:-step]
    whole = took < 1.5 * step * recording.step_s  # no rows lost
    if whole.sum() < FEWEST_RATES:
        return 1.0, 0.0
    return _slope(((angle[step:] - angle[:-step]) / took)[whole], ((way[step:] - way[:-step]) / took)[whole])


def _encoder(model, joint, joint_name, name, recording):
    """The encoder at the joint over the motor's angle through the drive."""
    columns = [f"{joint_name}_joint_rad", f"{joint_name}_motor_rad"]
    at_joint, motor = map(recording.columns.get, columns)
    if motor is None or at_joint is None or not (shows(motor) and shows(at_joint)):
        return
    sample = slice(None, None, max(1, len(motor) // 2000))
    drive = Drive(model, joint, motor[sample], at_joint[sample])
    found = drive.mistaken(*columns)
    if found:
        yield Finding(found[0], True, found[1], f"{name}: {columns[0]} and {columns[1]} do not belong together: {found[2]}",
                      "convert one of the two columns, or correct the drive in the model file")  # fmt: skip


class Drive:
    """A drive with the angles that were recorded on both of its sides."""

    def __init__(self, model, joint, motor, at_joint):
        self.transmission, self.motor, self.at_joint = ffi.addressof(model.struct.drive[joint], "transmission"), motor, at_joint
        middle, slope = ffi.new("double *"), ffi.new("double *")
        lib.tl_transmission_ratio(self.transmission, 0.0, middle, slope)
        self.gear = abs(middle[0])

    def through(self, factor=1.0):
        """Slope of the joint's angle over the motor's times a factor, through the drive, and their correlation; nothing where
        the drive cannot stand there."""
        angle = np.array([lib.tl_transmission_joint_angle(self.transmission, factor * x) for x in self.motor])
        return _slope(angle, self.at_joint) if np.isfinite(angle).all() else (0.0, 0.0)

    def stands_there(self):
        """Can the joint be where its encoder says? A motor's angle goes beyond a linkage, or beyond a turn."""
        motor = np.array([lib.tl_transmission_motor_angle(self.transmission, x) for x in self.at_joint])
        return bool(np.isfinite(motor).all() and np.ptp(self.at_joint) < 2 * np.pi)

    def mistaken(self, at_joint, at_motor):
        """(id, column, words) of what is mistaken, or None."""
        (raw, raw_agrees), (slope, agrees) = _slope(self.motor, self.at_joint), self.through()
        if raw_agrees > max(AGREES, agrees - SAME) and _is(raw, 1.0) and self.gear > 1.5:
            return "ratio", at_motor, f"both are the same angle, and the drive's ratio is {self.gear:.0f}"
        if agrees > AGREES:
            return self._by_slope(slope, agrees, at_joint, at_motor)
        for factor, words in UNITS:  # the angle is beyond what the drive can be at
            slope, agrees = self.through(1 / factor)
            if agrees > AGREES and _is(slope, 1.0):
                return "units", at_motor, f"the motor's angle is {words}"
        return None

    def _by_slope(self, slope, agrees, at_joint, at_motor):
        found = _named(slope, at_joint, at_motor, "the motor's angle")
        told = f"the joint's angle is {slope:.3g} times the motor's through the drive"
        if found:
            return found[0], found[1], f"{told}: {found[2]}"
        if self.gear > 1.5 and _is(abs(slope), self.gear):
            if self.stands_there():
                return "ratio", at_motor, f"{told}: the motor's is on the other side of the gear"
            return "ratio", at_joint, f"{told}: it is on the other side of the gear"
        if agrees > SURELY and abs(np.log(abs(slope) + 1e-300)) > np.log(1 + ANOTHER_RATIO):
            return "ratio", at_joint, f"{told}: the drive's ratio is another one than the model file's"
        return None


def _coarse(name, recording):
    """Few steps of the encoder over the whole motion."""
    for column, x in recording.columns.items():
        if column.endswith("_rad") and np.ptp(x) > 0:
            finest = finest_step(x)
            if np.ptp(x) < COARSE_STEPS * finest:
                yield Finding("coarse", False, column, f"{name}: the whole motion is {np.ptp(x) / finest:.0f} steps of {finest:.3g} rad",
                              "move farther, or use a finer encoder")  # fmt: skip
