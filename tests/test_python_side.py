"""tools/talus: arrays, constants and errors of the scripting interface."""

import os
import subprocess
import sys

import numpy
import pytest
from support import BUILD, REPOSITORY, make_variable
from talus import TalusError, _library, check, constants, ffi, lib, pointer


def test_pointer_is_the_memory_of_the_array():
    array = numpy.arange(6.0).reshape(2, 3)
    p = pointer(array)
    p[4] = -1.0
    assert array[1, 1] == -1.0
    assert [p[i] for i in range(6)] == [0.0, 1.0, 2.0, 3.0, -1.0, 5.0]


@pytest.mark.parametrize("name", ["float32", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"])
def test_pointer_has_the_type_of_the_elements(name):
    array = numpy.array([1, 2, 3], dtype=name)
    p = pointer(array)
    assert ffi.sizeof(ffi.typeof(p).item) == array.itemsize
    assert [p[i] for i in range(3)] == [1, 2, 3]


def test_pointer_of_none_is_null():
    assert pointer(None) == ffi.NULL


@pytest.mark.parametrize(
    "wrong",
    [
        [1.0, 2.0],
        numpy.zeros((4, 4))[:, 1],
        numpy.zeros((2, 3), order="F"),
        numpy.zeros(3, dtype=complex),
        numpy.zeros(3, dtype=">f8"),
    ],
    ids=["list", "strided", "column-major", "complex", "big-endian"],
)
def test_pointer_refuses_what_c_would_misread(wrong):
    with pytest.raises(TypeError):
        pointer(wrong)


def test_pointer_reads_memory_that_is_read_only():
    array = numpy.array([1.0, 2.0, 3.0])
    array.flags.writeable = False
    assert pointer(array)[2] == 3.0


def test_check_raises_with_the_text_of_the_status():
    check(lib.TL_OK)
    with pytest.raises(TalusError, match="too few samples") as error:
        check(lib.TL_ERR_TOO_SHORT)
    assert error.value.status == lib.TL_ERR_TOO_SHORT


@pytest.mark.release
def test_constants_are_those_of_a_c_program(tmp_path):
    """Each constant, printed by a compiled program that includes the headers."""
    numbers = {k: v for k, v in vars(constants).items() if isinstance(v, (int, float))}
    assert len(numbers) > 10
    includes = "".join(f'#include "{h.relative_to(REPOSITORY / "include")}"\n' for h in (REPOSITORY / "include/talus").rglob("*.h"))
    lines = "".join(f'printf("{name} %.17g\\n", (double)({name}));\n' for name in numbers)
    source = tmp_path / "constants.c"
    source.write_text(f"#include <stdio.h>\n{includes}int main(void) {{\n{lines}return 0;\n}}\n")
    compiler = make_variable("CC")
    flags = ["-std=c99", "-DTL_NO_ATTRIBUTES", f"-I{REPOSITORY / 'include'}", "-o", str(tmp_path / "constants")]
    subprocess.run([*compiler, *flags, str(source)], check=True)
    printed = subprocess.run([str(tmp_path / "constants")], check=True, capture_output=True, text=True).stdout
    assert {k: float(v) for k, v in (line.split() for line in printed.splitlines())} == numbers


@pytest.mark.parametrize("writable", [True, False])
def test_declarations_are_kept_where_that_can_be(tmp_path, monkeypatch, capfd, writable):
    """The same types whether they were just read, kept, or cannot be kept; nothing is said."""
    header = tmp_path / "talus_cdef.h"
    header.write_bytes((BUILD / "python" / "talus_cdef.h").read_bytes())
    if not writable:
        monkeypatch.setattr(_library.tempfile, "TemporaryDirectory", refused)
    for _ in range(2):
        found = _library._declarations(header)
        assert found.sizeof("tl_model") == ffi.sizeof("tl_model") and found.sizeof("tl_regression") == ffi.sizeof("tl_regression")
        assert found.callback("double(*)(const double *, const void *)", lambda x, rest: x[0]) != found.NULL
        assert sorted(path.suffix for path in tmp_path.iterdir()) == [".h", ".py"][:1 + writable]
    assert capfd.readouterr() == ("", "")


def refused(*_, **__):
    raise PermissionError(13, "Permission denied")


def test_absent_library_says_what_to_do(tmp_path):
    environment = {**os.environ, "TALUS_BUILD": str(tmp_path), "PYTHONPATH": str(REPOSITORY / "tools")}
    python = [sys.executable, "-c", "import talus"]
    done = subprocess.run(python, env=environment, check=False, capture_output=True, text=True)
    assert done.returncode != 0
    assert "run `make`" in done.stderr
