"""talus-gap beside a torque sensor at the output, on joints whose truth is known in closed form: what a wrong constant, the
gear's load and late telemetry do, and what a held shaft or a drive that only drives cannot tell."""

import json

import numpy as np
import pytest
import yaml
from support import run

KT, GEAR = 0.1, 9.0
INERTIA, COULOMB, VISCOUS = 0.008, 0.3, 0.05
MODEL = {"plant": "pendulum", "gravity_m_s2": 9.81, "inertia_kg_m2": 0.006, "gravity_moment_kg_m": 0.0,
         "gravity_zero_rad": 0.0, "joint": {"transmission": {"type": "fixed", "ratio": GEAR}, "torque_constant_Nm_A": KT,
                   "friction": {"coulomb_Nm": 0.2, "viscous_Nms_rad": 0.1}},
         "score": {"lowpass_hz": 10, "order": 2, "standstill": 0.05, "guard_s": 0.02, "trim_s": 0.25}}  # fmt: skip
NOISE_NM = 0.01
T_S = np.arange(6000) * 0.01


def stairs(levels, length_s=1.5):
    """A current that goes from level to level, each reached within some 50 ms."""
    at = np.random.default_rng(2).choice(levels, int(T_S[-1] / length_s) + 2)
    sharp = at[(T_S / length_s).astype(int)]
    return np.convolve(np.pad(sharp, 4, mode="edge"), np.ones(9) / 9, "valid")


def diagnosed(tmp_path, angle, current, load):
    """(GAP.json, saved model's path, recording's path)"""
    random = np.random.default_rng(1)
    columns = {"time_s": T_S, "joint_rad": angle, "joint_current_A": current,
               "joint_load_Nm": load + random.normal(0, NOISE_NM, len(T_S))}  # fmt: skip
    np.savetxt(tmp_path / "r.csv", np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns),
               comments="", fmt="%.9g")  # fmt: skip
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(MODEL))
    run("talus-gap", "-q", "--model", tmp_path / "m.yaml", "--report", tmp_path / "gap.json", "--save-model", tmp_path / "f.yaml",
        tmp_path / "r.csv")  # fmt: skip
    return json.loads((tmp_path / "gap.json").read_text())


def driven(excess, load_share, current, velocity, acceleration):
    """What the sensor shows of a drive that gives 1 + excess of its current, less the gear's friction and inertia."""
    drive = (1 + excess) * KT * GEAR * current
    return drive - (COULOMB + load_share * np.abs(drive)) * np.sign(velocity) - VISCOUS * velocity - INERTIA * acceleration


def test_a_wrong_constant_the_gears_load_and_late_currents_are_told_apart(tmp_path):
    w, late_s = 2 * np.pi * 0.45, 0.008
    q, v, a = 3.0 * np.sin(w * T_S), 3.0 * w * np.cos(w * T_S), -3.0 * w * w * np.sin(w * T_S)
    current = stairs([-8, -4, -1, 1, 4, 8])
    load = driven(-0.3, 0.1, current, v, a)
    found = diagnosed(tmp_path, q, np.interp(T_S - late_s, T_S, current), load)
    assert found["verdict"]["effect"] == "torque_constant" and found["verdict"]["probability"] > 0.9
    effects = {e["effect"]: e["parameters"] for e in found["effects"]}
    assert set(effects) == {"torque_constant", "load_friction", "delay"}
    saved = {e["effect"]: e["parameters"] for e in yaml.safe_load((tmp_path / "f.yaml").read_text())["effects"]}
    assert saved["torque_constant"]["excess"] == pytest.approx(-0.3, abs=0.003)
    assert saved["load_friction"]["coefficient"] == pytest.approx(0.1, abs=0.01)
    assert saved["delay"]["delay_s"] == pytest.approx(late_s, abs=5e-4)
    run("talus-predict", "--model", tmp_path / "f.yaml", "--out", tmp_path / "p.csv", tmp_path / "r.csv")
    prediction = np.loadtxt(tmp_path / "p.csv", delimiter=",", skiprows=1)[:, 1]
    moving = (np.abs(v) > 0.5) & (T_S > 0.3) & (T_S < T_S[-1] - 0.3)
    assert np.sqrt(np.mean((prediction - load)[moving] ** 2)) < 0.02 * np.sqrt(np.mean(load[moving] ** 2))


def test_a_held_shaft_shows_its_constant_and_no_ripple(tmp_path):
    """The shaft only twists, so that its angle is another reading of the torque: nothing that hangs on it can be told."""
    current = stairs([-8, -5, -2, 0, 2, 5, 8])
    load = 0.7 * KT * GEAR * current
    random = np.random.default_rng(3)
    found = diagnosed(tmp_path, 0.02 * load + random.normal(0, 2e-5, len(T_S)), current, load)
    assert found["verdict"]["effect"] == "torque_constant" and found["verdict"]["probability"] > 0.9
    assert found["effects"][0]["parameters"]["excess"] == pytest.approx(-0.3, abs=0.01)
    named = {e["effect"] for e in found["effects"] + found["alternatives"]}
    assert not named & {"cogging", "kinematic_error", "position_friction", "parallel_spring"}


def test_a_drive_that_only_drives_does_not_tell_its_gears_load(tmp_path):
    """Friction that takes a tenth of the load, and a constant a tenth too low, are one column as long as power flows one way."""
    w = 2 * np.pi * 0.45
    q, v, a = 3.0 * np.sin(w * T_S), 3.0 * w * np.cos(w * T_S), -3.0 * w * w * np.sin(w * T_S)
    current = np.abs(stairs([1, 3, 6, 8])) * np.tanh(v / 0.3)
    found = diagnosed(tmp_path, q, current, driven(0.0, 0.1, current, v, a))
    named = {e["effect"] for e in found["effects"] + found["alternatives"]} | {found["verdict"]["effect"]}
    assert not named & {"load_friction", "directional_efficiency"}
