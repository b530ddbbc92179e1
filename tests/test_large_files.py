"""The programs' objects are built with 64-bit file offsets, also where the platform's default is 32 bits."""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_every_object_of_a_program_is_compiled_with_64_bit_offsets():
    """Those in C++ too, also where OpenCV is missing and make leaves them out."""
    told = subprocess.run(["make", "-n", "-B", "-C", str(ROOT), "OPENCV_MISSING="], capture_output=True, text=True, timeout=60).stdout
    lines = [line for line in told.replace("\\\n", " ").splitlines() if re.search(r" -c .*\bapps/\S+\.(c|cpp)$", line)]
    named = {line.rsplit(" ", 1)[1] for line in lines}
    assert {str(path.relative_to(ROOT)) for path in (ROOT / "apps").rglob("*") if path.suffix in (".c", ".cpp")} - named == set()
    assert [line for line in lines if "-D_FILE_OFFSET_BITS=64" not in line] == []
