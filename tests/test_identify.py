"""lib/identify.c against linear least squares, SciPy's optimiser, and a twin's known truth."""

import json

import numpy as np
import pytest
import talus
import yaml
from scipy.optimize import minimize
from support import REPOSITORY, run
from talus import check, ffi, lib, pointer
from talus.identification import factors
from test_regression import PENDULUM, pendulum_recording, stacked

LEG = REPOSITORY / "models" / "leg.yaml"


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    """A recording of the example leg, its truth, and a model with wrong CAD values."""
    folder = tmp_path_factory.mktemp("twin")
    run("talus-sim", "--model", LEG, "--out", folder / "a.csv", "--duration", 40, "--seed", 5)
    tree = yaml.safe_load(LEG.read_text())
    tree["shank"]["com_m"] *= 1.08
    tree["shank"]["inertia_kg_m2"] *= 0.85
    tree["foot"]["com_m"] *= 0.93
    tree["foot"]["inertia_kg_m2"] *= 1.2
    tree["ankle_motor"]["com_m"] *= 0.95
    tree["ankle"]["rotor_inertia_kg_m2"] *= 1.15
    tree["knee"]["friction"]["coulomb_Nm"] *= 0.7
    tree["ankle"]["friction"]["viscous_Nms_rad"] *= 1.3
    (folder / "cad.yaml").write_text(yaml.safe_dump(tree))
    return folder


@pytest.fixture(scope="module")
def problem_of(twin):
    model = talus.Model.read(twin / "cad.yaml")
    factor, rows = factors(model, [talus.Recording.read(twin / "a.csv")])

    def make(**settings):
        s = ffi.new("tl_identify_settings *", lib.tl_identify_defaults())
        for name, value in settings.items():
            setattr(s.swarm if hasattr(s.swarm, name) else s, name, value)
        problem = ffi.new("tl_problem *")
        check(lib.tl_problem_init(problem, model.struct, s, factor))
        return problem

    make.model, make.rows = model, rows
    return make


def swarm(problem):
    memory, best = np.empty(lib.tl_identify_memory(problem)), np.empty(problem.parameters)
    spent = ffi.new("uint64_t *")
    check(lib.tl_identify_swarm(problem, pointer(memory), len(memory), pointer(best), spent))
    result = ffi.new("tl_identify_result *")
    check(lib.tl_identify_conclude(problem, pointer(best), result))
    return best, result, spent[0]


def weighted_least_squares(problem, rows, bases):
    """The same problem by numpy.linalg.lstsq over all rows: base parameters and cost per row."""
    x, z = [], []
    for recording in rows:
        for joint, parts in enumerate(recording):
            dense, target, _ = stacked(parts, bases)
            x.append(dense * problem.weight[joint]), z.append(target * problem.weight[joint])
    x, z = np.concatenate(x), np.concatenate(z)
    scale = np.linalg.norm(x, axis=0)
    base = np.linalg.lstsq(x / scale, z, rcond=None)[0] / scale
    return base, np.sum((z - x @ base) ** 2) / len(z)


def test_twenty_seeds_reach_least_squares_to_1e_9(problem_of):
    """Default settings, no start from least squares, no polish."""
    problem = problem_of()
    want, cost = weighted_least_squares(problem, problem_of.rows, len(problem_of.model.base))
    worst_cost = worst_base = 0.0
    for seed in range(1, 21):
        problem.settings.swarm.seed = seed
        best, result, evaluations = swarm(problem)
        base = np.array([result.base[i] for i in range(len(want))])
        worst_cost = max(worst_cost, result.cost / cost - 1)
        worst_base = max(worst_base, np.max(np.abs(base / want - 1)))
    print(f"20 seeds: cost {worst_cost:.1e}, base parameters {worst_base:.1e}, {evaluations} evaluations each")
    assert worst_cost <= 1e-9 and worst_base <= 1e-6


def test_the_certificate_is_that_of_numpy(problem_of):
    problem = problem_of()
    _, result, _ = swarm(problem)
    _, cost = weighted_least_squares(problem, problem_of.rows, len(problem_of.model.base))
    assert result.least_squares_cost == pytest.approx(cost, rel=1e-9)


def test_one_null_direction_with_its_three_names(problem_of):
    problem = problem_of()
    _, result, _ = swarm(problem)
    names = list(problem_of.model.parameters)
    direction = {n: result.null_direction[0][i] for i, n in enumerate(names)}
    assert result.null_count == 1
    assert {n for n, x in direction.items() if abs(x) > 1e-6} == {
        "ankle_motor_com_m", "shank_com_m", "shank_inertia_kg_m2"}
    # moving along it changes no base parameter, to first order
    model = problem_of.model.copy()
    at = {n: result.value[i] for i, n in enumerate(names)}
    step = 1e-6
    ahead, behind = ({n: at[n] + s * direction[n] * problem.scale[i] for i, n in enumerate(names)} for s in (step, -step))
    model.set_parameters(**ahead)
    base_ahead = np.array(list(model.base.values()))
    model.set_parameters(**behind)
    base_behind = np.array(list(model.base.values()))
    assert np.max(np.abs(base_ahead - base_behind) / np.abs(base_ahead)) < 1e-10


def test_what_cannot_be_identified_is_nearest_to_the_prior(problem_of):
    """Against SLSQP on the same rule: least squared relative change under the identified combinations."""
    problem = problem_of()
    _, result, _ = swarm(problem)
    m = problem_of.model.struct
    names = list(problem_of.model.parameters)
    prior = np.array([problem.prior[i] for i in range(len(names))])
    three = [names.index(n) for n in ("ankle_motor_com_m", "shank_com_m", "shank_inertia_kg_m2")]
    inertia, moment = (result.base[list(problem_of.model.base).index(n)] for n in ("shank_inertia", "shank_moment"))

    def constraints(x):
        dma, ds, i1 = x * prior[three]
        return [(i1 + m.shank_mass_kg * ds**2 + m.ankle_motor_mass_kg * dma**2) / inertia - 1,
                (m.shank_mass_kg * ds + m.ankle_motor_mass_kg * dma) / moment - 1]

    solved = minimize(lambda x: np.sum((x - 1) ** 2), np.ones(3), constraints={"type": "eq", "fun": constraints},
                      method="SLSQP", options={"ftol": 1e-15, "maxiter": 200})
    mine = np.array([result.value[i] for i in three]) / prior[three]
    assert solved.success and np.max(np.abs(constraints(mine))) < 1e-9
    assert mine == pytest.approx(solved.x, abs=1e-6)


def test_any_number_of_threads_gives_the_same_bytes(twin):
    outputs = []
    for threads in (1, 2, 4):
        run("talus-identify", "--model", twin / "cad.yaml", "--out", twin / "f.yaml", "--report", twin / "r.json",
            "--threads", threads, "--seed", 3, twin / "a.csv")
        outputs.append(((twin / "f.yaml").read_bytes(), (twin / "r.json").read_bytes()))
    assert outputs[0] == outputs[1] == outputs[2]
    run("talus-identify", "--model", twin / "cad.yaml", "--out", twin / "f.yaml", "--report", twin / "r.json",
        "--seed", 4, twin / "a.csv")
    assert outputs[0][1] != (twin / "r.json").read_bytes()


def test_a_bound_of_the_user_is_kept_and_said(twin):
    tree = yaml.safe_load((twin / "cad.yaml").read_text())
    tree["bounds"] = {"knee.friction.coulomb_Nm": [0.5, 1.0]}  # the truth is 1.2
    (twin / "bounded.yaml").write_text(yaml.safe_dump(tree))
    done = run("talus-identify", "--model", twin / "bounded.yaml", "--out", twin / "f.yaml", "--report",
               twin / "r.json", twin / "a.csv")
    report = json.loads((twin / "r.json").read_text())
    assert report["parameters"]["knee_coulomb_Nm"]["value"] == pytest.approx(1.0, abs=1e-9)
    assert report["parameters"]["knee_coulomb_Nm"]["at_bound"]
    assert report["cost"] > report["least_squares_cost"] * 1.01
    assert "knee_coulomb_Nm ends at its bound" in done.stderr


def test_a_bound_of_nothing_is_said_as_0(tmp_path):
    """A drive that helps with the speed: no friction is negative, and rounding is no value."""
    model = talus.read(REPOSITORY / "models/pendulum.yaml")
    columns = dict(talus.simulate(model, duration_s=20, encoder_bits=20).columns)
    columns["joint_current_A"] = columns["joint_current_A"] - 0.1 * np.gradient(columns["joint_rad"], columns["time_s"])
    talus.Recording(columns).write(tmp_path / "run.csv")
    done = run("talus-identify", "--model", REPOSITORY / "models/pendulum.yaml", "--out", tmp_path / "f.yaml", tmp_path / "run.csv")
    assert "viscous_Nms_rad ends at its bound, 0\n" in done.stderr


def test_a_prior_ten_times_off_is_no_wall(twin):
    tree = yaml.safe_load((twin / "cad.yaml").read_text())
    tree["knee"]["friction"]["coulomb_Nm"] = 0.02
    tree["ankle"]["rotor_inertia_kg_m2"] = 1e-7
    (twin / "far.yaml").write_text(yaml.safe_dump(tree))
    run("talus-identify", "--model", twin / "far.yaml", "--out", twin / "f.yaml", "--report", twin / "r.json",
        twin / "a.csv")
    report = json.loads((twin / "r.json").read_text())
    assert report["parameters"]["knee_coulomb_Nm"]["value"] == pytest.approx(1.2, rel=0.01)
    assert report["cost"] == pytest.approx(report["least_squares_cost"], rel=1e-9)


def test_huber_shrugs_off_outliers():
    model = talus.Model.from_tree(PENDULUM)
    clean, _ = pendulum_recording(noise_A=0.02)
    columns = dict(clean.columns)
    current = columns["joint_current_A"].copy()
    current[500::400] += 40.0  # single samples far off, always upwards
    fit_square = talus.identify(model, [talus.Recording({**columns, "joint_current_A": current})])
    assert abs(fit_square.parameters["torque_offset_Nm"] - 0.3) > 0.1


def test_huber_command_shrugs_off_outliers(tmp_path):
    clean, _ = pendulum_recording(noise_A=0.02)
    current = clean.columns["joint_current_A"].copy()
    current[500::400] += 40.0
    table = np.column_stack([clean.t, clean.columns["joint_rad"], current])
    np.savetxt(tmp_path / "r.csv", table, delimiter=",", header="time_s,joint_rad,joint_current_A", comments="",
               fmt="%.12g")
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(PENDULUM))
    offset = {}
    for loss in ("square", "huber"):
        run("talus-identify", "--model", tmp_path / "m.yaml", "--out", tmp_path / "f.yaml", "--report",
            tmp_path / "r.json", "--loss", loss, tmp_path / "r.csv")
        offset[loss] = json.loads((tmp_path / "r.json").read_text())["parameters"]["torque_offset_Nm"]["value"]
    assert abs(offset["huber"] - 0.3) < 0.1 * abs(offset["square"] - 0.3)


def test_gravity_is_found_from_any_side():
    """The circle of gravity_zero has no seam: twelve zeros around it are found from a prior of 0."""
    model = talus.Model.from_tree({**PENDULUM, "gravity_zero_rad": 0.0})
    for zero in np.arange(-np.pi + 0.05, np.pi, np.pi / 6):
        recording, (q, v, a, _) = pendulum_recording()
        torque = 0.8 * a + 1.1 * 9.81 * np.sin(q - zero) + 0.3 + 0.9 * np.sign(v) + 0.4 * v
        fit = talus.identify(model, [talus.Recording({**recording.columns, "joint_current_A": torque / 2.0})])
        assert fit.parameters["gravity_zero_rad"] == pytest.approx(zero, abs=5e-3)
        assert fit.parameters["gravity_moment_kg_m"] == pytest.approx(1.1, rel=5e-3)


def test_weights_follow_the_noise_and_can_be_equal(problem_of):
    noisy, equal = problem_of(), problem_of(weighting=lib.TL_WEIGHT_EQUAL)
    assert noisy.weight[0] == pytest.approx(1 / noisy.noise[0]) and noisy.weight[1] == pytest.approx(1 / noisy.noise[1])
    assert equal.weight[0] == equal.weight[1] == 1.0


def test_impossible_problems_are_refused():
    model = talus.Model.from_tree(PENDULUM)
    factor, _ = factors(model, [pendulum_recording()[0]])
    settings, problem = ffi.new("tl_identify_settings *", lib.tl_identify_defaults()), ffi.new("tl_problem *")
    settings.bounded[0], settings.lower[0], settings.upper[0] = 1, 2.0, 1.0
    assert lib.tl_problem_init(problem, model.struct, settings, factor) == lib.TL_ERR_RANGE
    settings.bounded[0] = 0
    empty = ffi.new("tl_factor *")
    check(lib.tl_factor_init(empty, 6))
    assert lib.tl_problem_init(problem, model.struct, settings, empty) == lib.TL_ERR_TOO_SHORT


# ---- what the command says of recordings that cannot give all ---------------------------


def write(path, columns):
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="",
               fmt="%.15g")


@pytest.fixture
def pendulum_files(tmp_path):
    recording, (_, v, _, _) = pendulum_recording()
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(PENDULUM))
    write(tmp_path / "angle.csv", recording.columns)
    columns = {"time_s": recording.t, "joint_velocity_rad_s": v,
               "joint_current_A": recording.columns["joint_current_A"]}
    write(tmp_path / "velocity.csv", columns)
    write(tmp_path / "small_steps.csv", {**recording.columns, "time_s": recording.t * 1e-9})
    return tmp_path


def identified(folder, *names, status=0):
    return run("talus-identify", "-q", "--model", folder / "m.yaml", "--out", folder / "f.yaml",
               *(folder / name for name in names), status=status).stderr


def test_without_an_angle_gravity_is_not_fitted_and_that_is_said(pendulum_files):
    assert "velocity.csv has no joint_rad: gravity is not fitted" in identified(pendulum_files, "velocity.csv")
    done = run("talus-predict", "--model", pendulum_files / "m.yaml", "--out", pendulum_files / "p.csv",
               pendulum_files / "velocity.csv")
    assert "gravity is not predicted" in done.stderr


def test_recordings_with_and_without_an_angle_are_not_mixed(pendulum_files):
    said = identified(pendulum_files, "angle.csv", "velocity.csv", status=2)
    assert "angle.csv has joint_rad and" in said and "velocity.csv has not" in said


def test_times_in_another_unit_are_refused(pendulum_files):
    said = identified(pendulum_files, "small_steps.csv", status=2)
    assert "small_steps.csv: time_s: the median step is 4.0" in said and "e-12 s, expected seconds" in said


@pytest.mark.parametrize("rate, slow", [(250, False), (100, True), (50, True)])
def test_slow_sampling_is_warned_of(tmp_path, rate, slow):
    run("talus-sim", "--model", LEG, "--out", tmp_path / "r.csv", "--duration", 30, "--rate", rate)
    done = run("talus-identify", "-q", "--model", LEG, "--out", tmp_path / "f.yaml", tmp_path / "r.csv")
    assert ("slow for a low-pass" in done.stderr) == slow
