"""The loss report's figures: what talus-export's files leave of each effect, by NumPy from the effects' closed forms.

An arm moves as two sines say, so angle, speed and acceleration are exact; test_export_loss_leg.py has what only a leg can have.
What a file leaves of the closed form (docs/effects.md), as RMS of the moving rows, is what the report must name.
"""

import ast
import functools
import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import talus
from support import REPOSITORY
from talus.exporting import command

ARM = REPOSITORY / "models" / "pendulum.yaml"
INERTIA, MOMENT, GRAVITY, GEAR, CONSTANT, DRY, VISCOUS = 0.045, 0.15, 9.81, 9.0, 0.091, 0.25, 0.02  # the arm's, of its file
TARGETS = ("mjcf", "urdf", "sdf", "bam", "isaac")
t = np.arange(0.0, 16.0, 0.002)
WAVES = ((0.5, 2 * np.pi * 0.41, 0.0), (0.25, 2 * np.pi * 0.97, 1.0))  # rad, rad/s, rad
q = 0.1 + sum(a * np.sin(w * t + p) for a, w, p in WAVES)
v = sum(a * w * np.cos(w * t + p) for a, w, p in WAVES)
acceleration = sum(-a * w * w * np.sin(w * t + p) for a, w, p in WAVES)
slip = np.sign(v)


def load(angle=q, rate=acceleration):
    """Torque of inertia and gravity."""
    return INERTIA * rate + MOMENT * GRAVITY * np.sin(angle)


DRIVE = load() + DRY * slip + VISCOUS * v


def presliding(size, travel):
    """Dahl's friction in place of Coulomb's: z falls exponentially to the direction of slip with the way since a reversal."""
    z = np.empty_like(t)
    z[0] = slip[0]
    for i in range(1, len(t)):
        step = q[i] - q[i - 1]
        z[i] = np.sign(step) + (z[i - 1] - np.sign(step)) * np.exp(-abs(step) / travel)
    return size * (z - slip)


def behind_teeth(stiffness, damping, motor_inertia, gap=0.0):
    """What the motor's torque gains when its part of the inertia moves as measured, and the rest on a spring or in a gap."""
    fine = np.arange(0.0, t[-1], 0.0002)
    angle = 0.1 + sum(a * np.sin(w * fine + p) for a, w, p in WAVES)
    rate = sum(a * w * np.cos(w * fine + p) for a, w, p in WAVES)
    link, x, y, teeth = INERTIA - motor_inertia, angle[0], rate[0], np.empty_like(fine)
    held = link * acceleration + MOMENT * GRAVITY * np.sin(q)  # as if it did not swing
    x -= np.sign(held[0]) * gap / 2 + held[0] / stiffness
    y -= np.gradient(held, t)[0] / stiffness
    for i, (motor, speed) in enumerate(zip(angle.tolist(), rate.tolist(), strict=True)):
        twist = motor - x
        deep = twist - gap / 2 if twist > gap / 2 else twist + gap / 2 if twist < -gap / 2 else 0.0
        pull = stiffness * deep + damping * (speed - y) if deep or not gap else 0.0
        teeth[i] = pull = max(pull, 0.0) if gap and deep > 0 else min(pull, 0.0) if gap else pull
        y += 0.0002 * (pull - MOMENT * GRAVITY * float(np.sin(x))) / link
        x += 0.0002 * y
    return motor_inertia * acceleration + np.interp(t, fine, teeth) - load()


def late(delay):
    """A current that is read late tells of an earlier torque; of an arm without dry friction, whose jumps at rest are nobody's."""
    torque = load() + VISCOUS * v
    return np.interp(t - delay, t, torque) - torque


# parameters, and the closed form with them
FORMS = {
    "stribeck": ({"extra_Nm": 0.15, "speed_rad_s": 0.4, "exponent": 1}, lambda: 0.15 * np.exp(-abs(v) / 0.4) * slip),
    "load_friction": ({"coefficient": 0.1}, lambda: 0.1 * abs(load()) * slip),
    "asymmetric_friction": ({"coulomb_Nm": 0.05, "viscous_Nms_rad": 0.02}, lambda: 0.05 + 0.02 * abs(v)),
    "nonlinear_viscous": ({"size_Nm": 0.05, "exponent": 2}, lambda: 0.05 * v * abs(v)),
    "position_friction": ({"slope_Nm_rad": 0.1, "bend_Nm_rad2": 0.3}, lambda: (0.1 * q + 0.3 * q**2) * slip),
    "friction_drift": ({"coulomb_Nm": 0.2, "viscous_Nms_rad": 0.02, "time_constant_s": 10},
                       lambda: (1 - np.exp(-t / 10)) * (0.2 * slip + 0.02 * v)),
    "directional_efficiency": ({"driving": 0.2, "back_driving": 0.1}, lambda: np.where(load() * v > 0, 0.2, 0.1) * abs(load()) * slip),
    "kinematic_error": ({"sine_Nm": 0.05, "cosine_Nm": 0.02, "per_turn": 2}, lambda: 0.05 * np.sin(18 * q) + 0.02 * np.cos(18 * q)),
    "cogging": ({"sine_Nm": 0.003, "cosine_Nm": 0, "per_turn": 6}, lambda: GEAR * 0.003 * np.sin(6 * GEAR * q)),
    "torque_saturation": ({"droop_1_Nm": 0.5, "exponent": 1}, lambda: GEAR * 0.5 * (DRIVE / GEAR) ** 2 * np.sign(DRIVE)),
    "current_offset": ({"torque_Nm": 0.01}, lambda: np.full_like(q, GEAR * 0.01)),
    "parallel_spring": ({"stiffness_Nm_rad": 0.5, "stiffening_Nm_rad3": 0, "preload_Nm": 0}, lambda: 0.5 * q),
    "torque_constant": ({"excess": 0.1}, lambda: 0.1 * DRIVE),
    "sensor_offset": ({"offset_Nm": 0.1}, lambda: np.full_like(q, 0.1)),
    "delay": ({"delay_s": 0.004}, lambda: late(0.004)),
    "presliding": ({"friction_Nm": 0.2, "travel_rad": 0.05}, lambda: presliding(0.2, 0.05)),
    "elasticity": ({"share": 1, "stiffness_Nm_rad": 60, "damping_s": 0.002}, lambda: behind_teeth(60, 0.12, 0.4 * INERTIA)),
    "backlash": ({"share": 1, "gap_rad": 0.005, "stiffness_Nm_rad": 300}, lambda: behind_teeth(300, 0.3, 0.4 * INERTIA, 0.005)),
}  # fmt: skip
DRY_FREE = ("delay",)
AT_SENSOR = ("torque_constant", "sensor_offset")


@functools.cache
def closed_form(name):
    return FORMS[name][1]()


def recording(name):
    columns = {"time_s": t, "joint_rad": q, "joint_current_A": DRIVE / (GEAR * CONSTANT)}
    return talus.Recording({**columns, "joint_load_Nm": DRIVE} if name in AT_SENSOR else columns)


def polynomial(text, x, odd):
    """MuJoCo's damping and stiffness: a number, and those of the square and the cube; damping is odd in speed."""
    numbers = [float(number) for number in text.split()]
    return sum(n * (x * abs(x) ** k if odd else x ** (k + 1)) for k, n in enumerate(numbers))


def by_mjcf(text, dry):
    root = ET.fromstring(text)
    joint, actuator = root.find(".//joint[@name='joint']"), root.find(".//general")
    gear, gain, bias = float(actuator.get("gear").split()[0]), float(actuator.get("gainprm")), float(actuator.get("biasprm").split()[0])
    across = float(root.find("option").get("gravity").split()[0])
    torque = (float(joint.get("frictionloss")) - dry) * slip + polynomial(joint.get("damping"), v, True) - VISCOUS * v
    torque = torque + polynomial(joint.get("stiffness"), q, False) + across * MOMENT * np.cos(q) - bias * gear / gain + (gain - 1) * DRIVE
    twist = root.find(".//joint[@name='joint_twist']")
    if twist is not None:
        motor = float(root.find(".//body[@name='joint_motor']/inertial").get("diaginertia").split()[1])
        torque = torque + behind_teeth(float(twist.get("stiffness")), float(twist.get("damping")), motor)
    return torque


def by_numbers(own, dry, viscous, stiffness=0.0):
    """Beside the plain arm's, whose dry friction is `own`."""
    return (float(dry) - own) * slip + (float(viscous) - VISCOUS) * v + float(stiffness) * q


def by_urdf(text, dry):
    dynamics = ET.fromstring(text).find("joint[@name='joint']/dynamics")
    return by_numbers(dry, dynamics.get("friction"), dynamics.get("damping"))


def by_sdf(text, dry):
    dynamics = ET.fromstring(text).find("model/joint[@name='joint']/axis/dynamics")
    return by_numbers(dry, *(dynamics.find(key).text for key in ("friction", "damping", "spring_stiffness")))


def by_bam(text, dry):
    tree = json.loads(text)
    near = tree.get("friction_stribeck", 0.0) * np.exp(-((abs(v) / tree.get("dtheta_stribeck", 1.0)) ** tree.get("alpha", 1.0)))
    return by_numbers(dry, tree["friction_base"], tree["friction_viscous"]) + near * slip


def by_isaac(text, dry):
    (call,) = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call) and getattr(node.func, "id", "").endswith("Cfg")]
    given = {key.arg: key.value.value for key in call.keywords if isinstance(key.value, ast.Constant)}
    assert given["friction"] == given["dynamic_friction"]
    return by_numbers(dry, given["friction"], given["viscous_friction"])


READ = {"mjcf": by_mjcf, "urdf": by_urdf, "sdf": by_sdf, "bam": by_bam, "isaac": by_isaac}


def rms(x, model):
    return float(np.sqrt(np.mean(x[abs(v) > model.score.standstill] ** 2)))


def checked(name, target):
    """What is wrong with the report on one effect in one file; nothing where all is right."""
    parameters, _ = FORMS[name]
    dry, arm = (0.0, ARM.read_text().replace("coulomb_Nm: 0.25", "coulomb_Nm: 0")) if name in DRY_FREE else (DRY, ARM.read_text())
    model = talus.Model.from_text(arm + f"effects: [{{effect: {name}, joint: joint, parameters: {json.dumps(parameters)}}}]\n")
    text, report = command.export(model, target, "arm.yaml", recording=recording(name))
    (entry,) = report["entries"]  # this effect and nothing else
    torque, left = closed_form(name), closed_form(name) - READ[target](text, dry)
    whole, remains = rms(torque, model), rms(left, model)
    holds = float(np.max(abs(left))) < 1e-8 * float(np.max(abs(torque)))
    wrong = [] if (entry["effect"], entry["joint"]) == (name, "joint") else ["named wrongly"]
    if holds != (entry["how"] == "exact") or holds != (entry["lost_Nm"] == 0.0):
        wrong.append(f"the file {'holds' if holds else 'does not hold'} it")
    for key, figure in (("torque_Nm", whole), ("lost_Nm", 0.0 if holds else remains)):
        if entry[key] != pytest.approx(figure, rel=0.01, abs=1e-12):
            wrong.append(f"{key} {entry[key]}, closed form {figure:.5g}")
    return f"{target} {name} {entry['how']}: {'; '.join(wrong)}" if wrong else ""


@pytest.mark.parametrize("name", FORMS)
def test_the_report_names_what_each_file_leaves_of_the_closed_form(name):
    assert not list(filter(None, (checked(name, target) for target in TARGETS)))
