"""tools/talus/diagnosis/effects/parallel_spring.py: a bumper that is met between the grid's angles, on torques in closed form."""

import json

import numpy as np
import pytest
from support import run

INERTIA_kg_m2, MOMENT_kg_m, COULOMB_Nm, VISCOUS_Nms_rad = 0.9, 1.2, 0.6, 0.4
STIFFNESS_Nm_rad = 9.0
RATE_Hz, LENGTH_s, STEP_rad, NOISE_Nm = 200.0, 60.0, 2 * np.pi / 2**18, 0.05
# a drawing's values, not the bench's
MODEL = """\
plant: pendulum
gravity_m_s2: 9.81
inertia_kg_m2: 0.8
gravity_moment_kg_m: 1.1
gravity_zero_rad: 0
joint:
  transmission: {type: fixed, ratio: 1}
  torque_constant_Nm_A: 1
  friction: {coulomb_Nm: 0.5, viscous_Nms_rad: 0.3}
"""


def motion(t):
    """Angle, speed and acceleration of a multisine up to 2 Hz."""
    w = 2 * np.pi * 0.125 * np.arange(1, 17)
    angle = np.multiply.outer(t, w) + np.random.default_rng(5).uniform(0, 2 * np.pi, 16)
    size = 0.9 / np.arange(2, 18)
    return (size * np.sin(angle)).sum(-1), (size * w * np.cos(angle)).sum(-1), (-size * w**2 * np.sin(angle)).sum(-1)


def write_bench(path, at, side):
    """Met at a share `at` of half the range, from its middle to one side; the share's angle."""
    t = np.arange(0, LENGTH_s, 1 / RATE_Hz)
    angle, speed, acceleration = motion(t)
    middle, half = 0.5 * (angle.max() + angle.min()), 0.5 * (angle.max() - angle.min())
    met = middle + side * at * half
    torque = INERTIA_kg_m2 * acceleration + 9.81 * MOMENT_kg_m * np.sin(angle) + COULOMB_Nm * np.sign(speed) + VISCOUS_Nms_rad * speed
    torque += STIFFNESS_Nm_rad * side * np.maximum(side * (angle - met), 0) + NOISE_Nm * np.random.default_rng(6).standard_normal(len(t))
    columns = np.column_stack([t, np.round(angle / STEP_rad) * STEP_rad, torque])
    np.savetxt(path, columns, "%.9g", ",", header="time_s,joint_rad,joint_current_A", comments="")
    return met


@pytest.mark.parametrize("at, side", [(0.45, 1), pytest.param(0.15, 1, marks=pytest.mark.long), pytest.param(-0.2, -1, marks=pytest.mark.long),
                                      pytest.param(0.5, -1, marks=pytest.mark.long)])  # fmt: skip
def test_where_a_bumper_is_met_is_found(tmp_path, at, side):
    (tmp_path / "model.yaml").write_text(MODEL)
    met = write_bench(tmp_path / "bench.csv", at, side)
    run("talus-gap", "--quiet", "--model", tmp_path / "model.yaml", "--report", tmp_path / "gap.json", tmp_path / "bench.csv")
    found = json.loads((tmp_path / "gap.json").read_text())
    assert found["verdict"]["effect"] == "parallel_spring" and found["verdict"]["probability"] > 0.9
    (effect,) = found["effects"]
    size = effect["parameters"]
    assert (size["bumper_rad"], size["bumper_side"]) == (pytest.approx(met, abs=0.02), side)
    assert size["bumper_Nm_rad"] == pytest.approx(STIFFNESS_Nm_rad, rel=0.05)
