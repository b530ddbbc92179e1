"""talus.Effect: effects of one's own in a diagnosis, against closed forms that are added to recordings and against the catalogue's."""

import os

import numpy as np
import pytest
import talus
from gap_in_process import recorded
from support import REPOSITORY
from talus.diagnosis.catalogue import own
from talus.diagnosis.catalogue.law import column
from talus.diagnosis.torque_terms import TorqueTerms

PENDULUM, LEG = REPOSITORY / "models/pendulum.yaml", REPOSITORY / "models/leg.yaml"
NM_PER_A = 9 * 0.091  # of the pendulum's drive
LAG_RAD, LOOM_NM = 0.12, 0.1  # of a cable loom that is twisted by friction in its sleeve
ONE = {"id": "detent", "title": "a magnetic detent", "parameters": ("moment_Nm",), "torque": lambda segment, joint: np.sin(7 * segment.q[joint])}


def bench(added=None, model=None):
    """20 s of the pendulum; `added(q)` more torque than its own, for the same motion."""
    recording = talus.simulate(model or talus.read(PENDULUM), duration_s=20, seed=3)
    columns = dict(recording.columns)
    if added:
        columns["joint_current_A"] = columns["joint_current_A"] + added(columns["joint_rad"]) / NM_PER_A
    return talus.Recording(columns)


def play(q, width):
    """The play operator: what is dragged along behind an angle at the most half a width away."""
    out, z = np.empty(len(q)), q[0]
    for i, x in enumerate(q):
        z = out[i] = min(max(z, x - width / 2), x + width / 2)
    return out


def loom_law(segment, joint, lag_rad):
    return np.sin(5 * play(segment.q[joint], lag_rad))[:, None]


def loom():
    return talus.Effect("cable_loom", "a cable loom that lags behind", ("moment_Nm",), loom_law, [{"lag_rad": x} for x in (0.04, LAG_RAD, 0.36)])


@pytest.fixture(scope="module")
def with_loom():
    return bench(lambda q: LOOM_NM * np.sin(5 * play(q, LAG_RAD)))


# ---- what it finds ---------------------------------------------------------------------


@pytest.mark.long
def test_an_effect_that_the_catalogue_lacks_is_named_with_its_parameter(with_loom):
    found, without = talus.diagnose(PENDULUM, with_loom, effects=[loom()]), talus.diagnose(PENDULUM, with_loom)
    assert (found.verdict["effect"], found.verdict["joint"]) == ("cable_loom", "joint") and found.verdict["probability"] > 0.9
    assert found.effects[0]["parameters"] == pytest.approx({"moment_Nm": LOOM_NM, "lag_rad": LAG_RAD}, rel=0.05)
    assert found.report["own_effects"] == {"cable_loom": {"title": "a cable loom that lags behind"}}
    assert "The gap comes from a cable loom that lags behind (cable loom) at the joint" in str(found)
    assert found.notes and "cable_loom" in found.notes[0] and str(found).startswith(f"note: {found.notes[0]}\n")
    assert found.report["motion"]["joint"]["extended_rms"] < 0.2 * found.report["motion"]["joint"]["identified_rms"]
    assert "own_effects" not in without.report and "cable_loom" not in str(without.report) and not without.notes
    assert without.gap["joint"]["extended_rms"] > 1.1 * found.gap["joint"]["extended_rms"]


def test_beside_one_of_the_catalogue_both_are_named_and_the_model_file_holds_that_one():
    stribeck = {"extra_Nm": 0.3, "speed_rad_s": 0.2, "exponent": 1.0}
    truth = talus.Model.from_text(PENDULUM.read_text() + f"effects: [{{effect: stribeck, joint: joint, parameters: {stribeck}}}]")
    found = talus.diagnose(PENDULUM, bench(lambda q: 0.15 * np.sin(5 * play(q, LAG_RAD)), model=truth), effects=[loom()])
    sizes = {one["effect"]: one["parameters"] for one in found.effects}
    assert sizes["cable_loom"]["moment_Nm"] == pytest.approx(0.15, rel=0.05) and sizes["stribeck"]["extra_Nm"] == pytest.approx(0.3, rel=0.1)
    assert min(one["probability"] for one in found.effects) > 0.9 and len(found.model.effects) == 1 and "stribeck" in found.model_text


@pytest.mark.long
def test_it_is_not_named_where_it_is_not():
    found = talus.diagnose(PENDULUM, bench(), effects=[loom()])
    assert found.verdict["effect"] == "none" and not found.effects
    assert "cable_loom" in {one["effect"] for one in found.report["nearest"] + found.report["not_observable"]}


@pytest.mark.long
def test_a_law_of_the_catalogue_as_a_function_closes_as_much_and_is_not_told_apart_from_it():
    """|v|^p of speed, as lib/effects has it, on a simulation that has it."""
    drag = "effects: [{effect: nonlinear_viscous, joint: joint, parameters: {size_Nm: 0.02, exponent: 2}}]"
    recording = talus.simulate(talus.Model.from_text(PENDULUM.read_text() + drag), duration_s=20, seed=3)
    law = lambda segment, joint, exponent: np.sign(segment.v[joint]) * np.abs(segment.v[joint]) ** exponent
    shapes = [{"exponent": power} for power in (0.5, 1.5, 2.0, 3.0)]
    found = talus.diagnose(PENDULUM, recording, effects=[talus.Effect("air_drag", "the drag of air", ("size_Nm",), law, shapes)])
    closes = {one["effect"]: one["closes"] for one in found.report["nearest"]}
    assert closes["air_drag"] == pytest.approx(closes["nonlinear_viscous"], rel=1e-4) and closes["air_drag"] > 0.5
    (pair,) = [one for one in found.report["confusable"] if set(one["effects"]) == {"air_drag", "nonlinear_viscous"}]
    assert pair["joint"] == "joint" and abs(pair["separation"]) < 0.1


def test_beside_a_torque_sensor_at_the_output_it_is_what_the_drive_delivers_and_the_sensor_lacks():
    """Load = drive - friction - effect, the sensor with 2 mNm of noise."""
    law = lambda q: 0.1 * np.sin(7 * q)
    columns = dict(bench(law).columns)
    q, v = columns["joint_rad"], np.gradient(columns["joint_rad"], columns["time_s"])
    smooth = np.convolve(v, np.full(9, 1 / 9), "same")
    lost = 0.25 * np.sign(smooth) * (np.abs(smooth) > 0.01) + 0.02 * smooth + law(q)
    noise = 0.002 * np.random.default_rng(1).standard_normal(len(q))
    columns["joint_load_Nm"] = NM_PER_A * columns["joint_current_A"] - lost + noise
    found = talus.diagnose(PENDULUM, talus.Recording(columns), effects=[talus.Effect(**ONE)])
    assert found.verdict["effect"] == "detent" and found.effects[0]["parameters"]["moment_Nm"] == pytest.approx(0.1, rel=0.05)


@pytest.mark.parametrize("path", [PENDULUM, LEG], ids=["pendulum", "leg"])
def test_its_column_is_that_of_the_same_law_in_the_library(path, tmp_path):
    """A spring beside each joint: stiffness times angle."""
    talus.simulate(talus.read(path), duration_s=12).write(tmp_path / "r.csv")
    dataset, model = recorded(path, tmp_path, tmp_path / "r.csv")
    terms = TorqueTerms(dataset, 0, list(model.base.values()))
    spring = talus.Effect("leaf_spring", "a leaf spring", ("stiffness_Nm_rad",), lambda segment, joint: segment.q[joint])
    for joint in range(dataset.joints):
        (name, mine), = own.OwnColumn(spring, joint, 0, 0, 1.0)(terms).items()
        (other, theirs), = column("parallel_spring", (joint,), {"stiffness_Nm_rad": 1.0}, {})(terms).items()
        assert name == other and np.abs(theirs).max() > 0.001 and mine == pytest.approx(theirs, rel=1e-12, abs=1e-15)


@pytest.mark.long
def test_it_is_named_at_the_joint_of_a_leg_where_it_is():
    """The ankle's loom: its torque reaches the motor through the linkage's ratio."""
    model = talus.read(LEG)
    columns = dict(talus.simulate(model, duration_s=60, seed=3).columns)
    linkage, ankle = model.transmission(1), columns["ankle_joint_rad"]
    motor_Nm = 2.0 * np.sin(5 * play(ankle, LAG_RAD)) / linkage.ratio(ankle)
    columns["ankle_current_A"] = columns["ankle_current_A"] + motor_Nm / model.struct.drive[1].torque_constant_Nm_A
    found = talus.diagnose(model, talus.Recording(columns), effects=[loom()])
    assert (found.verdict["effect"], found.verdict["joint"]) == ("cable_loom", "ankle") and found.verdict["probability"] > 0.9
    assert found.effects[0]["parameters"] == pytest.approx({"moment_Nm": 2.0, "lag_rad": LAG_RAD}, rel=0.05)
    assert found.trajectory and found.gap["ankle"]["closed_fraction"] > 0.9


# ---- what it refuses -------------------------------------------------------------------


def segment(n=4):
    zero = np.zeros((1, n))
    return talus.Segment(("joint",), np.arange(n) / 100, zero, zero, zero, zero, zero, zero, zero, np.full((1, n), np.nan))


def returning(values):
    return lambda segment, joint: values


@pytest.mark.parametrize(("given", "said"), [
    ({"id": "Detent"}, "effect 'Detent': id: expected lower-case words with underscores between them, other than none and unknown"),
    ({"id": "unknown"}, "effect 'unknown': id: expected lower-case words with underscores between them, other than none and unknown"),
    ({"id": "stribeck"}, "effect 'stribeck': id: the catalogue has an effect of that name"),
    ({"title": " "}, "effect 'detent': title: expected what it is in words"),
    ({"parameters": ()}, "effect 'detent': parameters: expected one name or more in a tuple, such as (\"moment_Nm\",)"),
    ({"parameters": "moment_Nm"}, "effect 'detent': parameters: expected one name or more in a tuple, such as (\"moment_Nm\",)"),
    ({"parameters": ("a moment",)}, "effect 'detent': parameters: expected names with units, such as moment_Nm, found 'a moment'"),
    ({"parameters": ("a_Nm", "a_Nm")}, "effect 'detent': parameters: a name stands there twice"),
    ({"torque": 3}, "effect 'detent': torque: expected a function, found 3"),
    ({"shapes": ()}, "effect 'detent': shapes: expected one dict or more in a list, [{}] where there is nothing to try"),
    ({"shapes": {"order": 3}}, "effect 'detent': shapes: expected one dict or more in a list, [{}] where there is nothing to try"),
    ({"shapes": [{"order": 3}, {}]}, "effect 'detent': shapes: expected dicts with the same names, none of them a parameter's, found {}"),
    ({"shapes": [{"moment_Nm": 3}]},
     "effect 'detent': shapes: expected dicts with the same names, none of them a parameter's, found {'moment_Nm': 3}"),
    ({"shapes": [{"order": "7"}]}, "effect 'detent': shapes: order: expected a finite number, found '7'"),
    ({"shapes": [{"order": np.inf}]}, "effect 'detent': shapes: order: expected a finite number, found inf"),
])  # fmt: skip
def test_what_is_no_effect_is_refused(given, said):
    with pytest.raises(talus.InputError) as refused:
        talus.Effect(**ONE | given)
    assert str(refused.value) == said


@pytest.mark.parametrize(("torque", "said"), [
    (returning(np.zeros(3)), "returned an array of shape (3,), expected (4, 1): samples, parameters"),
    (returning(np.zeros((1, 4))), "returned an array of shape (1, 4), expected (4, 1): samples, parameters"),
    (returning(np.zeros((4, 2))), "returned an array of shape (4, 2), expected (4, 1): samples, parameters"),
    (returning(None), "returned an array of shape (), expected (4, 1): samples, parameters"),
    (returning("torque"), "returned no array of numbers: str"),
    (returning(np.array([0.0, 0.0, np.inf, 0.0])), "returned inf for moment_Nm at 0.02 s, expected finite numbers; not recorded of the joint: temp_C"),
    (lambda segment, joint: segment.temp_C[joint],
     "returned nan for moment_Nm at 0 s, expected finite numbers; not recorded of the joint: temp_C"),
    (lambda segment, joint: segment.q[joint + 1], "raised IndexError: index 1 is out of bounds for axis 0 with size 1"),
    (lambda segment: segment.t_s, "raised TypeError: <lambda>() takes 1 positional argument but 2 were given"),
])  # fmt: skip
def test_what_a_function_returns_is_checked(torque, said):
    with pytest.raises(talus.InputError) as refused:
        talus.Effect(**ONE | {"torque": torque}).columns(segment(), 0, {})
    assert str(refused.value) == f"effect 'detent': its function {said}"


def failing_elsewhere(segment, joint, here=os.getpid()):
    """In replicates alone, which are searched in processes of their own."""
    return segment.v[joint] ** 2 if os.getpid() == here else 1 / 0


def overwriting(segment, joint):
    segment.q[joint] += 1.0
    return segment.q[joint]


@pytest.mark.parametrize(("effects", "said"), [
    ([talus.Effect(**ONE), talus.Effect(**ONE | {"title": "another"})], "effect 'detent': there are two of that id"),
    ([np.sin], "effects: expected talus.Effect, found ufunc"),
    ([talus.Effect(**ONE | {"torque": returning(np.zeros(3))})], r"effect 'detent': its function returned an array of shape \(3,\), expected"),
    ([talus.Effect(**ONE | {"torque": failing_elsewhere})], "effect 'detent': its function raised ZeroDivisionError: division by zero"),
    ([talus.Effect(**ONE | {"torque": lambda segment, joint: 1e10 * np.cos(segment.q[joint])})],
     r"effect 'detent': its function returned 1e\+10 for moment_Nm, expected less than 1e\+09: choose a smaller unit"),
    ([talus.Effect(**ONE | {"torque": overwriting})], "effect 'detent': its function raised ValueError: output array is read-only"),
])  # fmt: skip
def test_a_diagnosis_refuses_them(effects, said, plain_bench):
    with pytest.raises(talus.InputError, match=said):
        talus.diagnose(PENDULUM, plain_bench, effects=effects)


@pytest.fixture(scope="module")
def plain_bench():
    return bench()


def test_an_angle_that_was_not_recorded_is_not_known():
    """Of a recording of speeds alone."""
    columns = dict(bench().columns)
    columns["joint_velocity_rad_s"] = np.gradient(columns.pop("joint_rad"), columns["time_s"])
    with pytest.raises(talus.InputError, match="expected finite numbers; not recorded of the joint: q, motor_rad, temp_C"):
        talus.diagnose(talus.Model.from_text(PENDULUM.read_text().replace("kg_m: 0.15", "kg_m: 0.0")), talus.Recording(columns),
                       effects=[talus.Effect(**ONE)])  # fmt: skip
