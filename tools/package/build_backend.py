"""Builds the Python package: setuptools' own backend, after make has built the library and its files lie in build/package.

The package is tools/talus with a folder _native beside its modules: the shared libraries, the declarations that cffi
reads, the programs, and the parts of a page.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools.build_meta import *  # noqa: F403  every hook that is not below
from setuptools.build_meta import build_wheel as _build_wheel
from setuptools.command.bdist_wheel import bdist_wheel

ROOT = Path(__file__).resolve().parents[2]
STAGE = ROOT / "build" / "package"
BUILT = {"lib": "lib/*.so", "python": "python/talus_*.h", "bin": "bin/talus-*"}
GENERATED_FOR_A_CHECKOUT = ("talus-gap", "talus-import", "talus-acquire-export", "talus-export-simulator", "talus-fleet")  # the package has scripts of its own for these
NOT_FOR_PYTHON = ("talus-track",)  # nothing in the package calls it, and OpenCV, which it is linked with, is larger than all the rest


class Wheel(bdist_wheel):
    """A wheel for one machine and any Python 3: the libraries are opened by cffi, not made for one interpreter."""

    def finalize_options(self):
        self.distribution.has_ext_modules = lambda: True  # what lies in the package is machine code
        super().finalize_options()

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


def stage():
    """tools/talus and what make built, in build/package."""
    make = ["make", "-C", str(ROOT), f"-j{os.cpu_count() or 1}", "BUILD=build"]
    subprocess.run([*make, "library", "python-side", "programs"], check=True, stdout=sys.stderr)
    for old in (STAGE, ROOT / "build" / "package-work"):  # setuptools would pack what is left of an earlier build
        shutil.rmtree(old, ignore_errors=True)
    package = STAGE / "talus"
    shutil.copytree(ROOT / "tools" / "talus", package, ignore=shutil.ignore_patterns("__pycache__"))
    for folder, pattern in BUILT.items():
        (package / "_native" / folder).mkdir(parents=True)
        for path in (ROOT / "build").glob(pattern):
            if path.name not in (*GENERATED_FOR_A_CHECKOUT, *NOT_FOR_PYTHON):
                shutil.copy2(path, package / "_native" / folder)
    shutil.copytree(ROOT / "apps" / "page" / "assets", package / "_native" / "assets")
    shutil.copy2(make_variable(make, "ASSET_CHART"), package / "_native" / "assets" / "chart.min.js")
    (STAGE / "VERSION").write_text(make_variable(make, "VERSION"))


def make_variable(make, name):
    command = [*make, "-s", "--no-print-directory", f"print-{name}"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    stage()
    return _build_wheel(wheel_directory, config_settings, metadata_directory)


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Metadata wants the version, which the stage holds."""
    from setuptools.build_meta import prepare_metadata_for_build_wheel as prepare

    stage()
    return prepare(metadata_directory, config_settings)
