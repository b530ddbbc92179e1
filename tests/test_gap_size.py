"""How large an effect is, in words (tools/talus/diagnosis/effects): compared with the laws in lib/effects."""

import math
import re

import numpy
import pytest
from talus.diagnosis import kinds, words
from talus.diagnosis.effects import EFFECTS

from talus import ffi, lib

WITHOUT_WORDS = {"position_friction"}  # a polynomial or a wave over the angle: its parameters say as much


def torque(effect, parameters, **instant):
    """The effect's torque at the joint, by the library; at a ratio of 1."""
    kind = kinds.kind_of(effect)
    now = ffi.new("tl_effect_instant *", {"ratio": 1.0, "v": 1.0, "slip": 1.0, **instant})
    column = numpy.zeros(len(kind.strengths))
    shape = kind.shape({p.name: parameters[p.name] for p in kind.shapes if p.name in parameters})
    lib.tl_effect_columns(kind.struct, ffi.from_buffer("double[]", shape), now, ffi.from_buffer("double[]", column))
    return sum(parameters.get(p.name, 0.0) * x for p, x in zip(kind.strengths, column, strict=True))


def said(effect, straight=False, **parameters):
    return words.size(effect, parameters, straight)


def figures(text):
    return [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", text)]


def test_friction_of_two_directions():
    parameters = {"coulomb_Nm": 0.25, "viscous_Nms_rad": -0.1}
    dry, viscous = said("asymmetric_friction", **parameters).split(", ")
    for text, only in ((dry, {"coulomb_Nm": 0.25}), (viscous, {"viscous_Nms_rad": -0.1})):
        forward, back = (torque("asymmetric_friction", only, v=v, slip=v) for v in (1.0, -1.0))
        more = forward + back  # a friction of the negative direction has a negative torque
        assert figures(text)[0] == pytest.approx(abs(more))
        assert ("positive" if more > 0 else "negative") in text


def test_a_droop_is_told_where_it_costs_a_tenth():
    parameters = {"droop_1_Nm": 0.3, "exponent": 2.0, "begin_Nm": 0.0}
    at_Nm = figures(said("torque_saturation", **parameters))[0]
    assert torque("torque_saturation", parameters, motor_Nm=at_Nm) == pytest.approx(0.1 * at_Nm, rel=0.01)


def test_a_kinked_droop_is_told_beyond_its_kink():
    parameters = {"droop_1_Nm": 0.2, "exponent": 0.0, "begin_Nm": 0.5}
    begin, percent = figures(said("torque_saturation", **parameters))
    assert torque("torque_saturation", parameters, motor_Nm=begin) == 0.0
    assert torque("torque_saturation", parameters, motor_Nm=begin + 1.0) == pytest.approx(percent / 100)


def test_friction_near_standstill():
    parameters = {"extra_Nm": 0.4, "speed_rad_s": 0.2, "exponent": 1.0}
    extra, speed = figures(said("stribeck", **parameters))
    assert torque("stribeck", parameters, v=0.0) == pytest.approx(extra)
    assert torque("stribeck", parameters, v=speed) == pytest.approx(extra / 3, rel=0.15)


def test_losses_are_shares_of_the_load():
    parameters = {"driving": 0.21, "back_driving": 0.12, "rotor_share": 1.0, "friction_share": 0.0}
    driving, driven = figures(said("directional_efficiency", **parameters))
    for load, percent in ((2.0, driving), (-2.0, driven)):
        assert torque("directional_efficiency", parameters, load_Nm=load) == pytest.approx(2.0 * percent / 100)
    parameters = {"coefficient": 0.11, "exponent": 2.0, "scale_Nm": 3.0, "rotor_share": 1.0, "friction_share": 0.0}
    percent, at_Nm = figures(said("load_friction", **parameters))
    assert torque("load_friction", parameters, load_Nm=at_Nm) == pytest.approx(at_Nm * percent / 100)


@pytest.mark.parametrize("q", [-0.8, 0.3])
def test_a_bent_spring_by_its_stiffness_at_any_angle(q):
    parameters = {"stiffness_Nm_rad": -27.0, "bend_Nm_rad2": 31.0, "stiffening_Nm_rad3": -11.5, "preload_Nm": 2.0}
    text = said("parallel_spring", **parameters)
    assert text == "-27 + 62 q - 34.5 q² Nm/rad at q rad"
    slope = (torque("parallel_spring", parameters, q=q + 1e-4) - torque("parallel_spring", parameters, q=q - 1e-4)) / 2e-4
    assert slope == pytest.approx(-27 + 62 * q - 34.5 * q**2, rel=1e-6)


def test_a_straight_spring_by_its_stiffness():
    assert said("parallel_spring", stiffness_Nm_rad=3.0, bend_Nm_rad2=0.0) == "3 Nm/rad"
    assert said("parallel_spring", straight=True, stiffening_Nm_rad3=2.0) == "6 q² N/m at q m"


def test_a_ripple_by_its_amplitude():
    parameters = {"sine_Nm": 0.3, "cosine_Nm": -0.4, "per_turn": 12.0}
    amplitude, order = figures(said("cogging", **parameters))
    turn = [torque("cogging", parameters, motor_rad=x) for x in numpy.linspace(0, 2 * math.pi / order, 2000)]
    assert amplitude == pytest.approx(max(turn), rel=1e-4)


def test_fluid_friction():
    for parameters in ({"size_Nm": 0.5, "exponent": 1.5}, {"size_Nm": 0.5, "exponent": 1.0, "saturation_rad_s": 0.3}):
        text = said("nonlinear_viscous", **parameters)
        speed = 1.0 if "at 1 rad/s" in text else 100.0
        assert figures(text)[0] == pytest.approx(torque("nonlinear_viscous", parameters, v=speed), rel=1e-6)


@pytest.mark.parametrize(("effect", "parameters", "text"), [
    ("delay", {"delay_s": -0.0032}, "the current is 3.2 ms earlier than the angles"),
    ("elasticity", {"compliance_rad_Nm": 0.0005}, "twists by 0.5 mrad for 1 Nm (2e+03 Nm/rad)"),
    ("gravity_tilt", {"tilt_rad": 0.05}, "leans by 50 mrad (2.9°)"),
    ("friction_drift", {"share_at_end": -0.2, "time_constant_s": 40.0}, "20 % less friction in the end"),
    ("torque_constant", {"excess": 0.05}, "the drive gives 5 % more torque than its constant says"),
    ("linkage_error", {"AB_m": -0.0012, "BO_m": 0.0}, "AB is 1.2 mm shorter"),
    ("base_compliance", {"sway_m_N": 0.0004, "frequency_Hz": 8.0, "damping_ratio": 0.05}, "sways by 0.4 mm for 1 N, swings at 8 Hz"),
])  # fmt: skip
def test_the_rest_in_words(effect, parameters, text):
    assert said(effect, **parameters) == text


def test_two_orders_stand_beside_each_other():
    parameters = {"sine_rad": 0.001, "cosine_rad": 0.0, "per_turn": 2.0, "sine_rad_2": 0.0, "cosine_rad_2": 0.002, "per_turn_2": 4.0}
    assert said("kinematic_error", **parameters).count("times a turn") == 2
    assert "1 mrad (0.057°), 2 times a turn of the motor; 2 mrad" in said("kinematic_error", **parameters)


def test_what_moves_straight_has_no_degrees():
    assert said("presliding", straight=True, friction_Nm=2.0, travel_rad=0.0004, power=1.0).startswith("yields by about 0.4 mm after")
    assert "2 N more" in said("stribeck", straight=True, extra_Nm=2.0, speed_rad_s=0.02, exponent=1.0)


@pytest.mark.parametrize("effect", sorted(set(EFFECTS) - WITHOUT_WORDS))
def test_each_effect_of_the_catalogue_has_words(effect):
    """With the parameters that its law has; those that the report has beside them are tested above."""
    of_report = {"elasticity": {"compliance_rad_Nm": 0.001}, "friction_drift": {"coulomb_share_at_end": 0.1}, "torque_constant": {"excess": 0.1},
                 "encoder_eccentricity": {"joint_sine_rad": 0.001, "joint_cosine_rad": 0.0, "joint_per_turn": 1.0}}  # fmt: skip
    typical = {p.name: 0.5 * (p.low + p.high) if p.high < 1e3 else 1.0 for p in kinds.kind_of(effect).parameters}
    text = words.size(effect, of_report.get(effect) or {name: x or 0.1 for name, x in typical.items()})
    assert text
    assert "nan" not in text
