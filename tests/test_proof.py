"""Frama-C's Eva proves of the fixed-point routines and of a whole tick that nothing overflows, that no shift is undefined and that no
table is read outside, for all arguments: tests/proof/fixed_point.c says which. Eva is an abstract interpreter: no alarm is a
proof."""

import re
import subprocess

import pytest
from support import REPOSITORY

pytestmark = [pytest.mark.long, pytest.mark.release]
SOURCES = ["tests/proof/fixed_point.c", "lib/fixed.c", "lib/curve_q31.c", "lib/controller_q31.c"]
FLAGS = ["-machdep", "gcc_x86_64", "-eva", "-eva-precision", "4", "-eva-subdivide-non-linear", "20"]


def eva(*sources, extra=""):
    """(number of alarms, statements reached, all it said)."""
    command = ["frama-c", *FLAGS, f"-cpp-extra-args=-Iinclude -Ilib {extra}", *sources]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, timeout=280, check=False)
    assert done.returncode == 0, done.stdout[-3000:]
    alarms = re.search(r"(\d+) alarms? generated", done.stdout)
    reached = re.search(r"(\d+) statements reached \(out of (\d+)\)", done.stdout)
    return int(alarms[1]) if alarms else None, reached.groups(), done.stdout


def test_fixed_point_never_overflows():
    alarms, reached, said = eva(*SOURCES)
    assert alarms == 0, "\n".join(re.findall(r"\[eva:alarm\].*\n.*\n.*", said))
    assert reached[0] == reached[1]  # nothing was left out


def test_the_proof_can_fail(tmp_path):
    """A sum of two whole numbers of any size in 32 bits is found."""
    path = tmp_path / "wraps.c"
    path.write_text('#include "__fc_builtin.h"\n#include "talus/fixed.h"\nint main(void) { return '
                    "Frama_C_interval(INT32_MIN, INT32_MAX) + Frama_C_interval(0, 1); }\n")  # fmt: skip
    assert eva(str(path), "lib/fixed.c")[0] == 1
