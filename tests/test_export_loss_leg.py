"""The loss report's figures of the effects that only a leg can have, by NumPy: a tilted or swaying bench, the linkage, its encoders.

The leg's rows are (12) of docs/equations.md, its linkage (1) to (6) there. No file but MuJoCo's holds any of them (the tilt).
"""

import functools
import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import talus
from scipy.interpolate import CubicSpline
from scipy.signal import lsim
from support import REPOSITORY
from talus import ffi, lib
from talus.exporting import command
from test_export_loss import FORMS as ARMS_FORMS

LEG = REPOSITORY / "models" / "leg.yaml"
PLAIN = ("ratio over the angle", "rotor inertia")  # what files lack of the leg itself
TARGETS = ("mjcf", "urdf", "sdf", "bam", "isaac")
G, KNEE_RATIO, CONSTANT, ROTOR = 9.81, 51.0, 0.1031, 2.4e-6
SHANK = 0.0420 + 1.624 * 0.160**2 + 0.4112 * 0.120**2 + 0.442 * 0.3615**2  # J
MOMENT_s, MOMENT_f = 1.624 * 0.160 + 0.4112 * 0.120 + 0.442 * 0.3615, 0.442 * 0.055
COUPLED, FOOT = 0.442 * 0.3615 * 0.055, 0.0021 + 0.442 * 0.055**2
DRY, VISCOUS = (1.2, 0.8), (0.45, 0.30)
LEAD, AB, BO, AC, BOF = 0.002, 0.090, 0.040, 0.035, np.deg2rad(84.75)
t = np.arange(0.0, 12.0, 0.002)


def waves(middle, *parts, at=t):
    """Sum of sines (size, Hz, phase): angle, speed, acceleration."""
    terms = [(size, 2 * np.pi * hz, 2 * np.pi * hz * at + phase) for size, hz, phase in parts]
    return (middle + sum(a * np.sin(x) for a, _, x in terms), sum(a * w * np.cos(x) for a, w, x in terms), sum(-a * w * w * np.sin(x) for a, w, x in terms))


def motion(at=t):
    return waves(-0.3, (0.4, 0.43, 0.2), (0.15, 0.91, 1.0), at=at), waves(0.05, (0.1, 0.31, 1.1), (0.04, 0.67, 0.3), at=at)


KNEE, ANKLE = motion()


def loads(knee=KNEE, ankle=ANKLE):
    """Torques of inertia and gravity at both joints, (12), without the rotor's."""
    (s, s1, s2), (f, f1, f2) = knee, [k + a for k, a in zip(knee, ankle, strict=True)]
    c, sine = np.cos(s - f), np.sin(s - f)
    row_s = SHANK * s2 + COUPLED * c * f2 + COUPLED * sine * f1**2 + MOMENT_s * G * np.sin(s)
    row_f = COUPLED * c * s2 + FOOT * f2 - COUPLED * sine * s1**2 + MOMENT_f * G * np.sin(f)
    return np.array([row_s + row_f, row_f])


def linkage(angle, crank=BO):
    """The motor's angle but for its zero, and the ratio, (1) to (6)."""
    phi = np.pi - BOF - angle
    rise = AC - crank * np.sin(phi)
    root = np.sqrt(AB**2 - rise**2)
    turns = 2 * np.pi / LEAD
    return turns * (crank * np.cos(phi) + root), turns * (crank * np.sin(phi) - rise * crank * np.cos(phi) / root)


def motor_angle(angle, crank=BO):
    return linkage(angle, crank)[0] - linkage(0.0, crank)[0]


def by_motor(motor, crank=BO):
    """The ankle's motion where its motor stands so: the linkage inverted and derived on a grid."""
    grid = np.linspace(-0.5, 0.5, 20001)
    spline = CubicSpline(t, CubicSpline(motor_angle(grid, crank), grid)(motor))
    return spline(t), spline(t, 1), spline(t, 2)


def of_ankle(motor, crank=BO):
    """Torques at the joints, the ankle's as the model counts its motor's: times the model's ratio."""
    ankle, ratio = by_motor(motor, crank), linkage(ANKLE[0])[1]
    knee, foot = loads(ankle=ankle)
    dry = DRY[1] * np.sign(ANKLE[1])  # the ripple does not turn it round away from standstill
    drive = (foot + dry + VISCOUS[1] * ankle[1]) / linkage(ankle[0], crank)[1] + ROTOR * CubicSpline(t, motor)(t, 2)
    return np.array([knee, drive * ratio])


def displaced(motor=None, crank=BO):
    shown = motor_angle(ANKLE[0])
    return of_ankle(shown if motor is None else motor, crank) - of_ankle(shown)


def tilted(angle):
    thigh, foot = MOMENT_s * G * np.cos(KNEE[0]), MOMENT_f * G * np.cos(KNEE[0] + ANKLE[0])
    return angle * np.array([thigh + foot, foot])


def swaying(compliance, hz, ratio):
    """The knee's torque turns the mount back, which has swung on its spring for long; that adds to every absolute angle."""
    before = np.arange(-5.0, t[-1] + 1e-9, 0.002)
    w, force = 2 * np.pi * hz, -compliance * loads(*motion(before))[0]
    _, _, state = lsim(([[0, 1], [-w * w, -2 * ratio * w]], [[0], [w * w]], np.eye(2), [[0], [0]]), force, before - before[0])
    (x, rate), force = state[-len(t):].T, force[-len(t):]
    moved = (KNEE[0] + x, KNEE[1] + rate, KNEE[2] + w * w * (force - x) - 2 * ratio * w * rate)
    return loads(knee=moved) - loads()


# place, parameters, and the closed form with them
FORMS = {
    "gravity_tilt": ("base", {"tilt_rad": 0.03}, lambda: tilted(0.03)),
    "base_compliance": ("base", {"compliance_rad_Nm": 0.0005, "frequency_Hz": 8, "damping_ratio": 0.3}, lambda: swaying(0.0005, 8, 0.3)),
    "encoder_eccentricity": ("ankle", {"motor_sine_rad": 0.1, "motor_cosine_rad": 0, "joint_sine_rad": 0, "joint_cosine_rad": 0},
                             lambda: displaced(motor_angle(ANKLE[0]) - 0.1 * np.sin(motor_angle(ANKLE[0])))),
    "linkage_error": ("ankle", {"AB_m": 0, "BO_m": 0.0005, "AC_m": 0}, lambda: displaced(crank=BO + 0.0005)),
}  # fmt: skip


@functools.cache
def closed_form(name):
    return FORMS[name][2]()


def recording():
    torque = loads() + np.array([d * np.sign(x[1]) + r * x[1] for d, r, x in zip(DRY, VISCOUS, (KNEE, ANKLE), strict=True)])
    motor, ratio = linkage(ANKLE[0])
    return talus.Recording({
        "time_s": t, "knee_motor_rad": KNEE_RATIO * KNEE[0], "ankle_motor_rad": motor - linkage(0.0)[0], "ankle_joint_rad": ANKLE[0],
        "knee_current_A": torque[0] / (KNEE_RATIO * CONSTANT), "ankle_current_A": torque[1] / (ratio * CONSTANT)})  # fmt: skip


def held(target, text):
    """What of a tilt stands in the file: gravity's part across, in MuJoCo's."""
    if target != "mjcf":
        return np.zeros((2, len(t)))
    across, _, down = (float(x) for x in ET.fromstring(text).find("option").get("gravity").split())
    assert down == -G
    return tilted(across / G)


def size(torque, model):
    """RMS of each joint's moving rows, and the root of their squares' sum."""
    of = [np.sqrt(np.mean(x[abs(motion[1]) > model.score.standstill] ** 2)) for x, motion in zip(torque, (KNEE, ANKLE), strict=True)]
    return float(np.linalg.norm(of))


def test_every_effect_has_its_closed_form_here_or_at_the_arm():
    n = ffi.new("int *")
    table = lib.tl_effect_table(n)
    assert sorted([*FORMS, *ARMS_FORMS]) == sorted(ffi.string(table[i].name).decode() for i in range(n[0])) and n[0] == 22


@pytest.mark.parametrize("name", FORMS)
def test_the_report_names_what_each_file_leaves_of_the_closed_form(name):
    place, parameters, _ = FORMS[name]
    model = talus.Model.from_text(LEG.read_text() + f"effects: [{{effect: {name}, joint: {place}, parameters: {json.dumps(parameters)}}}]\n")
    for target in TARGETS:
        drive = ("ankle" if place == "ankle" else "knee") if target == "bam" else None
        text, report = command.export(model, target, "leg.yaml", recording=recording(), joint=drive)
        (entry,) = [e for e in report["entries"] if e["effect"] not in PLAIN]
        left = closed_form(name) - held(target, text)
        holds = np.max(abs(left)) < 1e-8 * np.max(abs(closed_form(name)))
        assert (entry["effect"], entry["joint"]) == (name, place)
        assert (entry["how"] == "exact") == (entry["lost_Nm"] == 0.0) == holds, (target, entry)
        for key, figure in (("torque_Nm", size(closed_form(name), model)), ("lost_Nm", 0.0 if holds else size(left, model))):
            assert entry[key] == pytest.approx(figure, rel=0.005), (target, key)
