"""docs/effects.md, "Adding one": its three files in a copy of the sources, built there and taken through every program. Of the
build only what they change is made anew."""

import filecmp
import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
import yaml
from support import BUILD, REPOSITORY
from test_docs import blocks

pytestmark = pytest.mark.release

PAGE = "docs/effects.md"
FILES = {name: text for name, _, text in blocks(PAGE) if "eddy_brake" in name}
SECTION = FILES.pop("eddy_brake.md")
PROGRAMS = ("talus-sim", "talus-identify", "talus-predict", "talus-gap")
LIBRARIES = ("lib/libtalus.so", "lib/libtalus_files.so")
NOT_SOURCES = shutil.ignore_patterns(".git", ".venv", ".*cache*", "__pycache__", ".rig", "build", BUILD.name)

TRUE = {"brake_Nms_rad": 0.2, "middle_rad": 0.15, "width_rad": 0.1}
PLAIN = {"inertia_kg_m2": 0.045, "gravity_moment_kg_m": 0.15}
ARM = {"plant": "pendulum", "gravity_m_s2": 9.81, **PLAIN, "gravity_zero_rad": 0.0,
       "joint": {"transmission": {"type": "fixed", "ratio": 9}, "torque_constant_Nm_A": 0.091,
                 "friction": {"coulomb_Nm": 0.25, "viscous_Nms_rad": 0.02}}}  # fmt: skip
WITH_IT = ARM | {"effects": [{"effect": "eddy_brake", "joint": "joint", "parameters": TRUE}]}


class Copy:
    """The sources with the toy effect in them, their build, and a folder to work in."""

    def __init__(self, root):
        self.root, self.folder = root / "talus", root
        self.build = self.root / "build"
        shutil.copytree(REPOSITORY, self.root, ignore=NOT_SOURCES, symlinks=True)
        shutil.copytree(BUILD, self.build, ignore=shutil.ignore_patterns("bin", "tests", "bench", "lint"), symlinks=True)
        for name, text in FILES.items():
            (self.root / name).write_text(text)
        with open(self.root / PAGE, "a", encoding="utf-8") as page:
            page.write(f"\n{SECTION}")
        targets = [*(f"bin/{name}" for name in PROGRAMS), *LIBRARIES]
        self.execute("make", "-s", "-j2", "BUILD=build", "python-side", *(f"build/{target}" for target in targets))
        for name, model in (("plain", ARM), ("with_it", WITH_IT)):
            (root / f"{name}.yaml").write_text(yaml.safe_dump(model))
        self.program("talus-sim", "--model", "with_it.yaml", "--out", "r.csv", "--duration", 30)
        self.program("talus-sim", "--model", "with_it.yaml", "--out", "other.csv", "--duration", 30, "--seed", 2)

    def execute(self, *command, cwd=None):
        environment = {**os.environ, "TALUS_BUILD": str(self.build), "PYTHONDONTWRITEBYTECODE": "1",
                       "PATH": f"{os.path.dirname(sys.executable)}:{os.environ['PATH']}"}  # fmt: skip
        done = subprocess.run(list(map(str, command)), cwd=cwd or self.root, env=environment, check=False, text=True,
                              capture_output=True, stdin=subprocess.DEVNULL, timeout=300)  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout + done.stderr

    def program(self, name, *arguments):
        return self.execute(self.build / "bin" / name, *arguments, cwd=self.folder)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    return Copy(tmp_path_factory.mktemp("toy"))


def compared(ours, theirs, at=""):
    """(only in the copy, changed, gone) as paths."""
    new, changed = [at + name for name in theirs.right_only], [at + name for name in theirs.diff_files]
    gone = [at + name for name in theirs.left_only]
    for name, below in theirs.subdirs.items():
        for every, more in zip((new, changed, gone), compared(ours, below, f"{at}{name}/"), strict=True):
            every += more
    return new, changed, gone


def test_two_files_and_a_section_are_all_that_differs(copy):
    hidden = [".git", ".venv", "build", BUILD.name, "__pycache__", ".pytest_cache", ".ruff_cache", ".mypy_cache", ".rig"]
    new, changed, gone = compared(copy, filecmp.dircmp(REPOSITORY, copy.root, ignore=hidden))
    assert (sorted(new), changed, gone) == (sorted(FILES), [PAGE], [])


def test_identification_with_it_finds_the_arm(copy):
    errors = {}
    for name in ("plain", "with_it"):
        copy.program("talus-identify", "--quiet", "--model", f"{name}.yaml", "--out", f"{name}.fitted.yaml", "--report",
                     f"{name}.json", "r.csv")  # fmt: skip
        errors[name] = json.loads((copy.folder / f"{name}.json").read_text())["error"]["joint"]["identified_rms"]
    fitted = yaml.safe_load((copy.folder / "with_it.fitted.yaml").read_text())
    assert {name: fitted[name] for name in PLAIN} == pytest.approx(PLAIN, rel=0.01)
    assert fitted["effects"] == WITH_IT["effects"]
    assert errors["with_it"] < 0.2 * errors["plain"]


def test_prediction_adds_its_law(copy):
    """With it less without it is the law's closed form, along another motion."""
    shown = {}
    for name in ("plain", "with_it"):
        copy.program("talus-predict", "--model", f"{name}.yaml", "--out", "p.csv", "other.csv")
        shown[name] = np.loadtxt(copy.folder / "p.csv", delimiter=",", skiprows=1)[:, 1]
    with open(copy.folder / "other.csv", encoding="utf-8") as file:
        rows = [line for line in file if not line.startswith("#")]
    t, q = np.loadtxt(rows[1:], delimiter=",", usecols=[rows[0].strip().split(",").index(c) for c in ("time_s", "joint_rad")]).T
    brake = TRUE["brake_Nms_rad"] * np.gradient(q, t) * np.exp(-(((q - TRUE["middle_rad"]) / TRUE["width_rad"]) ** 2))
    left = shown["with_it"] - shown["plain"] - brake
    assert np.sqrt(np.mean(left[250:-250] ** 2)) < 0.01 * np.sqrt(np.mean(brake[250:-250] ** 2))


def test_the_diagnosis_names_it_and_its_parameters(copy):
    said = copy.program("talus-gap", "--model", "plain.yaml", "--report", "gap.json", "--save-model", "saved.yaml", "r.csv")
    report = json.loads((copy.folder / "gap.json").read_text())
    assert (report["verdict"]["effect"], report["verdict"]["joint"]) == ("eddy_brake", "joint")
    assert report["verdict"]["probability"] > 0.9 and report["gap"]["joint"]["closed_fraction"] > 0.98
    assert said.startswith("The gap comes from a magnet that brakes over a part of the range (eddy brake) at the joint")
    first, *_ = yaml.safe_load((copy.folder / "saved.yaml").read_text())["effects"]
    assert first["effect"] == "eddy_brake" and first["parameters"] == pytest.approx(TRUE, rel=0.05)


def test_what_checks_entries_and_the_page_takes_it_too(copy):
    tests = ["tests/test_gap_effects.py", "tests/test_effect.py::test_the_page_lists_every_kind_with_its_parameters",
             "tests/test_effect.py::test_every_kind_bears_an_id_of_the_catalogue_and_sound_parameters"]  # fmt: skip
    copy.execute(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests)
