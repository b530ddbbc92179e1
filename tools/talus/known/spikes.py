"""Effects added to what a real machine's sensors recorded. For inverse dynamics an added torque is exact: the drive would have needed
so much more current for the very same motion. The forms are this file's own, not those that the diagnosis fits."""

import itertools
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import running, spike_sizes
from .machine import Machine, model_text, read_columns, recordings, write_columns

SHARES = (0.02, 0.05, 0.10, 0.20, 0.40)  # of the torque, left beyond the plain model
WITHIN = 0.1  # of the share that is wanted
STEPS = 6  # of the search for the strength
LARGEST = 1.0  # an added torque may be as large as the torque (RMS): what needs more is hidden by the plain model
FARTHEST_rad = 0.05  # of an angle


# Each form: (machine, motion, strength, rng) -> {column: values}. Torques are in units of the measured torque's RMS.


def torque(shape):
    """A form that adds a torque: strength times `shape(machine, motion, rng)`, of about unit size."""

    def added(machine, motion, strength, rng):
        more = strength * machine.rms(machine.measured()) * shape(machine, motion, rng)
        return {machine.effort_column: machine.columns[machine.effort_column] + more / machine.torque_per_effort}

    return added


def over_range(machine, motion):
    """Position from -1 to 1 over its range."""
    low, high = np.quantile(motion.position[machine.used], (0.001, 0.999))
    return (2 * motion.position - low - high) / max(high - low, 1e-12)


def wave(machine, motion, rng):
    turns, phase = rng.uniform(0.6, 1.6), rng.uniform(0, 2 * np.pi)
    return np.sin(np.pi * turns * over_range(machine, motion) + phase) * motion.direction


def of_load(machine, motion, rng):
    load = machine.fitted()[1]
    return np.abs(load) / machine.rms(load) * motion.direction


def teeth(machine, motion, rng):
    order, phase = rng.choice([6, 7, 12, 14]), rng.uniform(0, 2 * np.pi)
    return np.cos(order * machine.tree["joint"]["transmission"]["ratio"] * motion.position + phase)


def drift(machine, motion, rng):
    tau_s = (machine.t[-1] - machine.t[0]) * rng.uniform(0.15, 0.4)
    return np.exp(-(machine.t - machine.t[0]) / tau_s) * motion.direction


def droop(machine, motion, strength, rng):
    """A current that shows more than the torque, in proportion to itself."""
    current = machine.columns[machine.effort_column]
    return {machine.effort_column: current * (1 + strength * np.abs(current) / np.abs(current[machine.used]).max())}


def late(machine, motion, strength, rng):
    """A current that is shown later than the angle."""
    return {machine.effort_column: np.interp(machine.t - strength * spike_sizes.LATEST_S, machine.t, machine.columns[machine.effort_column])}


def eccentric(machine, motion, strength, rng):
    """An encoder whose disc sits off its centre: angle and speed are wrong by one wave a turn."""
    phase, size_rad = rng.uniform(0, 2 * np.pi), FARTHEST_rad * strength
    columns, angle = machine.columns, machine.columns["joint_rad"]
    out = {"joint_rad": angle + size_rad * np.sin(angle + phase)}
    if "joint_velocity_rad_s" in columns:
        out["joint_velocity_rad_s"] = columns["joint_velocity_rad_s"] * (1 + size_rad * np.cos(angle + phase))
    return out


@dataclass(frozen=True)
class Form:
    """`applies(machine)`: whether this machine can have it; `size`: how a report tells how large it is."""

    effect: str
    spike: object
    applies: object = lambda machine: True
    alias: tuple = ()
    size: spike_sizes.Size | None = None


def slides(machine):
    return machine.slides


def has_angle(machine):
    return machine.angle_column is not None and machine.slides


def turns(machine):
    return has_angle(machine) and not machine.slider


FORMS = {
    "stribeck_exponential": Form(
        "stribeck", torque(lambda m, x, rng: np.exp(-np.abs(x.speed) / (0.1 * x.top)) * x.direction), slides),
    "stribeck_gaussian": Form(
        "stribeck", torque(lambda m, x, rng: np.exp(-((x.speed / (0.15 * x.top)) ** 2)) * x.direction), slides),
    "viscous_quadratic": Form("nonlinear_viscous", torque(lambda m, x, rng: (x.speed / x.top) ** 2 * x.direction), slides),
    "viscous_levelling": Form(
        "nonlinear_viscous", torque(lambda m, x, rng: np.tanh(np.abs(x.speed) / (0.3 * x.top)) * x.direction), slides),
    "asymmetric_viscous": Form("asymmetric_friction", torque(lambda m, x, rng: np.abs(x.speed) / x.top), slides, size=spike_sizes.ASYMMETRY),
    "position_wave": Form("position_friction", torque(wave), has_angle),
    "load_proportional": Form(
        "load_friction", torque(of_load), lambda m: m.slides and (m.load_sensor or m.gravity), ("directional_efficiency",),
        spike_sizes.OF_LOAD),
    "drift_exponential": Form("friction_drift", torque(drift), slides),
    "spring_cubic": Form("parallel_spring", torque(lambda m, x, rng: over_range(m, x) ** 3), has_angle),
    "spring_bumper": Form("parallel_spring", torque(lambda m, x, rng: np.maximum(over_range(m, x) - 0.2, 0.0)), has_angle,
                          size=spike_sizes.BUMPER),
    "cogging": Form("cogging", torque(teeth), turns, size=spike_sizes.TEETH),
    "saturation": Form("torque_saturation", droop, lambda m: not m.slider),
    "late_current": Form("delay", late, size=spike_sizes.LATE),
    "eccentric": Form("encoder_eccentricity", eccentric, lambda m: turns(m) and m.gravity),
}  # fmt: skip


@dataclass(frozen=True)
class Spike:
    """An effect to be added to a recording; without a form it is the control, the recording as it is."""

    path: Path
    machine: str
    form: str = ""
    share: float = 0.0
    seed: int = 0

    @property
    def name(self):
        return f"{self.machine}-{self.form}-{1000 * self.share:03.0f}" if self.form else f"{self.machine}-control"

    @property
    def setting(self):
        effect = FORMS[self.form].effect if self.form else ""
        return {"machine": self.machine, "form": self.form, "effect": effect, "share": self.share}

    def added(self, machine, motion, strength):
        """The recording's columns with the effect in them: the same draw for every strength."""
        rng = np.random.default_rng([self.seed, *self.name.encode()])
        return {**machine.columns, **FORMS[self.form].spike(machine, motion, strength, rng)}

    def columns(self):
        """(columns, strength, share that it leaves), or None where the plain model hides the effect up to the largest strength."""
        machine, strength = Machine(self.path), 0.1
        motion = machine.motion()
        for _ in range(STEPS):
            spiked = self.added(machine, motion, strength)
            leaves = machine.leaves(Machine(self.path, spiked))
            if abs(leaves / self.share - 1) < WITHIN:
                return spiked, strength, leaves
            strength *= self.share / max(leaves, 1e-9)
            if not strength <= LARGEST:
                return None
        return None


def draw(data, seed, count):
    """Controls of all recordings that `count` spikes need, and these: the first of all recordings x forms x shares, in an order by
    the seed, that can be made."""
    machines = [Machine(path) for path in recordings(data)]
    points = [Spike(machine.path, machine.name, form, share, seed) for machine, form, share in
              itertools.product(machines, FORMS, SHARES) if FORMS[form].applies(machine)]  # fmt: skip
    step, drawn = running.Progress("spike: drawing", count), []
    for k in np.random.default_rng(seed).permutation(len(points)):
        if len(drawn) < count and points[k].columns() is not None:
            drawn.append(points[k])
            step(points[k].name)
    controls = [Spike(path, name) for path, name in sorted({(spike.path, spike.machine) for spike in drawn})]
    return controls + drawn


def diagnose(case):
    """A recording with its spike, and what talus-gap says of it."""
    columns, strength, leaves = case.columns() if case.form else (read_columns(case.path), 0.0, 0.0)
    with tempfile.TemporaryDirectory(prefix="spike-") as temporary:
        folder = Path(temporary)
        (folder / "model.yaml").write_text(model_text(case.path), encoding="utf-8")
        write_columns(folder / "recording.csv", columns)
        return {"setting": case.setting, "strength": strength, "leaves": leaves,
                "size": spike_sizes.added(FORMS[case.form].size, Machine(case.path), strength) if case.form else None,
                **running.diagnosed(folder / "model.yaml", folder / "recording.csv", folder)}  # fmt: skip
