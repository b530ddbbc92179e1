"""The library stands alone: what it imports, and that it keeps no state."""

import re
import subprocess

import pytest
from support import BUILD

pytestmark = pytest.mark.release

ALLOWED = {"sqrt", "fabs", "floor", "memcpy", "memmove", "memset"}
# what a compiler and a loader put into every shared object
LOADER = {
    "_GLOBAL_OFFSET_TABLE_",
    "_ITM_deregisterTMCloneTable",
    "_ITM_registerTMCloneTable",
    "__cxa_finalize",
    "__gmon_start__",
}
# constant tables that hold addresses are written by the loader once, then protected
READ_ONLY = re.compile(r"\.(text|rodata|eh_frame|data\.rel\.ro)\b")


def listing(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def nm(*options):
    """(name, type) of each symbol, without the version that a C library appends."""
    rows = [line.split() for line in listing("nm", "-P", *options).splitlines()]
    return {(row[0].split("@")[0], row[1]) for row in rows if len(row) >= 2}


def test_shared_library_imports_only_what_is_allowed():
    imported = {name for name, _ in nm("-D", "--undefined-only", str(BUILD / "lib/libtalus.so"))}
    assert imported - LOADER <= ALLOWED


def test_archive_imports_only_what_is_allowed():
    archive = str(BUILD / "lib/libtalus.a")
    defined = {name for name, _ in nm("--defined-only", "--extern-only", archive)}
    imported = {name for name, _ in nm("--undefined-only", archive)}
    assert "tl_status_text" in defined
    assert imported - defined - LOADER <= ALLOWED


def test_exported_names_carry_the_prefix():
    exported = {name for name, _ in nm("-D", "--defined-only", str(BUILD / "lib/libtalus.so"))}
    assert "tl_version" in exported
    linker = {"_init", "_fini", "_edata", "_end", "__bss_start"}
    assert {name for name in exported if not name.startswith("tl_")} <= linker


def test_no_writable_globals():
    objects = 0
    writable = set()
    for line in listing("objdump", "-t", str(BUILD / "lib/libtalus.a")).splitlines():
        # value, flags (7 wide), section, size, name; O marks a data object
        row = re.match(r"[0-9a-f]+ (.{7}) (\S+)\s+[0-9a-f]+ (\S+)", line)
        if row and ("O" in row[1] or row[2] == "*COM*"):
            objects += 1
            if not READ_ONLY.match(row[2]):
                writable.add((row[3], row[2]))
    assert objects > 0
    assert not writable
