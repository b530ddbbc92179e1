"""House rules that a tool can check: short functions, small folders, whole headers, no warnings."""

import ast
import functools
import re
import subprocess
from collections import Counter
from pathlib import Path
from statistics import median

import lizard
import pytest
from support import REPOSITORY, make_variable

pytestmark = pytest.mark.release

LONGEST_FUNCTION = 60
MEDIAN_FUNCTION = 12
FILES_IN_A_FOLDER = 25
GENERATED = "apps/leg_bus/generated/"

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


@functools.cache
def c_functions(source):
    """{name: lines} of a file in C."""
    functions = lizard.analyze_file(str(REPOSITORY / source)).function_list
    return {f.name: f.end_line - f.start_line + 1 for f in functions}


@functools.cache
def python_functions(source):
    """{name: lines} of a file in Python, decorators left out; functions within functions count by themselves, too."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef)
    found = [n for n in ast.walk(ast.parse((REPOSITORY / source).read_text(encoding="utf-8"))) if isinstance(n, kinds)]
    return {f"{n.name}:{n.lineno}": n.end_lineno - n.lineno + 1 for n in found}


def is_python(path):
    """By its name, or by its first line where it has no ending."""
    return path.suffix == ".py" or (path.is_file() and not path.suffix and re.match(rb"#!.*python", path.read_bytes()[:80]) is not None)


C_FILES = LIBRARY + PROGRAMS + sources("lib/*.h", "lib/*/*.h", "apps/*/*.h", "apps/*/*/*.h")
PYTHON_FILES = [s for s in sources("tools/**/*", "tests/**/*") if is_python(REPOSITORY / s)]


@pytest.mark.parametrize("source", C_FILES)
def test_functions_are_short(source):
    assert {name: length for name, length in c_functions(source).items() if length > LONGEST_FUNCTION} == {}


@pytest.mark.parametrize("source", PYTHON_FILES)
def test_functions_in_python_are_short(source):
    assert {name: length for name, length in python_functions(source).items() if length > LONGEST_FUNCTION} == {}


def test_most_functions_are_shorter_still():
    c = [length for s in C_FILES if not s.startswith(GENERATED) for length in c_functions(s).values()]
    python = [length for s in PYTHON_FILES for length in python_functions(s).values()]
    assert len(c) > 1000 and median(c) <= MEDIAN_FUNCTION
    assert len(python) > 1000 and median(python) <= MEDIAN_FUNCTION


def test_what_counts_as_a_function(tmp_path):
    """Both countings on functions of known length, so that they cannot be blind."""
    (tmp_path / "f.py").write_text("import x\n\n\n@x.y\ndef f():\n    a = 1\n    return a\n\n\nclass C:\n    async def g(self):\n        pass\n")
    (tmp_path / "f.c").write_text("int f(int a) {\n  a++;\n  return a;\n}\n")
    assert python_functions(tmp_path / "f.py") == {"f:5": 3, "g:11": 2}
    assert c_functions(tmp_path / "f.c") == {"f": 4}


def test_folders_are_small():
    """Of what git knows, and of what is not ignored; lib/ stays flat."""
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "apps", "tools"],
                            cwd=REPOSITORY, check=True, capture_output=True, text=True).stdout.splitlines()  # fmt: skip
    files = Counter(str(Path(name).parent) for name in listed if (REPOSITORY / name).is_file())
    assert len(files) > 10
    assert {folder: n for folder, n in files.items() if n > FILES_IN_A_FOLDER} == {}


@pytest.mark.parametrize("header", HEADERS)
def test_header_stands_alone(header):
    compile_quietly("gcc", *WARNINGS, "-Iinclude", "-fsyntax-only", "-x", "c", header)
    flags = ["-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror"]
    compile_quietly("g++", *flags, "-Iinclude", "-fsyntax-only", "-x", "c++", header)


@pytest.mark.long
@pytest.mark.parametrize("source", LIBRARY)
def test_library_compiles_without_warnings(library_folders, source):
    compile_quietly("gcc", *WARNINGS, "-O2", "-ffp-contract=off", *library_folders, "-c", "-o", "/dev/null", source)


@pytest.mark.long
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
