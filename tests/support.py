"""Where the tests find things, and how they run a program.

    from support import data, needs_data, run

    @needs_data
    def test_x(tmp_path):
        run("talus-identify", "--model", data("emps/model.yaml"), "--out", tmp_path / "f.yaml",
            data("emps/identification.csv"))
"""

import os
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("TALUS_BUILD") or REPOSITORY / "build")
SHARE = float(os.environ.get("TALUS_SHARE", "1"))  # of what long tests do over and over
DATA = Path(os.environ.get("TALUS_DATA") or REPOSITORY.parent / "shared" / "data")

needs_data = pytest.mark.skipif(
    "TALUS_DATA" not in os.environ and not DATA.is_dir(),
    reason=f"no recordings at {DATA} (TALUS_DATA names another folder)",
)


def data(path):
    """The recording `path` of the data folder; its absence is a failure, not a skip."""
    found = DATA / path
    assert found.exists(), f"{found} is not there"
    return found


def many(whole):
    """So many times, or TALUS_SHARE of it: of what a long test does over and over."""
    return max(round(SHARE * whole), 1)


def program(name):
    """The path of a program, "talus-identify"."""
    found = BUILD / "bin" / name
    assert found.exists(), f"{found} is not built"
    return found


def run(name, *arguments, status=0, **options):
    """Runs a program, demands its exit status, and returns what subprocess.run does (with text)."""
    command = [str(program(name)), *map(str, arguments)]
    options = {"capture_output": True, "text": True, "stdin": subprocess.DEVNULL, "timeout": 300, **options}
    done = subprocess.run(command, check=False, **options)
    assert done.returncode == status, (
        f"{' '.join(command)}\nstatus {done.returncode}, expected {status}\n{done.stdout}{done.stderr}"
    )
    return done


def make_variable(name, *given):
    """A variable of the Makefile, as a list of words, where others are `given` on the command line."""
    make = ["make", "-s", "--no-print-directory", "-C", str(REPOSITORY), f"print-{name}", *given]
    environment = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}  # make is not ours to sanitize
    return subprocess.run(make, check=True, capture_output=True, text=True, env=environment).stdout.split()
