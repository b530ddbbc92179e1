"""What talus-gap takes: memory on long recordings, of which it looks at stretches (on labelled cases: test_gap_cases.py); and the
same bytes however many threads make columns, and processes replicates."""

import os
import shutil
import subprocess
import sys

import gap_in_process as in_process
import numpy as np
import pytest
import talus
from support import BUILD, REPOSITORY, run
from talus.diagnosis.gate import excerpt
from talus.diagnosis.torque_terms import TorqueTerms

PENDULUM = REPOSITORY / "models" / "pendulum.yaml"
# a small process between: what this one holds would count as its child's
PEAK = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True); print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
WITH_PROCESSES = """import sys
from talus.diagnosis import command, processors
processors.COUNT = int(sys.argv[1])
sys.exit(command.main(sys.argv[2:]))"""


def peak_kb(*arguments):
    """Largest resident set of any of talus-gap's processes."""
    command = [sys.executable, "-c", PEAK, BUILD / "bin" / "talus-gap", "--quiet", *arguments]
    done = subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True)
    return int(done.stdout.split()[-1])


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("cost") / "arm.csv"
    run("talus-sim", "--model", PENDULUM, "--out", path, "--duration", 20, "--seed", 5)
    return path


def written(folder, recording, processes, threads):
    """Bytes of the report and of the model file."""
    options = ["--quiet", "--model", PENDULUM, "--report", folder / "gap.json", "--save-model", folder / "f.yaml", recording]
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY / "tools"), "TALUS_BUILD": str(BUILD), "OPENBLAS_NUM_THREADS": str(threads)}
    subprocess.run([sys.executable, "-c", WITH_PROCESSES, *map(str, (processes, *options))], check=True, env=environment)
    return [(folder / name).read_bytes() for name in ("gap.json", "f.yaml")]


@pytest.fixture(scope="module")
def by_one_process(recorded, tmp_path_factory):
    return written(tmp_path_factory.mktemp("one"), recorded, 1, 1)


@pytest.mark.parametrize(("processes", "threads"), [pytest.param(2, 3, marks=pytest.mark.long), (4, 1)])
def test_any_number_of_processes_and_threads_gives_the_same_bytes(recorded, by_one_process, processes, threads, tmp_path):
    """Processes, and threads that make columns; `threads` are those of NumPy's linear algebra, of which talus-gap asks for one."""
    assert written(tmp_path, recorded, processes, threads) == by_one_process


# ---- stretches of long recordings ------------------------------------------------------


@pytest.mark.parametrize(("rows", "share", "rows_each"), [(3_600_000, 1 / 30, 30_000), (150_001, 0.8, 7500), (1001, 0.5, 10_000), (9, 0.1, 4)])
def test_stretches_are_apart_within_the_file_and_evenly_spread(rows, share, rows_each):
    found = excerpt.stretches(rows, share, rows_each)
    assert 1 <= len(found) <= excerpt.MOST_STRETCHES and len({n for _, n in found}) == 1
    assert found[0][0] >= 0 and all(first + n <= rows for first, n in found)
    assert all(a + n <= b for (a, n), (b, _) in zip(found, found[1:]))
    assert sum(n for _, n in found) <= max(share * rows, excerpt.FEWEST_ROWS) < sum(n for _, n in found) + len(found) + 1
    middles = np.array([first + n / 2 for first, n in found]) / rows
    assert np.abs(middles - (np.arange(len(found)) + 0.5) / len(found)).max() < 1 / min(rows, 1000)


def test_a_stretch_holds_the_files_own_rows_and_their_times(recorded, monkeypatch):
    model, whole = talus.Model.read(PENDULUM), talus.Recording.read(recorded)
    names, (same,), findings = excerpt.read([recorded], model)
    assert same == whole and names == [str(recorded)] and not findings
    monkeypatch.setattr(excerpt, "MOST_SAMPLES", len(whole.t) // 2)
    monkeypatch.setattr(excerpt, "STRETCH_S", 4.0)
    names, parts, (finding,) = excerpt.read([recorded], model)
    assert len(parts) == len(names) > 1 and finding.id == "excerpt" and not finding.grave and "10 of 20 s" in finding.evidence
    for part in parts:
        first = np.searchsorted(whole.t, part.t[0])
        for column, values in whole.columns.items():
            assert np.array_equal(part.columns[column], values[first:first + len(part.t)])
        assert (part.origin.begin_s, part.origin.length_s) == (whole.t[0], whole.t[-1] - whole.t[0])


def test_time_counts_from_the_files_begin_and_over_whole_files(recorded, monkeypatch, tmp_path):
    """What warms up does so whether or not it is looked at."""
    whole = talus.Recording.read(recorded)
    monkeypatch.setattr(excerpt, "MOST_SAMPLES", len(whole.t))
    monkeypatch.setattr(excerpt, "STRETCH_S", 3.0)
    other = shutil.copy(recorded, tmp_path / "later.csv")
    dataset, identified = in_process.recorded(PENDULUM, tmp_path, recorded, other)
    length_s, stretches = whole.t[-1] - whole.t[0], len(dataset.processed_recordings)
    assert stretches > 2 and dataset.session_s == pytest.approx(2 * length_s)
    for record, processed in enumerate(dataset.processed_recordings):
        terms = TorqueTerms(dataset, record, list(identified.base.values()))
        assert np.allclose(terms.instants(0)["t_s"], processed.t_s - whole.t[0], rtol=0, atol=1e-9)
        later_s = length_s if record >= stretches / 2 else 0.0
        assert np.allclose(terms.instants(0, session=True)["t_s"], processed.t_s - whole.t[0] + later_s, rtol=0, atol=1e-9)


@pytest.mark.long
def test_memory_is_flat_in_length(tmp_path):
    found = []
    for length_s in (240, 960):
        run("talus-sim", "--model", PENDULUM, "--out", tmp_path / "arm.csv", "--rate", 1000, "--duration", length_s)
        found.append(peak_kb("--quick", "--model", PENDULUM, "--report", tmp_path / "gap.json", tmp_path / "arm.csv"))
    assert found[1] < 1.05 * found[0] < 1.05 * 200_000
