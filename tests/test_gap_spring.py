"""tools/talus/diagnosis/effects/elasticity.py: springs of a single joint of any stiffness, against two masses stepped by SciPy."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support import run
from talus.diagnosis.catalogue.flexible_joint import stiffnesses

pytestmark = pytest.mark.spread

MOTOR_kg_m2 = LINK_kg_m2 = 0.00065
GRAVITY_Nm, COULOMB_Nm, VISCOUS_Nms_rad, DAMPING_RATIO = 0.058, 0.018, 0.014, 0.06
STIFF_Nm_rad, DAMP_Nms_rad = 2.0, 0.05  # of the position control
RATE_Hz, LENGTH_s, STEP_rad, NOISE_A, TORQUE_PER_A = 500.0, 24.0, 2 * np.pi / 2**17, 0.02, 0.1
# a drawing's values, not the bench's
MODEL = """\
plant: pendulum
gravity_m_s2: 9.81
inertia_kg_m2: 0.0012
gravity_moment_kg_m: 0.006
gravity_zero_rad: 0
joint:
  transmission: {type: fixed, ratio: 10}
  torque_constant_Nm_A: 0.01
  friction: {coulomb_Nm: 0.02, viscous_Nms_rad: 0.015}
"""


def reference(t):
    """(angle, speed) of a multisine up to 2 Hz."""
    phase = np.random.default_rng(3).uniform(0, 2 * np.pi, 8)
    w = 2 * np.pi * 0.25 * np.arange(1, 9)
    angle = np.multiply.outer(t, w) + phase
    return 0.9 / 8 * np.sin(angle).sum(-1), 0.9 / 8 * (w * np.cos(angle)).sum(-1)


def drive_Nm(t, angle, speed):
    wanted, wanted_speed = reference(t)
    return STIFF_Nm_rad * (wanted - angle) + DAMP_Nms_rad * (wanted_speed - speed)


def write_bench(path, stiffness_Nm_rad):
    """A pendulum behind a spring, its encoder and its friction on the motor's side."""
    damping = 2 * DAMPING_RATIO * np.sqrt(stiffness_Nm_rad * LINK_kg_m2)

    def slopes(t, x):
        angle, speed, link, link_speed = x
        spring = stiffness_Nm_rad * (angle - link) + damping * (speed - link_speed)
        friction = COULOMB_Nm * np.tanh(speed / 0.01) + VISCOUS_Nms_rad * speed
        return [speed, (drive_Nm(t, angle, speed) - friction - spring) / MOTOR_kg_m2,
                link_speed, (spring - GRAVITY_Nm * np.sin(link)) / LINK_kg_m2]  # fmt: skip

    t = np.arange(0, LENGTH_s, 1 / RATE_Hz)
    begin = [*reference(0.0)] * 2
    angle, speed, *_ = solve_ivp(slopes, (0, LENGTH_s), begin, "LSODA", t, rtol=1e-7, atol=1e-9, max_step=0.01).y
    current = drive_Nm(t, angle, speed) / TORQUE_PER_A + NOISE_A * np.random.default_rng(4).standard_normal(len(t))
    columns = np.column_stack([t, np.round(angle / STEP_rad) * STEP_rad, current])
    np.savetxt(path, columns, "%.9g", ",", header="time_s,joint_rad,joint_current_A", comments="")


@pytest.mark.parametrize(("inertia_kg_m2", "softest"), [(0.3, 200), (0.1, 100), (0.05, 50), (0.005, 25)])
def test_a_legs_light_link_is_tried_on_soft_springs(inertia_kg_m2, softest):
    """On which it swings at 4 Hz or more, the slowest that a single joint is tried on: sqrt(k / inertia) / 2 pi."""
    terms = SimpleNamespace(link_rad_s=lambda joint, motor, stiffness: np.sqrt(stiffness / inertia_kg_m2))
    at = SimpleNamespace(dataset=SimpleNamespace(at_motor=True), number=1, all_terms=[terms])
    grid, (least, _) = stiffnesses(at)
    assert grid[0] == softest and least < softest
    assert all(np.sqrt(k / inertia_kg_m2) / (2 * np.pi) > 4.0 for k in grid if k < 200)


@pytest.mark.long
@pytest.mark.parametrize("stiffness_Nm_rad", [0.6, 1.0, 1.6, 2.3, 3.5])
def test_a_spring_between_the_grids_stiffnesses_is_found(tmp_path, stiffness_Nm_rad):
    (tmp_path / "model.yaml").write_text(MODEL)
    write_bench(tmp_path / "bench.csv", stiffness_Nm_rad)
    run("talus-gap", "--quiet", "--model", tmp_path / "model.yaml", "--report", tmp_path / "gap.json", tmp_path / "bench.csv")
    found = json.loads((tmp_path / "gap.json").read_text())
    assert found["verdict"]["effect"] == "elasticity" and found["verdict"]["probability"] > 0.9
    # its size is not held to the truth: what the motor sees is how fast the link swings, whatever the link's share of the inertia
    assert [e["effect"] for e in found["effects"]] == ["elasticity"] and found["gap"]["joint"]["closed_fraction"] > 0.9
