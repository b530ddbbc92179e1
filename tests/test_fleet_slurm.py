"""talus-fleet on Slurm, by the lines of docs/talus-fleet.md: dask-jobqueue hands jobs to an sbatch that runs them on this machine."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from support import BUILD, REPOSITORY, program, run

pytestmark = pytest.mark.release
# As Slurm: the script is copied, runs apart from who submits it, with his environment, and is known by a number.
SBATCH = """#!/bin/sh
cp "$1" "$SLURM_JOBS/$$.sh"
setsid bash "$SLURM_JOBS/$$.sh" >"$SLURM_JOBS/$$.log" 2>&1 &
echo $! >"$SLURM_JOBS/$$.pid"
echo "Submitted batch job $$"
"""
SCANCEL = """#!/bin/sh
for job; do kill -- "-$(cat "$SLURM_JOBS/$job.pid")"; touch "$SLURM_JOBS/$job.cancelled"; done
"""
SMALLER = {"cores=16, processes=16, memory=\"32GB\"": "cores=1, processes=1, memory=\"1GB\", interface=\"lo\"", "jobs=10": "jobs=2"}


@pytest.fixture
def slurm(tmp_path):
    """The environment of one who may submit jobs."""
    (tmp_path / "bin").mkdir()
    (tmp_path / "jobs").mkdir()
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
        (tmp_path / "bin" / name).write_text(text)
        (tmp_path / "bin" / name).chmod(0o755)
    paths = f"{tmp_path / 'bin'}:{program('talus-fleet').parent}:{os.environ['PATH']}"
    tools = ":".join([str(REPOSITORY / "tools"), *filter(None, [os.environ.get("PYTHONPATH")])])
    yield {**os.environ, "PATH": paths, "PYTHONPATH": tools, "TALUS_BUILD": str(BUILD), "SLURM_JOBS": str(tmp_path / "jobs")}
    for job in (tmp_path / "jobs").glob("*.pid"):
        subprocess.run(["kill", "--", f"-{job.read_text().strip()}"], check=False, stderr=subprocess.DEVNULL)  # where a test failed


def lines_of_the_page():
    """The documented lines, for two small jobs."""
    (text,) = [block for block in re.findall(r"```text\n(.*?)```", (REPOSITORY / "docs/talus-fleet.md").read_text(), re.DOTALL) if "SLURMCluster" in block]
    for large, small in SMALLER.items():
        assert text.count(large) == 1
        text = text.replace(large, small)
    return text


def made(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted((folder / "items").rglob("*")) if path.is_file()}


@pytest.mark.long
def test_slurms_jobs_make_the_bytes_that_local_processes_make(slurm, tmp_path):
    shutil.copy(REPOSITORY / "models/pendulum.yaml", tmp_path)
    table = "recording,model,robot,session\n"
    for k in range(4):
        run("talus-sim", "--model", tmp_path / "pendulum.yaml", "--out", tmp_path / f"{k}.csv", "--duration", 10, "--seed", k)
        table += f"{k}.csv,pendulum.yaml,arm {k},2026-03-01\n"
    (tmp_path / "fleet.csv").write_text(table)
    done = subprocess.run([sys.executable, "-c", lines_of_the_page()], cwd=tmp_path, env=slurm, check=False, capture_output=True, text=True, timeout=300)
    logs = "".join(path.read_text() for path in (tmp_path / "jobs").glob("*.log"))
    assert done.returncode == 0 and "talus-fleet: 4 of 4 diagnosed" in done.stderr, done.stderr + logs
    scripts = [path.read_text() for path in (tmp_path / "jobs").glob("*.sh")]
    assert len(scripts) == 2 and all("#SBATCH -t 08:00:00" in text for text in scripts)
    assert len(list((tmp_path / "jobs").glob("*.cancelled"))) == 2  # what was asked for is given back
    assert "Registered to" in logs
    run("talus-fleet", "run", tmp_path / "fleet.csv", "--out", tmp_path / "local", "--jobs", 2)
    assert len(made(tmp_path / "local")) >= 3 * 4 and made(tmp_path / "fleet") == made(tmp_path / "local")
