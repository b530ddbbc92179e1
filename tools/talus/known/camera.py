"""talus-sim's benches with one cause of a gap each, diagnosed with the camera's columns and without them. The causes go in pairs: of
each pair it was asked whether a camera tells the two apart."""

import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml

from ..blind.effects import log_uniform, phase, side
from . import running
from .machine import read_columns, write_columns
from .nulls import model_of

SEEN = ("shank_rad", "foot_rad")
LENGTH_S = 60
ZERO_RAD = 0.002  # to which a camera can be aligned with the bench


@dataclass
class Cause:
    """`effect` is what the twin gets, `scale` {joint: factor} its true torque constants, `offset_rad` what the knee's encoder shows
    more at the joint. `size` in words."""

    joint: str
    size: str
    effect: dict = field(default_factory=dict)
    scale: dict = field(default_factory=dict)
    offset_rad: float = 0.0


def encoder_offset(rng):
    angle = side(rng) * log_uniform(rng, 0.005, 0.08)
    return Cause("knee", f"{1e3 * angle:+.0f} mrad", offset_rad=angle)


def gravity_tilt(rng):
    angle = side(rng) * log_uniform(rng, 0.005, 0.08)
    return Cause("base", f"{1e3 * angle:+.0f} mrad", {"tilt_rad": angle})


def elasticity(rng):
    stiffness = log_uniform(rng, 500, 12000)
    return Cause(str(rng.choice(["knee", "ankle"])), f"{stiffness:.0f} Nm/rad",
                 {"share": 1.0, "stiffness_Nm_rad": stiffness, "damping_s": log_uniform(rng, 0.0004, 0.002)})  # fmt: skip


def base_compliance(rng):
    """A mount of some inertia on a spring: it turns, or sways."""
    hertz, turns = log_uniform(rng, 3, 12), rng.uniform() < 0.5
    inertia = log_uniform(rng, 1.0, 6.0) if turns else log_uniform(rng, 6, 60)
    name = "compliance_rad_Nm" if turns else "sway_m_N"
    return Cause("base", f"{'turns' if turns else 'sways'} at {hertz:.1f} Hz, {inertia:.1f} {'kg m2' if turns else 'kg'}",
                 {"compliance_rad_Nm": 0.0, "frequency_Hz": hertz, "damping_ratio": rng.uniform(0.02, 0.1)}
                 | {name: float(1 / (inertia * (2 * np.pi * hertz) ** 2))})  # fmt: skip


def torque_constant(rng):
    joint, excess = str(rng.choice(["knee", "ankle"])), side(rng) * log_uniform(rng, 0.03, 0.15)
    return Cause(joint, f"{100 * excess:+.0f} %", scale={joint: 1 + excess})


def linkage_error(rng):
    name, error = str(rng.choice(["AB_m", "BO_m", "AC_m"])), side(rng) * log_uniform(rng, 2e-4, 2e-3)
    return Cause("ankle", f"{name[:2]} {1e3 * error:+.2f} mm", {"AB_m": 0.0, "BO_m": 0.0, "AC_m": 0.0} | {name: error})


def encoder_eccentricity(rng):
    size, order, angle = log_uniform(rng, 0.001, 0.008), int(rng.integers(1, 4)), phase(rng)
    return Cause("ankle", f"{1e3 * size:.1f} mrad, {order} a turn",
                 {"motor_sine_rad": 0.0, "motor_cosine_rad": 0.0, "joint_sine_rad": size * np.sin(angle),
                  "joint_cosine_rad": size * np.cos(angle), "joint_per_turn": order})  # fmt: skip


# The last stands for itself: linkage_error's nearest rival.
CAUSES = {made.__name__: made for made in (encoder_offset, gravity_tilt, elasticity, base_compliance, torque_constant, linkage_error,
                                           encoder_eccentricity)}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """The cause's name and sizes follow from the seed and the number alone."""

    seed: int
    number: int

    @property
    def effect(self):
        return list(CAUSES)[self.number % len(CAUSES)]

    @property
    def name(self):
        return f"{self.number:03d}-{self.effect}"

    def drawn(self):
        """(cause, seed of noise and phases)."""
        rng = np.random.default_rng([self.seed, self.number])
        return CAUSES[self.effect](rng), int(rng.integers(1, 2**31))


def draw(seed, count):
    """The first `count`, the causes in turn."""
    return [Case(seed, number) for number in range(count)]


def plain(values):
    """NumPy's numbers as YAML knows them."""
    return {name: value if isinstance(value, int) else float(value) for name, value in values.items()}


def true_model(effect, cause):
    """The leg with its cause, as talus-sim reads it."""
    tree = yaml.safe_load(model_of("leg").read_text())
    for joint, factor in cause.scale.items():
        tree[joint]["torque_constant_Nm_A"] *= factor
    if cause.effect:
        tree["effects"] = [{"effect": effect, "joint": cause.joint, "parameters": plain(cause.effect)}]
    return yaml.safe_dump(tree, sort_keys=False)


def filmed(case, cause, seed, folder):
    """{name: values} of the bench's recording, with the camera's columns."""
    (folder / "true.yaml").write_text(true_model(case.effect, cause))
    command = [running.BUILD / "bin" / "talus-sim", "--model", folder / "true.yaml", "--out", folder / "all.csv", "--camera",
               "--duration", LENGTH_S, "--seed", seed]  # fmt: skip
    made = subprocess.run(list(map(str, command)), check=False, capture_output=True, text=True)
    if made.returncode:
        raise RuntimeError(f"{case.name}: talus-sim: {made.stderr.strip()}")
    columns = read_columns(folder / "all.csv")
    columns["knee_motor_rad"] = columns["knee_motor_rad"] + ratio() * cause.offset_rad
    return columns


def ratio():
    """Of the knee's gear."""
    return yaml.safe_load(model_of("leg").read_text())["knee"]["transmission"]["ratio"]


def diagnose(case):
    """What talus-gap says of a case with the camera's columns (`report`) and without (`without`); and the mean of the camera's shank
    angle less the knee motor's, which a camera that is aligned with the bench gives."""
    cause, seed = case.drawn()
    with tempfile.TemporaryDirectory(prefix="camera-") as temporary:
        folder = Path(temporary)
        columns = filmed(case, cause, seed, folder)
        write_columns(folder / "with.csv", columns)
        write_columns(folder / "without.csv", {name: x for name, x in columns.items() if name not in SEEN})
        of = {name: running.diagnosed(model_of("leg"), folder / f"{name}.csv", folder, *more)
              for name, more in (("without", ()), ("with", ("--camera-zero", str(ZERO_RAD))))}  # fmt: skip
    off = columns["shank_rad"] - columns["knee_motor_rad"] / ratio()
    return {"effect": case.effect, "joint": cause.joint, "size": cause.size, "without": of["without"]["report"],
            "camera_less_knee_mrad": 1e3 * float(np.mean(off)), **of["with"]}  # fmt: skip
