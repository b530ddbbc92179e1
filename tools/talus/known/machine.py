"""Recordings of real machines, and what a spike needs to know of one: its motion, its torque, and what a plain model leaves of it."""

import csv
import functools
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import talus
import yaml
from scipy.signal import butter, filtfilt

# folder: name of its recordings in short, and the low-pass [Hz] at which its owners, or its README's check, compare torques
SETS = {"emps": ("emps", 40.0), "ur10e_joints": ("ur10e", 8.0), "ak80_9_dyno": ("ak80", 10.0), "embir_dyno": ("embir", 5.0)}
GEARED_RATIO = 6  # of embir's geared trials, as the model's comment asks
HELD = ("stall", "gainday")  # trials with the shaft held
FINER = 4.0  # the effect follows the motion up to so many times the low-pass ...
OF_RATE = 0.2  # ... and up to this share of the sampling rate
ENDS_S = 0.25  # of a recording, where low-passed acceleration is no good
STANDSTILL = 0.005  # of the largest speed: friction turns around within it


def recordings(data):
    """[path] of every real recording in the data folder, by name."""
    found = [path for folder in SETS for path in sorted((Path(data) / folder).glob("*.csv")) if path.name != "trials.csv"]
    if not found:
        raise OSError(f"{data}: no recordings of {', '.join(SETS)} here (TALUS_DATA names the folder)")
    return found


def model_text(recording):
    """The set's model without any `score:`, and with the gear that its comment asks to be put in for some trials."""
    text = (recording.parent / "model.yaml").read_text(encoding="utf-8")
    text = re.sub(r"^score:.*\n(?:[ \t]+.*\n)*", "", text, flags=re.MULTILINE)
    return text.replace("ratio: 1}", f"ratio: {GEARED_RATIO}}}") if "geared" in recording.name else text


def read_columns(path):
    """{name: values} of a CSV file."""
    with open(path, encoding="utf-8") as file:
        header, *rows = csv.reader(line for line in file if not line.startswith("#"))
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


def write_columns(path, columns):
    rows = zip(*(map("{:.9g}".format, values) for values in columns.values()), strict=True)
    path.write_text("\n".join([",".join(columns), *map(",".join, rows)]) + "\n", encoding="utf-8")


@dataclass
class Motion:
    """A recording's angle (or position), speed and acceleration, low-passed, at its rows."""

    position: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray

    @functools.cached_property
    def direction(self):
        """Of the friction: sign of the speed, turning around smoothly within standstill."""
        return np.tanh(self.speed / (STANDSTILL * self.top + 1e-300))

    @functools.cached_property
    def top(self):
        return float(np.quantile(np.abs(self.speed), 0.99))


class Machine:
    """One recording with its model. Columns are given anew where a spike has changed them."""

    def __init__(self, path, columns=None):
        self.path, self.tree = path, yaml.safe_load(model_text(path))
        self.columns = read_columns(path) if columns is None else columns
        self.lowpass_Hz = SETS[path.parent.name][1]
        self.t = self.columns["time_s"]
        self.step_s = float(np.median(np.diff(self.t)))
        inner = (self.t > self.t[0] + ENDS_S) & (self.t < self.t[-1] - ENDS_S)
        self.used = inner & (self.columns.get("valid", np.ones(len(self.t))) != 0)

    @property
    def name(self):
        return f"{SETS[self.path.parent.name][0]}_{self.path.stem.removeprefix(SETS[self.path.parent.name][0] + '_')}"

    @property
    def slider(self):
        return talus.Model(self.tree["plant"]).torque_unit == "N"

    @property
    def angle_column(self):
        """Of the position, or None where only its speed was recorded."""
        return next((name for name in ("slider_m", "joint_rad") if name in self.columns), None)

    @property
    def effort_column(self):
        return "slider_force_N" if self.slider else "joint_current_A"

    @property
    def torque_per_effort(self):
        """Torque at the joint by what the effort's column counts."""
        if self.slider:
            return 1.0
        return self.tree["joint"]["torque_constant_Nm_A"] * self.tree["joint"]["transmission"]["ratio"]

    @property
    def load_sensor(self):
        return "joint_load_Nm" in self.columns

    @property
    def slides(self):
        """Whether it moves: a shaft that is held gives friction no direction."""
        return not any(word in self.path.stem for word in HELD)

    @property
    def gravity(self):
        return not self.slider and self.tree["gravity_moment_kg_m"] != 0

    def drive_torque(self):
        return self.torque_per_effort * self.columns[self.effort_column]

    def measured(self):
        """What the model is held against: the sensor's torque where there is one, else the drive's."""
        return self.columns["joint_load_Nm"] if self.load_sensor else self.drive_torque()

    def low(self, values, frequency_Hz):
        """Low-passed without phase on an even grid, back at the rows."""
        grid = np.arange(self.t[0], self.t[-1], self.step_s)
        b, a = butter(2, min(frequency_Hz * 2 * self.step_s, 0.9))
        return np.interp(self.t, grid, filtfilt(b, a, np.interp(grid, self.t, values)))

    def motion(self, frequency_Hz=None):
        """Up to a frequency, by default as fine as an effect is to follow it."""
        frequency_Hz = frequency_Hz or min(FINER * self.lowpass_Hz, OF_RATE / self.step_s)
        if self.angle_column:
            position = self.low(self.columns[self.angle_column], frequency_Hz)
            speed = np.gradient(position, self.t)
        else:
            speed = self.low(self.columns["joint_velocity_rad_s"], frequency_Hz)
            position = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(self.t))])
        return Motion(position, speed, np.gradient(speed, self.t))

    def plain_columns(self, motion):
        """The plain model's torque terms: inertia, gravity, offset, viscous and Coulomb friction."""
        load = [motion.acceleration]
        if self.gravity:
            load += [np.sin(motion.position), np.cos(motion.position)]
        return np.array(load), np.array([np.ones(len(self.t)), motion.speed, motion.direction])

    def fitted(self):
        """(residual, load) of the plain model's least squares, low-passed: what the gear carries is what inertia, gravity
        and the sensor take. Beside a sensor the torque constant is fitted, too: what that takes shows as nothing else."""
        load, friction = self.plain_columns(self.motion())
        sensor = self.columns["joint_load_Nm"] if self.load_sensor else 0.0
        more = [self.drive_torque()] if self.load_sensor else []
        x = np.array([self.low(column, self.lowpass_Hz) for column in (*load, *friction, *more)])
        y = self.low(self.drive_torque() - sensor, self.lowpass_Hz)
        strengths = np.linalg.lstsq(x[:, self.used].T, y[self.used], rcond=None)[0]
        return y - strengths @ x, strengths[: len(load)] @ load + sensor

    def leaves(self, spiked):
        """How much more of the torque the plain model leaves of the spiked recording, as a share of the torque (RMS)."""
        difference = self.rms(spiked.fitted()[0] - self.fitted()[0])
        return difference / self.rms(self.low(self.measured(), self.lowpass_Hz))

    def rms(self, values):
        return float(np.sqrt(np.mean(values[self.used] ** 2)))
