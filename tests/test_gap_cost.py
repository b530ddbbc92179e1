"""What talus-gap takes: memory on a labelled case; and the same bytes however many processes work on the replicates."""

import os
import subprocess
import sys

import pytest
from support import BUILD, REPOSITORY, data, needs_data, run

LARGEST_KB = 150_000
PENDULUM = REPOSITORY / "models" / "pendulum.yaml"
# a small process between: what this one holds would count as its child's
PEAK = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True); print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
WITH_PROCESSES = """import sys
from talus.diagnosis import command
from talus.diagnosis.calibration import gains
gains.PROCESSES = int(sys.argv[1])
sys.exit(command.main(sys.argv[2:]))"""


def peak_kb(*arguments):
    """Largest resident set of any of talus-gap's processes."""
    command = [sys.executable, "-c", PEAK, BUILD / "bin" / "talus-gap", "--quiet", *arguments]
    done = subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True)
    return int(done.stdout.split()[-1])


@needs_data
def test_a_labelled_case_stays_small(tmp_path):
    case = data("leg_cases") / "case_019"
    recordings = [case / f"train{k}.csv.gz" for k in (1, 2, 3)]
    assert peak_kb("--model", case / "model.yaml", "--report", tmp_path / "gap.json", *recordings) < LARGEST_KB


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("cost") / "arm.csv"
    run("talus-sim", "--model", PENDULUM, "--out", path, "--duration", 20, "--seed", 5)
    return path


@pytest.mark.parametrize("processes", [2, 4])
def test_any_number_of_processes_gives_the_same_bytes(recorded, processes, tmp_path):
    found = []
    for number in (1, processes):
        options = ["--quiet", "--model", PENDULUM, "--report", tmp_path / "gap.json", "--save-model", tmp_path / "f.yaml", recorded]
        environment = {**os.environ, "PYTHONPATH": str(REPOSITORY / "tools"), "TALUS_BUILD": str(BUILD), "OPENBLAS_NUM_THREADS": "1"}
        subprocess.run([sys.executable, "-c", WITH_PROCESSES, *map(str, (number, *options))], check=True, env=environment)
        found.append([(tmp_path / name).read_bytes() for name in ("gap.json", "f.yaml")])
    assert found[0] == found[1]
