"""What the recordings' other readings add to the standard deviations, against NumPy's own sums."""

import json
import re

import numpy as np
import pytest
import talus
from sigma_table import FEW, draw, inside, measured
from support import REPOSITORY, run
from talus import check, constants, ffi, lib, pointer

TRUE = np.array([80.0, 20.0, 150.0, 3.0])  # a slider's mass, Coulomb and viscous friction, offset


def factor_of(x, y):
    """A joint's factor of these rows."""
    out = ffi.new("tl_factor[1]")
    check(lib.tl_factor_init(out, x.shape[1]))
    block = np.ascontiguousarray(np.column_stack([x, y]).T)
    lib.tl_factor_add(out, pointer(block), len(y), len(y))
    return out


def toy(seed, noise=0.2, n=4000):
    """(x seen, y, the readings' x): acceleration with noise, clean other columns; readings by noise drawn anew."""
    rng = np.random.default_rng(seed)
    true = np.column_stack([rng.standard_normal(n), rng.choice([-1.0, 1.0], n), 0.4 * rng.standard_normal(n), np.ones(n)])
    y = true @ TRUE + 2.0 * rng.standard_normal(n)
    seen = true.copy()
    seen[:, 0] += noise * rng.standard_normal(n)
    rounded = []
    for _ in range(constants.TL_ROUNDINGS):
        rounded.append(seen.copy())
        rounded[-1][:, 0] += np.sqrt(constants.TL_ROUNDING_VARIANCE) * noise * rng.standard_normal(n)
    longer = seen * [1.01, 1.0, 1.0, 1.0]
    return seen, y, rounded, longer


def answer(seed, noise=0.2, residuals=False, still=None, other=None):
    """(result, rows of the toy); without `residuals` the standard deviations are from the readings alone. `still`: a rounded reading in
    which nothing moves; `other`: one of another problem."""
    seen, y, rounded, longer = toy(seed, noise)
    model = talus.Model("slider")
    model.set_parameters(mass_kg=70.0, coulomb_N=15.0, viscous_Ns_m=100.0)
    factor, problem, result = factor_of(seen, y), ffi.new("tl_problem *"), ffi.new("tl_identify_result *")
    settings = ffi.new("tl_identify_settings *", lib.tl_identify_defaults())
    check(lib.tl_problem_init(problem, model.struct, settings, factor))
    memory, best = np.empty(lib.tl_identify_memory(problem)), np.empty(problem.parameters)
    check(lib.tl_identify_swarm(problem, pointer(memory), len(memory), pointer(best), ffi.NULL))
    check(lib.tl_identify_conclude(problem, pointer(best), result))
    rest = np.std(y - seen @ least_squares(seen, y))
    white = rest * np.sqrt(np.diag(np.linalg.inv(seen.T @ seen)))
    for i in range(4):
        result.sigma[i] = result.base_sigma[i] = white[i] if residuals else 0.0
    readings = ffi.new("tl_readings *")
    pairs = [(readings.rounded + k, x) for k, x in enumerate(rounded)]
    for out, x in [(ffi.addressof(readings, "as_recorded"), seen), (ffi.addressof(readings, "longer"), longer), *pairs]:
        check(lib.tl_problem_merge(problem, factor_of(x, y), out))
    if still is not None:
        readings.rounded[still].rows = 0
    if other is not None:
        readings.rounded[other].columns += 1
    check(lib.tl_identify_readings(problem, readings, result))
    return result, seen, y, rounded, longer


def least_squares(x, y):
    return np.linalg.lstsq(x, y, rcond=None)[0]


def test_variances_are_those_of_the_formulas():
    result, seen, y, rounded, longer = answer(1)
    b = least_squares(seen, y)
    every = np.array([least_squares(x, y) for x in rounded])
    gram = seen.T @ seen
    noise = (np.mean([x.T @ x for x in rounded], axis=0) - gram) / constants.TL_ROUNDING_VARIANCE
    lacking = np.linalg.solve(gram - noise, gram @ b) - b  # Fuller 1987, (1.2.4), with the noise that was measured
    variance = every.var(0, ddof=1) / constants.TL_ROUNDING_VARIANCE + lacking**2 + (least_squares(longer, y) - b) ** 2
    assert [result.systematic[i] for i in range(4)] == pytest.approx(np.sqrt(variance), rel=1e-5)
    assert [result.base_sigma[i] for i in range(4)] == pytest.approx(np.sqrt(variance), rel=1e-5)
    assert not any(result.hidden[i] for i in range(4))


@pytest.mark.parametrize("noise", [0.05, 0.2, 0.4])
def test_truth_is_covered_where_the_regressor_is_noisy(noise):
    """The mass is found too small by noise^2 / (1 + noise^2): the reported standard deviation knows it."""
    for seed in range(20):
        result = answer(seed, noise)[0]
        assert abs(result.value[0] - TRUE[0]) <= 3 * result.systematic[0] + 3 * 2.0 / np.sqrt(4000)
        assert result.systematic[0] == pytest.approx(TRUE[0] * noise**2 / (1 + noise**2), rel=0.3, abs=1.2)


def test_more_noise_than_motion_hides_the_mass_alone():
    result = answer(3, 2.0, residuals=True)[0]
    assert [result.hidden[i] for i in range(4)] == [1, 0, 0, 0]
    assert np.isnan(result.sigma[0]) and not np.isnan(result.sigma[1])


def test_noise_that_hides_the_whole_motion_hides_every_parameter():
    """One step more, and the angle stands still: nothing that was found is known."""
    result = answer(3, residuals=True, still=2)[0]
    assert all(result.hidden[i] and np.isnan(result.sigma[i]) and np.isnan(result.base_sigma[i]) for i in range(4))
    assert [result.systematic[i] for i in range(4)] == [abs(result.value[i]) for i in range(4)]


@pytest.mark.parametrize("still", [None, 1])
def test_readings_of_another_problem_are_refused(still):
    with pytest.raises(talus.TalusError):
        answer(3, still=still, other=2)


def test_rounding_adds_twice_the_noise_and_differs_each_time():
    x = np.cumsum(np.random.default_rng(4).uniform(0, 1, 20_000))
    errors = []
    for number in range(constants.TL_ROUNDINGS):
        for joint in (0, 1):
            y = x.copy()
            lib.tl_round_angles(pointer(y), len(y), 0.01, number, joint)
            errors.append(y - x)
    assert np.var(errors, axis=1) == pytest.approx(2 * 0.01**2, rel=0.05)
    assert np.abs(np.corrcoef(errors) - np.eye(len(errors))).max() > 0.1  # the same steps, set off
    assert len({np.round(e[0], 9) for e in errors}) == len(errors)
    y = x.copy()
    lib.tl_round_angles(pointer(y), len(y), 0.0, 0, 0)
    assert np.array_equal(x, y)


def test_an_inertia_that_cannot_be_fixed_is_said(tmp_path):
    model, recording, page = REPOSITORY / "models" / "slider.yaml", tmp_path / "r.csv", tmp_path / "r.html"
    run("talus-sim", "--model", model, "--out", recording, "--rate", 250, "--encoder-bits", 12, "--duration", 20)
    done = run("talus-identify", "--quiet", "--model", model, "--out", tmp_path / "f.yaml", "--report", tmp_path / "r.json",
               "--html", page, recording)  # fmt: skip
    mass = json.loads((tmp_path / "r.json").read_text())["parameters"]["mass_kg"]
    assert mass["hidden_by_noise"] and mass["sigma"] is None and mass["identifiable"]
    assert "these recordings do not fix mass_kg" in done.stderr
    assert "these recordings do not fix mass_kg" in page.read_text()


def test_what_sensors_move_by_more_than_tenfold_gets_no_figure(tmp_path):
    """8 bits at 1000 Hz: percents of nearly nothing had up to seven digits."""
    path, model = tmp_path / "b.csv", REPOSITORY / "models/pendulum.yaml"
    said = {}
    for bits in (8, 10):
        run("talus-sim", "--model", model, "--out", path, "--encoder-bits", bits, "--duration", "20", "--rate", "1000")
        said[bits] = run("talus-identify", "--quiet", "--model", model, "--out", tmp_path / "o.yaml", path).stderr
    assert "inertia_kg_m2: resolution, noise and sampling of the angles move it by more than 10 times what was found" in said[8]
    assert re.search(r"inertia_kg_m2: resolution, noise and sampling of the angles move it by \d{2,4} % of what was found", said[10])


def test_what_sensors_hide_and_hardly_move_gets_no_figure(tmp_path):
    """A free rotor in steps of torque, through 12 bits: "0 %, and it may be any amount too small" contradicted itself."""
    path, model, step_s = tmp_path / "r.csv", tmp_path / "m.yaml", 0.001
    model.write_text("plant: pendulum\ngravity_m_s2: 9.81\ninertia_kg_m2: 0.002\ngravity_moment_kg_m: 0\ngravity_zero_rad: 0.0\njoint:\n"
                     "  transmission: {type: fixed, ratio: 1}\n  torque_constant_Nm_A: 0.1\n"
                     "  friction: {coulomb_Nm: 0.02, viscous_Nms_rad: 0.01}\n")  # fmt: skip
    t = step_s * np.arange(20_000)
    torque = 0.06 * np.where(t // 2.0 % 2 == 0, 1.0, 0.7)
    angle, speed, q = 0.0, 0.0, np.empty(len(t))
    for k, now in enumerate(torque):
        q[k] = angle
        speed += step_s * (now - 0.02 * np.tanh(speed / 0.01) - 0.002 * speed) / 0.002
        angle += step_s * speed
    seen, noise = np.round(q * 4096 / (2 * np.pi)) * 2 * np.pi / 4096, 0.001 * np.random.default_rng(1).standard_normal(len(t))
    np.savetxt(path, np.c_[t, seen, torque + noise], delimiter=",", header="time_s,joint_rad,joint_torque_Nm", comments="")
    said = run("talus-identify", "--quiet", "--model", model, "--out", tmp_path / "o.yaml", path).stderr
    assert "do not fix viscous_Nms_rad: resolution, noise and sampling of the angles hide some of it, and it may be any amount too small" in said


def test_a_motion_that_coarser_steps_would_hide_is_identified_without_a_deviation(tmp_path):
    """Slow ramps through 12 bits: of five minutes a second is faster than standstill, and of some of the roundings nothing."""
    model, recording = REPOSITORY / "models" / "slider.yaml", tmp_path / "r.csv"
    run("talus-sim", "--model", model, "--out", recording, "--excitation", "ramps", "--fit", "--rate", 500, "--duration", 300,
        "--encoder-bits", 12, "--seed", 1041110777)  # fmt: skip
    run("talus-identify", "--quiet", "--model", model, "--out", tmp_path / "f.yaml", "--report", tmp_path / "r.json", recording)
    said = json.loads((tmp_path / "r.json").read_text())["parameters"]
    assert all(one["hidden_by_noise"] and one["sigma"] is None for one in said.values() if one["identifiable"])


@pytest.mark.parametrize(("plant", "rate", "seconds"), [("leg", 250, 16), ("slider", 250, 16), ("pendulum", 250, 16), ("leg", 1000, 24)])
def test_python_takes_the_same_sums(tmp_path, plant, rate, seconds):
    """Of a recording that is read again whole, and of one that is in excerpts."""
    model, recording = REPOSITORY / "models" / f"{plant}.yaml", tmp_path / "r.csv"
    run("talus-sim", "--model", model, "--out", recording, "--rate", rate, "--duration", seconds)
    run("talus-identify", "--quiet", "--model", model, "--out", tmp_path / "f.yaml", "--report", tmp_path / "r.json", recording)
    said = json.loads((tmp_path / "r.json").read_text())["parameters"]
    assert (rate * seconds > constants.TL_READING_ROWS) == (rate == 1000)
    fit = talus.identify(talus.Model.read(model), [talus.Recording.read(recording)])
    for name, value in said.items():
        assert fit.sigma[name] == pytest.approx(np.nan if value["sigma"] is None else value["sigma"], rel=1e-6, nan_ok=True), name


def shifted(x, share):
    """(share of the reading, share by the eigenvalues of the two Gram matrices) where a column is seen in part of the rows."""
    factor, problem = factor_of(x, x @ TRUE + 1.0), ffi.new("tl_problem *")
    check(lib.tl_problem_init(problem, talus.Model("slider").struct, ffi.new("tl_identify_settings *", lib.tl_identify_defaults()), factor))
    part = x[: int(len(x) * share)]
    reading, out = ffi.new("tl_factor *"), ffi.new("double *")
    check(lib.tl_problem_merge(problem, factor_of(part, part @ TRUE), reading))
    check(lib.tl_reading_share(problem, reading, out))
    ratio = np.linalg.solve(x.T @ x / len(x), part.T @ part / len(part))
    return out[0], np.linalg.eigvals(ratio).real.min()


def test_share_is_that_of_the_weakest_direction():
    x = toy(2)[0]
    x[:, 1] *= np.linspace(0.1, 2.0, len(x))  # the friction shows late
    for share in (0.1, 0.5, 1.0):
        found, expected = shifted(x, share)
        assert found == pytest.approx(expected, rel=1e-6)
    assert shifted(x, 1.0)[0] == pytest.approx(1.0)


def test_a_motion_outside_of_the_excerpts_has_the_recording_read_whole(monkeypatch):
    """Where the joint moves between the places alone, excerpts hold no row that counts."""
    model, rate, seconds = talus.read("models/pendulum.yaml"), 1000, 60
    moving = talus.simulate(model, duration_s=20, rate_hz=rate)
    at = np.clip(np.arange(rate * seconds) - 3 * rate, 0, 5 * rate)  # from 3 to 8 s: places of 2 s begin at 0 and 8.3 s
    columns = {name: values[at] for name, values in moving.columns.items()}
    recording = talus.Recording({**columns, "time_s": np.arange(rate * seconds) / rate})

    def sigma():
        return talus.identify(model, [recording]).sigma

    found = sigma()
    monkeypatch.setattr(constants, "TL_READING_ROWS", len(recording.t))
    assert sigma() == pytest.approx(found, nan_ok=True)
    monkeypatch.undo()
    monkeypatch.setattr(constants, "TL_READING_SHARE", 0.0)
    with pytest.raises(talus.TalusError):
        sigma()


@pytest.mark.long
def test_truth_lies_within_three_sigma_on_every_bench():
    share, count = inside(measured(draw(FEW)))
    print(f"{100 * share:.1f} % of {count} parameters within three standard deviations")
    assert share >= 0.97
