"""tools/bench on next to nothing: each bench runs, and both of its sides compute the same thing. No
timing is judged here. What needs a peer that only `make bench` and `make check-long` install is long, and fails without it."""

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest
from support import BUILD, REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tools" / "bench"))

import job  # noqa: E402
import numpy_leg  # noqa: E402
from talus import Model, lib, pointer  # noqa: E402

pytestmark = pytest.mark.release  # figures of a sanitized build mean nothing, and Pinocchio cannot be linked with it

BENCHES = [
    pytest.param("job", "pyswarms", marks=pytest.mark.long),
    pytest.param("inverse", "pinocchio", marks=pytest.mark.long),
    ("signals", "scipy"),
    ("reading", "pandas"),
    ("growth", "numpy"),
    ("diagnosis", "numpy"),
    pytest.param("markers", "cv2", marks=pytest.mark.long),
    ("exporting", "can"),
]


class Tiny:
    """The size that a test can wait for, in a folder of its own but for the compiled programs."""

    build, folder, repository = BUILD, BUILD / "bench", REPOSITORY

    @staticmethod
    def scaled(_full, tiny):
        return tiny


@pytest.fixture(scope="module")
def leg():
    return Model.read(REPOSITORY / "models" / "leg.yaml")


@pytest.fixture(scope="module")
def data(leg):
    return job.recording(leg, 500)


@pytest.fixture(scope="module")
def ours(leg, data):
    return job.Ours(leg, data, iterations=20)


def test_peers_model_is_the_library_s(leg):
    assert {name: pytest.approx(value) for name, value in numpy_leg.PRIOR.items()} == leg.parameters
    assert numpy_leg.base(np.array(list(numpy_leg.PRIOR.values()))) == pytest.approx(list(leg.base.values()))


def test_peers_torques_are_the_library_s(leg, data):
    expected = leg.inverse(data.q, data.v, data.a)
    pose = numpy_leg.pose(data.q, data.v)
    got = numpy_leg.torques(list(numpy_leg.PRIOR.values()), data.q, data.v, data.a, pose)
    assert np.array(got) == pytest.approx(expected, rel=1e-11, abs=1e-14)


def test_peers_regressor_predicts_the_library_s_torques(leg, data):
    rows, known = numpy_leg.regressor(data.q, data.v, data.a)
    expected = leg.inverse(data.q, data.v, data.a).ravel()
    assert known + rows @ list(leg.base.values()) == pytest.approx(expected, rel=1e-11, abs=1e-14)


def test_costs_and_least_squares_agree(ours, data):
    """Every cost that a swarm is given, at random particles; the library's own among them."""
    particles = job.random_particles(ours.bounds(), 7)
    cost, solution = job.agreement(ours, data, particles)
    assert cost <= 1e-12 and solution <= 1e-8
    least = numpy_leg.factor_cost(ours.triangle(), 500)(particles) - job.numpy_least_squares(data)[1]
    excess = [2.0 * lib.tl_identify_cost(pointer(x), ours.problem) for x in particles]
    assert excess == pytest.approx(least, rel=1e-9)


def test_job_does_all_of_its_evaluations(ours):
    ours.whole()
    assert ours.evaluations[0] == job.PARTICLES * 20
    assert ours.problem.settings.weighting == lib.TL_WEIGHT_EQUAL


@pytest.mark.long
def test_pyswarms_evaluates_what_it_is_timed_for(ours, data, tmp_path, monkeypatch):
    """As many costs as talus computes: one a particle and iteration. It leaves no file behind."""
    monkeypatch.chdir(tmp_path)
    seen, cost = [], numpy_leg.factor_cost(ours.triangle(), 500)

    def counting(particles):
        seen.append(len(particles))
        return cost(particles)

    job.pyswarms_run(counting, ours.bounds(), 20)()
    assert seen == [job.PARTICLES] * 20 and not list(tmp_path.iterdir())


def test_signals_agree():
    signals = importlib.import_module("signals")
    t, x = signals.signal(400)
    sides = signals.Ours(t, x)
    sides.reconstruct()
    # SciPy solves for its kernel through powers of the sample number, which costs it eight digits
    assert max(signals.difference(sides.out, signals.savgol(x))) <= 1e-6


def test_reader_and_pandas_agree(tmp_path):
    reading = importlib.import_module("reading")
    path = tmp_path / "rec.csv"
    reading.write(path, 500)
    one, other = reading.ours(Tiny, path), reading.peer(path)
    assert one["rows"] == 500 and list(one["sum"]) == list(reading.COLUMNS)
    assert reading.difference(one, other) <= 1e-12


def test_reader_sums_what_was_written(tmp_path):
    reading = importlib.import_module("reading")
    path = tmp_path / "rec.csv"
    reading.write(path, 500)
    table = np.genfromtxt(path, delimiter=",", names=True)
    got = reading.ours(Tiny, path)
    assert got["rows"] == 500
    assert [got["sum"][name] for name in reading.COLUMNS] == pytest.approx(
        [table[name].sum() for name in reading.COLUMNS], rel=1e-12, abs=1e-9
    )


def test_growth_repeats_the_minute(tmp_path):
    growth = importlib.import_module("growth")
    minute, path = tmp_path / "minute.csv", tmp_path / "long.csv"
    minute.write_text("time_s,knee_current_A\n0.250000,1\n0.500000,2.50\n")
    growth.repeat(minute, path, 3, 60)
    assert path.read_text().splitlines()[1:] == [
        "0.250000,1", "0.500000,2.50", "60.250000,1", "60.500000,2.50", "120.250000,1", "120.500000,2.50"
    ]  # fmt: skip


def test_peak_tells_status_time_and_memory():
    script = "import sys, time; x = bytearray(50_000_000); time.sleep(0.2); sys.exit(3)"
    done = subprocess.run([BUILD / "bench" / "peak", sys.executable, "-c", script], check=True, capture_output=True)
    used = json.loads(done.stdout)
    assert used["status"] == 3 and used["wall_s"] >= 0.2 and used["cpu_s"] > 0.0
    assert used["peak_kB"] >= 50_000_000 / 1024


@pytest.mark.long
def test_pinocchio_agrees():
    """Compiles against Pinocchio's headers where they are: half a minute the first time."""
    found = importlib.import_module("inverse").measure(Tiny)
    assert found["difference"] <= 1e-12
    assert len(found["rnea"]) == len(found["single"]) == len(found["batch"]) == len(found["tick"]) == 3
    assert found["status"] == 0  # the controller's, once it has come in


@pytest.mark.parametrize(("bench", "peer"), BENCHES)
def test_bench_runs(bench, peer):
    assert importlib.util.find_spec(peer), f"{peer} is installed by `make bench` and `make check-long`"
    outcome = importlib.import_module(bench).bench(Tiny)
    assert outcome.comparisons or outcome.figures
    for comparison in outcome.comparisons:
        assert comparison.ratio > 0.0 and len(list(comparison.lines())) >= 3
        json.dumps(comparison.as_json())
    json.dumps(outcome.figures)
    assert not [p for p in Tiny.folder.iterdir() if p.suffix in (".csv", ".yaml")]
