"""tools/talus/diagnosis/words.py: the first sentence says what the report says, and no more."""

from types import SimpleNamespace

import pytest
from talus.diagnosis import kinds, picture, words


def gap(identified, extended, floor, closed, unit="Nm", nominal=9.0, measured=9.0):
    return {"unit": unit, "measured_rms": measured, "nominal_rms": nominal, "identified_rms": identified, "extended_rms": extended, "noise_floor_rms": floor,
            "closed_fraction": closed}  # fmt: skip


def report(effect, joint, probability, effects=(), **gaps):
    return {"verdict": {"effect": effect, "joint": joint, "probability": probability},
            "alternatives": [{"effect": "unknown", "joint": "none", "probability": 1 - probability}],
            "effects": [{"effect": e, "joint": j, "doubts": []} for e, j in effects], "where": [], "findings": [], "resembles": [], "irregular": [],
            "gap": gaps or {"knee": gap(0.0058, 0.0034, 0.0015, 0.7), "ankle": gap(0.0003, 0.0003, 0.0003, 0.0)}}  # fmt: skip


KNEE = [("load_friction", "knee")]


@pytest.mark.parametrize(("probability", "text"), [(1.0, "over 0.99"), (0.994, "over 0.99"), (0.99, "0.99"), (0.5, "0.50"),
                                                   (0.01, "0.01"), (0.0, "under 0.01")])  # fmt: skip
def test_nothing_is_certain(probability, text):
    assert words.share(probability) == text


@pytest.mark.parametrize(("x", "text"), [(190123.4, "190,123"), (654.2, "654"), (99.96, "100"), (3.228, "3.23"), (0.0, "0")])
def test_large_figures_have_no_power_of_ten(x, text):
    assert words.figure(x) == text


def test_a_cause_with_its_gain():
    assert words.sentence(report("load_friction", "knee", 0.97, KNEE)) == (
        "The gap comes from friction that grows with the load (load friction) at the knee (probability 0.97): modelling it takes "
        "the knee's error from 5.8 to 3.4 mNm on data held out, where the noise alone is 1.5 mNm.")  # fmt: skip


def test_a_base_effect_speaks_of_the_joint_where_it_shows():
    said = words.sentence(report("gravity_tilt", "base", 0.9, [("gravity_tilt", "base"), ("cogging", "knee")]))
    assert "a bench that is not upright (gravity tilt) at the base" in said
    assert "modelling it and 1 more takes the knee's error" in said


def test_what_is_not_sure_is_not_said_to_be():
    said = words.sentence(report("load_friction", "knee", 0.4, KNEE))
    assert said.startswith("The cause of the gap is not certain. Likeliest is friction")
    assert "The gap comes from" not in said and "no surer" not in said
    doubtful = report("load_friction", "knee", 0.4, KNEE)
    doubtful["effects"][0]["doubts"] = ["uneven", "lowpass"]
    assert words.sentence(doubtful) == f"{said} Load friction at the knee is no surer because {words.DOUBTS['uneven']}, and {words.DOUBTS['lowpass']}."


def test_the_page_says_of_each_effect_why_it_is_no_surer():
    said, entries = [], [{"effect": "backlash", "joint": "slider", "doubts": []}, {"effect": "delay", "joint": "slider", "doubts": ["lowpass"]}]
    picture._doubts(SimpleNamespace(paragraph=said.append), {"effects": entries})
    assert said == [f"Delay at the slider is no surer because {words.DOUBTS['lowpass']}."]
    assert words.sentence(report("load_friction", "knee", 0.6, KNEE)).startswith("The gap most likely comes from friction")


def test_nothing_closed_is_not_called_closed():
    said = words.sentence(report("load_friction", "knee", 0.9, KNEE, knee=gap(0.005, 0.006, 0.001, 0.0)))
    assert "does not shrink" in said and " from 5" not in said


def test_what_shows_between_the_encoders_only():
    found = report("linkage_error", "ankle", 0.9, [("linkage_error", "ankle")])
    assert "does not shrink" in words.sentence(found)
    found["where"] = [{"joint": "ankle", "coordinate": "encoder"}]
    assert words.sentence(found).endswith("(probability 0.90): it shows between the encoders and hardly in the torque.")


def none(calibrated=True, **gaps):
    return words.sentence({**report("none", "none", 0.9, **gaps), "calibrated": calibrated})


def test_none():
    """Down to the noise is a tenth more of its square at the most, at every joint."""
    quiet = gap(0.00104, 0.00104, 0.001, 0.0)
    assert none(knee=quiet) == "The model explains these recordings down to their noise; no further effect is needed (probability 0.90)."
    assert none(knee=quiet, ankle=gap(0.81, 0.81, 0.27, 0.0)) == (
        "No effect shows (probability 0.90). The ankle's error is 810 mNm on data held out, where the noise alone is 270 mNm; "
        "such sensors leave about as much without any effect.")  # fmt: skip
    assert none(calibrated=False, slider=gap(3.0, 3.0, 2.0, 0.0, unit="N")) == (
        "No effect shows (probability 0.90). The slider's error is 3 N on data held out, where the noise alone is 2 N.")


def test_noise_that_is_much_of_the_torque_is_said():
    small, large = gap(0.2, 0.2, 0.2, 0.0, measured=1.1), gap(2.9, 2.9, 5.1, 0.0, measured=5.8)
    assert none(knee=small).endswith("(probability 0.90).")
    assert none(knee=small, ankle=large).endswith("But that noise is 50 % of the torque: smaller effects would not show.")


def test_the_band_that_was_looked_at_is_said_where_the_data_made_it_slow():
    quiet, loud = gap(0.2, 0.2, 0.2, 0.0), gap(0.6, 0.6, 0.2, 0.0)
    for hz, source, said in ((8.89, "data", " below 8.89 Hz"), (8.89, "option", ""), (30.0, "data", "")):
        report_of = lambda knee: {**report("none", "none", 0.9, knee=knee), "calibrated": True, "lowpass": {"hz": hz, "from": source}}
        assert words.sentence(report_of(quiet)).startswith(f"The model explains these recordings down to their noise{said}; ")
        assert words.sentence(report_of(loud)).startswith(f"No effect shows{said} (")


def test_a_fit_that_is_worse_than_the_model_as_given_is_said():
    found = report("unknown", "none", 0.9, knee=gap(3.26, 3.26, 0.3, 0.0, nominal=2.28), ankle=gap(0.3, 0.3, 0.1, 0.0, nominal=0.29))
    (said,) = words.worse_than_given(found)
    assert said.startswith("On data held out the identified model is farther off at the knee than the one as given (3.260 Nm instead of 2.280)")


def test_unknown():
    said = words.sentence(report("unknown", "none", 0.9))
    assert said == "A gap remains that no known effect explains (probability 0.90)."
    said = words.sentence(report("unknown", "none", 0.6, KNEE))
    assert said.startswith("A gap remains that no known effect explains (probability 0.60). What comes nearest is friction that")


def test_a_gap_that_does_not_repeat_is_said_to_be_that():
    apart = {"irregular": [{"joint": "ankle", "share": 0.8}, {"joint": "knee", "share": 0.13}]}
    said = words.sentence(report("unknown", "none", 0.9) | apart)
    assert said.endswith("(probability 0.90). At least 93 % of it does not repeat with the motion, most of that at the ankle: a torque that wanders, vibrates, or acts now and then.")
    little = {"irregular": [{"joint": "ankle", "share": 0.19}]}
    assert words.sentence(report("unknown", "none", 0.9) | little).endswith("(probability 0.90).")
    assert "repeat with" not in words.sentence(report("load_friction", "knee", 0.9, KNEE) | apart)


@pytest.mark.parametrize("size, closes, said", [("0.2 Nm at 3 Hz", None, "a hum (0.2 Nm at 3 Hz) at the knee."),
                                                ("", 0.97, "a hum at the knee; that would close 97 % of the gap.")])  # fmt: skip
def test_what_an_unknown_gap_looks_like(size, closes, said):
    like = {"id": "hum", "title": "a hum", "joint": "knee", "probability": 0.9, "closes": closes, "size": size}
    text = words.sentence(report("unknown", "none", 0.9, KNEE) | {"resembles": [like]})
    assert text == f"A gap remains that no known effect explains (probability 0.90). It looks like {said}"
    unsure = words.sentence(report("unknown", "none", 0.9) | {"resembles": [like | {"probability": 0.3}]})
    assert unsure == "A gap remains that no known effect explains (probability 0.90)."
    if size:
        assert "0.2 N at 3 Hz" in words.likeness(like, True)
    rival = {"effects": [{"effect": "parallel_spring", "joint": "ankle"}], "parameter": "foot_moment", "times": 0.1449}
    assert words.likeness(like | {"rival": rival}).endswith("; so would parallel spring at the ankle, but only if foot moment were 0.14 times the model file's")


def test_poor_recordings():
    finding = {"id": "too_short", "grave": True, "column": "time_s", "evidence": "only 3 s", "remedy": "a minute"}
    poor = report("unknown", "none", 1.0, knee=gap(0.1, 0.1, 0.0, 0.0)) | {"alternatives": [], "findings": [finding]}
    assert words.is_poor(poor) and words.sentence(poor) == "No cause is named before this is mended: only 3 s."
    assert not words.is_poor(report("unknown", "none", 0.9))


@pytest.mark.parametrize(("figures", "x", "text"), [([0.1, 0.0034], 0.0034, "3.400 mNm"), ([2.0, 0.5], 0.5, "0.5000 Nm"),
                                                    ([1234.0], 1234.0, "1234 Nm"), ([], 0.0, "0.000 mNm")])  # fmt: skip
def test_figures_in_readable_units(figures, x, text):
    assert words.Scale("Nm", figures).text(x) == text


@pytest.mark.parametrize(("parameter", "rotary", "straight"), [
    ("extra_Nm", "Nm", "N"), ("speed_rad_s", "rad/s", "m/s"), ("viscous_Nms_rad", "Nms/rad", "Ns/m"), ("exponent", "", ""),
    ("stiffening_Nm_rad3", "Nm/rad³", "N/m³"), ("wave_1_rad", "1/rad", "1/m"), ("compliance_rad_Nm", "rad/Nm", "m/N"),
    ("frequency_Hz_2", "Hz", "Hz"), ("share_per_10_C", "per 10 °C", "per 10 °C"), ("coulomb_Nm_10K", "Nm per 10 K", "N per 10 K"),
    ("sway_m_N", "m/N", "m/N"), ("delay_s", "s", "s")])  # fmt: skip
def test_units_of_parameters(parameter, rotary, straight):
    assert (words.unit(parameter), words.unit(parameter, straight=True)) == (rotary, straight)


def test_every_parameter_of_a_model_file_has_its_unit():
    """But for shares, exponents, counts, and a droop, whose unit hangs on its exponent."""
    every = {p.name for name in kinds.ids() for p in kinds.kind_of(name).parameters}
    without = {name for name in every if not words.unit(name)}
    plain = ("share", "exponent", "coefficient", "per_turn", "power", "ratio", "driving", "excess", "too", "side", "droop_1_Nm")
    assert {name for name in without if not name.endswith(plain)} == set()


def test_a_slider_has_forces():
    found = report("stribeck", "slider", 0.9, [("stribeck", "slider")], slider=gap(5.0, 3.0, 1.0, 0.7, "N"))
    assert "the slider's error from 5 to 3 N" in words.sentence(found) and words.is_linear(found)
    assert words.cause("torque_constant", "slider", True) == "a force constant that is not the given one (torque constant) at the slider"
    assert words.linear("0.3 rad/s, 2 rad², 4 mNm and 5 Nms/rad of torque") == "0.3 m/s, 2 m², 4 mN and 5 Ns/m of force"


def test_what_has_no_joint_is_not_said_to_be_at_one():
    assert words.at("unknown", "none") == "unknown" and words.at("load_friction", "knee") == "load friction at the knee"
