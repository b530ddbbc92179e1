"""House rules that a tool can check: short functions, whole headers, no warnings."""

import re
import subprocess
from pathlib import Path

import lizard
import pytest
from support import REPOSITORY, make_variable

pytestmark = pytest.mark.release

LONGEST_FUNCTION = 60

# The promise of the project, written out: the Makefile must not be able to soften it.
WARNINGS = (
    "-std=c99 -pedantic -Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -Wstrict-prototypes "
    "-Wmissing-prototypes -Wvla -Wundef -Werror"
).split()


def sources(*patterns):
    return sorted(str(p.relative_to(REPOSITORY)) for pattern in patterns for p in REPOSITORY.glob(pattern))


HEADERS = sources("include/talus/*.h", "include/talus/*/*.h")
LIBRARY = sources("lib/*.c", "lib/*/*.c")
PROGRAMS = sources("apps/*/*.c", "apps/*/*/*.c", "tests/programs/*.c")


@pytest.fixture(scope="session")
def application_flags():
    return [flag for flag in make_variable("APP_FLAGS") if not flag.startswith("-W")]


@pytest.fixture(scope="session")
def library_folders():
    return [flag for flag in make_variable("LIB_FLAGS") if flag.startswith("-I")]


def compile_quietly(*command):
    done = subprocess.run(command, cwd=REPOSITORY, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("source", LIBRARY + PROGRAMS + sources("lib/*.h", "lib/*/*.h", "apps/*/*.h", "apps/*/*/*.h"))
def test_functions_are_short(source):
    functions = lizard.analyze_file(str(REPOSITORY / source)).function_list
    lengths = {f.name: f.end_line - f.start_line + 1 for f in functions}
    assert {name: length for name, length in lengths.items() if length > LONGEST_FUNCTION} == {}


@pytest.mark.parametrize("header", HEADERS)
def test_header_stands_alone(header):
    compile_quietly("gcc", *WARNINGS, "-Iinclude", "-fsyntax-only", "-x", "c", header)
    flags = ["-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror"]
    compile_quietly("g++", *flags, "-Iinclude", "-fsyntax-only", "-x", "c++", header)


@pytest.mark.parametrize("source", LIBRARY)
def test_library_compiles_without_warnings(library_folders, source):
    compile_quietly("gcc", *WARNINGS, "-O2", "-ffp-contract=off", *library_folders, "-c", "-o", "/dev/null", source)


@pytest.mark.parametrize("source", PROGRAMS)
def test_program_compiles_without_warnings(source, application_flags):
    compile_quietly("gcc", *WARNINGS, "-O2", *application_flags, "-c", "-o", "/dev/null", source)


UMBRELLAS = ("include/talus/talus.h", "include/talus/experimental.h")


def test_umbrellas_include_every_header_and_the_stable_one_no_other():
    stable, other = ({n for n in re.findall(r'#include "(.+)"', (REPOSITORY / h).read_text())} for h in UMBRELLAS)
    assert {f"include/{n}" for n in stable | other} == set(HEADERS) - set(UMBRELLAS)
    for header in (h for h in HEADERS if f"{Path(h).parent}" == "include/talus" and h not in UMBRELLAS):
        assert header.removeprefix("include/") in stable
        assert '#include "talus/experimental' not in (REPOSITORY / header).read_text(), header
