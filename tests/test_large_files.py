"""The programs' C objects are built with 64-bit file offsets, also where the platform's default is 32 bits."""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_every_c_object_of_a_program_is_compiled_with_64_bit_offsets():
    told = subprocess.run(["make", "-n", "-B", "-C", str(ROOT)], capture_output=True, text=True, timeout=60).stdout
    lines = [line for line in told.replace("\\\n", " ").splitlines() if re.search(r" -c .*\bapps/\S+\.c\b", line)]
    assert len(lines) >= len(list((ROOT / "apps" / "acquire").rglob("*.c")))
    assert [line for line in lines if "-D_FILE_OFFSET_BITS=64" not in line] == []
