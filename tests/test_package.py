"""pyproject.toml: what `pip install .` puts on a machine works away from the checkout."""

import os
import subprocess
import sys

import pytest
from support import REPOSITORY, make_variable, run

pytestmark = [pytest.mark.release, pytest.mark.builds]
SCRIPT = """
import sys, talus
model, recording = talus.Model.read(sys.argv[1]), talus.Recording.read(sys.argv[2])
talus.Page("a page", "of an installed package").write(sys.argv[3])
print(talus.__file__, talus.BUILD, talus.constants.TL_VERSION)
print(talus.score(model, recording, talus.predict(model, recording))["joint"]["samples"])
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The package in a folder of its own, without the network: what it needs is in the environment already."""
    folder = tmp_path_factory.mktemp("package")
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("TALUS_", "PYTHONPATH", "LD_PRELOAD"))}
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-build-isolation", "--no-deps", "--target", folder / "there"]
    subprocess.run([*pip, REPOSITORY], check=True, env=environment, cwd=folder)
    return folder, {**environment, "PYTHONPATH": str(folder / "there")}


def test_an_installed_package_reads_scores_and_draws(installed):
    folder, environment = installed
    model = REPOSITORY / "models/pendulum.yaml"
    run("talus-sim", "--model", model, "--out", folder / "arm.csv", "--duration", 12)
    python = [sys.executable, "-c", SCRIPT, model, folder / "arm.csv", folder / "page.html"]
    done = subprocess.run(python, check=True, cwd=folder, env=environment, capture_output=True, text=True)
    where, samples = done.stdout.splitlines()
    assert where.split() == [f"{folder}/there/talus/__init__.py", f"{folder}/there/talus/_native", make_variable("VERSION")[0]]
    assert int(samples) > 1000 and "an installed package" in (folder / "page.html").read_text()


def test_an_installed_command_runs(installed):
    folder, environment = installed
    command = [folder / "there/bin/talus-gap", "--version"]
    done = subprocess.run(command, check=True, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.stdout.split() == ["talus-gap", make_variable("VERSION")[0]]
