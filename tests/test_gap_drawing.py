"""The machine beside an effect: the model file's, as a drawing has it, another, or one that cannot be."""

import functools
import re
from types import SimpleNamespace

import numpy as np
import pytest
import talus
from gap_in_process import recorded
from scipy.stats import norm
from support import REPOSITORY, data, needs_data
from talus.diagnosis import figures, gate
from talus.diagnosis.calibration import lowpass
from talus.diagnosis.calibration.thresholds import PART
from talus.diagnosis.dataset import drawn_width
from talus.diagnosis.machine.drawing import of_torques
from talus.diagnosis.motion import has_inertia
from talus.diagnosis.refit import Rows
from talus.diagnosis.search import Search, machine_bases, plain_base

LEG, SLIDER = REPOSITORY / "models/leg_cad.yaml", REPOSITORY / "models/slider.yaml"
FRICTION = ("coulomb", "viscous", "offset")


@pytest.fixture(scope="module")
def search(tmp_path_factory):
    """Of the leg's recording, under a drawing that is off by some percent."""
    folder = tmp_path_factory.mktemp("drawing")
    talus.simulate(talus.read(REPOSITORY / "models/leg.yaml"), duration_s=20, seed=3).write(folder / "leg.csv")
    dataset, identified = recorded(LEG, folder, folder / "leg.csv")
    return Search(dataset, list(identified.base.values()), lambda every: [c for c in every if c.effect == "parallel_spring"])


def cost_by_lstsq(search, columns, temperature):
    """What the rows of data and drawing together leave, less what those of the data alone leave."""
    gram, dataset = search.gram, search.dataset
    data = np.concatenate([np.concatenate([plain[:-1], own]).T for plain, own in zip(gram.plain, gram.gathered(columns))]) / np.sqrt(temperature)
    reading = np.concatenate([plain[-1] for plain in gram.plain]) / np.sqrt(temperature)
    names, given = list(dataset.model.base), np.array(list(dataset.model.base.values()))
    drawn = [k for k, name in enumerate(names) if not name.endswith(FRICTION) and given[k] != 0]
    rows = np.zeros((len(drawn), data.shape[1]))
    rows[np.arange(len(drawn)), drawn] = 1 / (PART * np.abs(given[drawn]))
    both, wanted = np.concatenate([data, rows]), np.concatenate([reading, np.ones(len(drawn)) * np.sign(given[drawn]) / PART])

    def least(x, y):
        size = np.linalg.norm(x, axis=0) + 1e-300
        return np.sum((y - x / size @ np.linalg.lstsq(x / size, y, rcond=1e-12)[0]) ** 2)

    return least(both, wanted) - least(data, reading)


@pytest.mark.parametrize("temperature", [1.0, 40.0])
def test_what_the_drawing_costs_is_the_least_squares_of_its_rows_beside_the_data(search, temperature):
    for columns in ([], list(search.gram.candidates[0].columns)):
        want = cost_by_lstsq(search, columns, temperature)
        assert want > 0.1 and search.gram.cost_of_drawing(columns, temperature) == pytest.approx(want, rel=1e-3)


BENCH = {"shank_inertia": 0.1, "shank_moment": 0.4, "foot_moment": 0.05, "ankle_rotor_inertia": 0.0, "knee_coulomb": 1.0, "knee_viscous": 0.2}


def test_inertia_and_gravity_are_a_drawings_and_friction_is_not():
    assert drawn_width(BENCH) == pytest.approx([0.02, 0.08, 0.01, *[np.inf] * 3])


@pytest.mark.parametrize("cost", [0.0, 3.0, 30.0, 1e4])
def test_a_file_is_a_drawing_or_a_first_guess(search, monkeypatch, cost):
    """Posterior odds by densities: each value within 20 % of the file's, or within 20 times that."""
    names, given = list(search.dataset.model.base), np.array(list(search.dataset.model.base.values()))
    count = sum(not name.endswith(FRICTION) and value != 0 for name, value in zip(names, given, strict=True))
    monkeypatch.setattr(type(search.gram), "cost_of_drawing", lambda *_: cost)
    drawing, guess = (norm.logpdf(0.0, scale=width) * count for width in (0.2, 20.0))
    want = np.logaddexp(drawing, guess) - np.logaddexp(drawing - 0.5 * cost, guess)
    assert search.gram.off_drawing([], 1.0) == pytest.approx(2 * want, abs=1e-9)
    assert search.gram.is_drawn([], 1.0) == (drawing - 0.5 * cost > guess)


@pytest.mark.parametrize("weight", [0.3, 4.0])
def test_a_drawing_counts_as_much_in_any_unit_of_the_noise(search, weight):
    """What is fitted does not depend on the unit in which all chi-squares are counted, nor what is saved; to the ridge under what the leg does
    not tell apart."""
    near, chosen = search.as_drawn(40.0), [search.gram.candidates[0]]
    rows, every = Rows(near, chosen), np.full(len(near.gram.layouts), weight)
    strengths = near.gram.fold_strengths(near.columns(chosen))
    assert near.gram.fold_strengths(near.columns(chosen), every) == pytest.approx(strengths, rel=1e-6, abs=1e-12)
    assert rows.solve(every) == pytest.approx(rows.solve(np.ones(len(every))), rel=1e-4)
    assert search.gram.fold_strengths(near.columns(chosen)) != pytest.approx(strengths, rel=1e-3)


def test_errors_beside_a_drawing_are_those_of_noise_and_of_the_drawing(search):
    """Of strengths that are linear in readings and drawn values, each of its own deviation: data weigh 1, a drawing `temperature`."""
    temperature = 40.0
    near = search.as_drawn(temperature)
    fit = near.fit(search.gram.candidates[:1])
    gram, dataset, columns = search.gram, search.dataset, search.columns(fit.chosen)
    data = np.concatenate([np.concatenate([plain[:-1], own]).T for plain, own in zip(gram.plain, gram.gathered(columns), strict=True)])
    names, given = list(dataset.model.base), np.array(list(dataset.model.base.values()))
    known = np.flatnonzero(given)
    drawn = np.array([not names[k].endswith(FRICTION) for k in known])
    deviation = np.where(drawn, PART * np.abs(given[known]), dataset.prior_width[known])
    weight = np.where(drawn, np.sqrt(temperature), 1.0) / deviation
    rows = np.zeros((len(known), data.shape[1]))
    rows[np.arange(len(known)), known] = weight
    seen = np.flatnonzero(np.any(data != 0, axis=0))
    every = np.concatenate([data, rows])[:, seen]
    size = np.linalg.norm(every, axis=0)
    moved = np.linalg.pinv(every / size, rcond=1e-12) / size[:, None]  # what each row's reading moves
    noise = np.r_[np.full(len(data), np.sqrt(figures.left_of_freedom(near, fit))), weight * deviation]
    want = np.sqrt(np.sum((moved * noise) ** 2, axis=1))[-len(columns):]
    assert np.concatenate(figures.standard_errors(near, fit)) == pytest.approx(want, rel=1e-3)


@pytest.mark.parametrize("drawn", [0, 1])
def test_what_has_a_single_value_at_the_most_costs_nothing(search, monkeypatch, drawn):
    """A rotor without gravity: its inertia may be near the file's by chance."""
    monkeypatch.setattr(search.dataset, "drawn_width", np.r_[np.full(drawn, 1e-3), np.full(search.dataset.bases - drawn, np.inf)])
    assert search.gram.off_drawing([], 1.0) == 0.0


def test_the_parameter_that_is_farthest_off_is_told(search, monkeypatch):
    base = search.dataset.prior * [1.1, 0.5, 3.0, 1.2, 1.0, 9.0, 9.0, 9.0, 9.0]
    monkeypatch.setattr(search.gram, "fold_strengths", lambda columns: np.array([base]))
    assert search.farthest_off_drawing(search.plain) == ("foot_moment", pytest.approx(3.0))


def spring(stiffness_N_m):
    """20 s of the slider, and the force of a spring for the same motion."""
    columns = dict(talus.simulate(talus.read(SLIDER), duration_s=20, seed=6, encoder_bits=20).columns)
    columns["slider_force_N"] = columns["slider_force_N"] + stiffness_N_m * (columns["slider_m"] - np.mean(columns["slider_m"]))
    return talus.Recording(columns)


def test_a_mass_that_an_effect_turns_negative_is_found_beside_that_effect(tmp_path):
    """Over a band about w a spring is k x = -(k/w^2) a: far more than the slider's mass."""
    spring(60000.0).write(tmp_path / "run.csv")
    dataset, _ = recorded(SLIDER, tmp_path, tmp_path / "run.csv")
    plain, found = plain_base(dataset), next(machine_bases(dataset))
    assert plain[0] < 0 and not has_inertia(dataset, plain)
    assert found[0] == pytest.approx(80.0, rel=0.02)


@pytest.mark.parametrize("stiffness_N_m", [20000.0, pytest.param(60000.0, marks=pytest.mark.long)])
def test_a_spring_stiffer_than_the_mass_is_named(stiffness_N_m):
    """No sensor is too coarse, and no force counts the other way."""
    found = talus.diagnose(SLIDER, spring(stiffness_N_m))
    assert not found.report["findings"] and found.report["calibrated"]
    (effect,) = found.effects
    assert effect["effect"] == "parallel_spring" and effect["probability"] > 0.9
    assert effect["parameters"]["stiffness_Nm_rad"] == pytest.approx(stiffness_N_m, rel=0.01)


def test_a_fine_encoders_gap_does_not_make_the_drawing_count_for_more():
    """Torques tell inertia and gravity; a form's error that an encoder sees a million times better says nothing of them."""
    left = {True: {"T0": 500.0, "T1": 300.0, "E": 1e9}, False: {"T0": 50.0, "T1": 30.0, "E": 1e5}}
    search = SimpleNamespace(dataset=SimpleNamespace(kinds=["E", "T0", "T1"]), tolerated_of={"T0": 10.0, "T1": 10.0, "E": 10.0}, chance=14.0,
                             held_out_excess=lambda chosen: left[not chosen])  # fmt: skip
    search.temperature = lambda *about: Search.temperature(search, *about)
    assert of_torques(search, SimpleNamespace(chosen=["one"])) == pytest.approx(14.0 + 0.1 * 60.0 + 0.02**2 * 800.0)


PENDULUM = REPOSITORY / "models/pendulum.yaml"
SPRING = """effects:
- effect: parallel_spring
  joint: joint
  parameters: {{stiffness_Nm_rad: {0}, stiffening_Nm_rad3: {1}, preload_Nm: 0.0, bend_Nm_rad2: {2}, bumper_Nm_rad: 0.0, bumper_rad: 0.0, bumper_side: 0}}
"""


def beside_a_spring(rate_Hz, *coefficients, machine=(0.045, 0.15)):
    """What is said of a pendulum with a spring, its inertia [kg m2] and moment [kg m] as here."""
    text = PENDULUM.read_text() + SPRING.format(*coefficients)
    text = text.replace("inertia_kg_m2: 0.045", f"inertia_kg_m2: {machine[0]}").replace("moment_kg_m: 0.15", f"moment_kg_m: {machine[1]}")
    return talus.diagnose(PENDULUM, talus.simulate(talus.Model.from_text(text), duration_s=60, rate_hz=rate_Hz))


@pytest.mark.long
@pytest.mark.parametrize(("rate_Hz", "linear", "cube", "moment_kg_m"), [
    (100, 0.0, 2.0, 0.15), (250, 0.0, 2.0, 0.17), (250, 3.0, 0.0, 0.13)])  # fmt: skip
def test_a_springs_size_is_told_beside_the_drawn_gravity(rate_Hz, linear, cube, moment_kg_m):
    """A line less a sine is a cube: beside any gravity -57 q + 11 q^3 Nm does as well as 2 q^3."""
    found = beside_a_spring(rate_Hz, linear, cube, 0.0, machine=(0.042, moment_kg_m))
    (effect,) = found.effects
    assert effect["effect"] == "parallel_spring" and effect["probability"] > 0.5
    for name, true in (("stiffness_Nm_rad", linear), ("stiffening_Nm_rad3", cube)):
        low, high = effect["interval"].get(name, [effect["parameters"].get(name, 0.0)] * 2)
        assert low <= true <= high and high - low < 12.0, name
    assert found.model.base["gravity_sin"] == pytest.approx(moment_kg_m, rel=2 * PART)


@pytest.mark.long
def test_beside_a_machine_that_is_not_drawn_sizes_are_told_as_the_recording_has_them():
    found = beside_a_spring(250, 3.0, 0.0, 0.0, machine=(0.2, 0.9))
    (effect,) = found.effects
    assert effect["effect"] == "parallel_spring"
    assert found.model.base["inertia"] == pytest.approx(0.2, rel=0.01)


@pytest.mark.long
@pytest.mark.parametrize("rate_Hz", [80, 100])
def test_a_spring_that_moves_gravity_is_no_elasticity_beside_another_machine(rate_Hz):
    """The fit without any effect finds another gravity, and that beside an elasticity is 4.5 times the file's; so it is through half the low-pass."""
    found = beside_a_spring(rate_Hz, 0.0, 2.0, 0.5).report
    assert found["verdict"]["effect"] == "parallel_spring" and found["verdict"]["probability"] > 0.5
    assert found["lowpass"]["stable"]


# ---- a model file of first guesses, and a friction that it does not have --------------------

ADDED = {  # of the drive's torque (RMS), by speed over its largest
    "levelling": lambda v: 0.5 * np.tanh(v / 0.3),
    "asymmetric": lambda v: 0.4 * np.abs(v),
}


@needs_data
@pytest.mark.parametrize(("joint", "kind"), [(5, "levelling"), (2, "asymmetric")])
def test_a_friction_beside_a_first_guess_is_no_unit_and_no_sign(joint, kind):
    """In degrees all of a wrist's torques but Coulomb's would hardly bear, and so fit any model file; with its current's sign turned an
    arm would keep its gravity, but friction would drive it."""
    model = talus.Model.from_text(re.sub(r"(?m)^score:.*\n", "", data("ur10e_joints/model.yaml").read_text(encoding="utf-8")))
    columns = dict(talus.Recording.read(data(f"ur10e_joints/ur10e_joint_{joint}.csv")).columns)
    current, speed = columns["joint_current_A"], columns["joint_velocity_rad_s"]
    columns["joint_current_A"] = current + np.std(current) * ADDED[kind](speed / np.quantile(np.abs(speed), 0.99))
    assert not gate.findings(model, ["run.csv"], [talus.Recording(columns)])


@functools.cache
def beside_a_cubic_spring(share):
    """What is said of the shoulder of a real arm where a spring's cube, so large a share of its current (RMS), was added to that."""
    model = talus.Model.from_text(re.sub(r"(?m)^score:.*\n", "", data("ur10e_joints/model.yaml").read_text(encoding="utf-8")))
    columns = dict(talus.Recording.read(data("ur10e_joints/ur10e_joint_2.csv")).columns)
    low, high = np.quantile(columns["joint_rad"], (0.001, 0.999))
    current = columns["joint_current_A"]
    columns["joint_current_A"] = current + share * np.sqrt(np.mean(current**2)) * ((2 * columns["joint_rad"] - low - high) / (high - low)) ** 3
    return talus.diagnose(model, talus.Recording(columns)).report


@pytest.mark.long
@needs_data
@pytest.mark.parametrize("share", [0.26, 0.51])
def test_a_spring_that_takes_the_inertia_is_named(share):
    found = beside_a_cubic_spring(share)
    named = [found["verdict"], *found["alternatives"]]
    assert sum(one["probability"] for one in named if one["effect"] == "parallel_spring") > 0.2


@pytest.mark.long
@needs_data
@pytest.mark.parametrize("share", [0.26, 0.51])
def test_a_spring_that_takes_the_inertia_is_no_coarse_sensor(share):
    """Without it the shoulder's inertia is fitted as a hundredth of what it is, or as negative, and no such machine moves as this one did:
    the sensors are as good as they were, and there are replicates of the machine that has the spring."""
    found = beside_a_cubic_spring(share)
    assert not found["findings"] and found["calibrated"] and abs(found["lowpass"]["inertia_bias"]) < 0.2


# ---- an inertia that the sensors take ---------------------------------------------------


@pytest.mark.parametrize(("bits", "seed"), [(11, 5), (11, 6), (12, 5), (12, 6)])
def test_replicates_have_more_of_the_inertia_that_coarse_sensors_hide(bits, seed, tmp_path):
    """Its true value stands in the file that the recording was simulated from."""
    pendulum = REPOSITORY / "models/pendulum.yaml"
    talus.simulate(talus.read(pendulum), duration_s=20, seed=seed, encoder_bits=bits, rate_hz=500).write(tmp_path / "run.csv")
    dataset, _ = recorded(pendulum, tmp_path, tmp_path / "run.csv")
    fitted = plain_base(dataset)
    dataset.inertia_kept = 1.0 + lowpass.inertia_bias(dataset, 1)
    true, seen, whole = 0.045, fitted[0], dataset.with_whole_inertia(fitted)
    assert seen < 0.8 * true and abs(whole[0] - true) < 0.75 * abs(seen - true)
    assert np.array_equal(whole[1:], fitted[1:])  # friction and gravity stay
