"""The firmware example: the same hashes on this computer, on a Cortex-M4 with and without its floating-point unit, and on a
Cortex-M0; what a call costs there; flash and RAM; and that no double is in it."""

import re
import shutil
import subprocess

import pytest
from support import REPOSITORY, run

pytestmark = pytest.mark.release
BUILD_SCRIPT = REPOSITORY / "examples/firmware/build"
TICK_NS = {"m4f": 40.0, "m4": 40.0, "m0": 62.5}  # of SysTick: 25 MHz and 16 MHz
FOLDERS = {}


def built(kind, tmp_path_factory):
    """(what it printed, its folder); each kind once."""
    if kind not in FOLDERS:
        folder = tmp_path_factory.mktemp(kind)
        run("talus-export", "--to", "c", "--out", folder / "leg.h", REPOSITORY / "models/leg.yaml")
        done = subprocess.run([str(BUILD_SCRIPT), kind, str(folder)], capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        FOLDERS[kind] = dict(line.split() for line in done.stdout.splitlines()), folder
    return FOLDERS[kind]


def host(scalar, tmp_path_factory):
    done = subprocess.run([str(built("host", tmp_path_factory)[1] / f"leg_{scalar}")], capture_output=True, text=True, check=True)
    return dict(line.split() for line in done.stdout.splitlines())


def test_on_this_computer(tmp_path_factory):
    """Both scalars drive the same ticks; their currents in mA are not the same numbers."""
    q31, f32 = host("q31", tmp_path_factory), host("f32", tmp_path_factory)
    assert int(q31["driven"], 16) > 3000 and q31["driven"] == f32["driven"]


@pytest.mark.long
@pytest.mark.parametrize(("kind", "scalar", "most"), [("m4f", "f32", 930), ("m4", "q31", 1600), ("m0", "q31", 6500)])
def test_on_cortex_m(kind, scalar, most, tmp_path_factory):
    """The same bits; the dearest call is at most 1.05 times the cheapest."""
    printed, folder = built(kind, tmp_path_factory)
    assert printed["hash"] == host(scalar, tmp_path_factory)["hash"]
    cheapest, dearest = (int(printed[k], 16) * TICK_NS[kind] / 1024 for k in ("least", "most"))
    print(f"{kind}: {cheapest:.0f} to {dearest:.0f} instructions a call, {sizes(folder)} bytes of flash and RAM")
    assert dearest <= most and dearest <= 1.05 * cheapest
    flash, ram = sizes(folder)
    assert flash <= 16384 and ram <= 2048


@pytest.mark.parametrize("kind", ["host", pytest.param("m4f", marks=pytest.mark.long), pytest.param("m0", marks=pytest.mark.long)])
def test_the_way_of_docs_controller(kind, tmp_path):
    """From a recording to the line of C, as docs/controller.md goes: FITTED.yaml, header, images that run, the same currents on
    all of them; and they are not those of the model before."""
    truth, recording, fitted = REPOSITORY / "models/leg.yaml", tmp_path / "bench.csv", tmp_path / "FITTED.yaml"
    run("talus-sim", "--model", truth, "--out", recording, "--duration", 40)
    run("talus-identify", "--model", REPOSITORY / "models/leg_cad.yaml", "--out", fitted, recording)
    hashes = {}
    for name, model in (("fitted", fitted), ("cad", REPOSITORY / "models/leg_cad.yaml")):
        folder = tmp_path / name
        folder.mkdir()
        run("talus-export", "--to", "c", "--out", folder / "leg.h", model)
        for image in {"host", kind}:
            done = subprocess.run([str(BUILD_SCRIPT), image, str(folder)], capture_output=True, text=True, timeout=120, check=False)
            assert done.returncode == 0, done.stdout + done.stderr
            if image != "host":
                hashes[image, name] = dict(line.split() for line in done.stdout.splitlines())["hash"]
        scalar = "f32" if kind == "m4f" else "q31"
        printed = subprocess.run([str(folder / f"leg_{scalar}")], capture_output=True, text=True, check=True).stdout
        hashes["host", name] = dict(line.split() for line in printed.splitlines())["hash"]
    for name in ("fitted", "cad"):
        assert hashes[kind, name] == hashes["host", name]
    assert hashes["host", "fitted"] != hashes["host", "cad"]


def sizes(folder):
    """Flash, and RAM with the stack of main, leg_tick and the deepest chain below it."""
    listing = subprocess.run(["arm-none-eabi-size", str(folder / "leg.elf")], capture_output=True, text=True, check=True).stdout
    text, data, bss = map(int, listing.splitlines()[1].split()[:3])
    stack = sum(int(line.split("\t")[1]) for path in folder.glob("*.su") for line in path.read_text().splitlines())
    return text + data, data + bss + stack


@pytest.mark.long
@pytest.mark.parametrize("kind", ["m4f", "m4", "m0"])
def test_no_double_in_firmware(kind, tmp_path_factory):
    """Neither routines for doubles, nor in fixed point for floats, nor instructions for doubles."""
    elf = str(built(kind, tmp_path_factory)[1] / "leg.elf")
    symbols = subprocess.run(["arm-none-eabi-nm", elf], capture_output=True, text=True, check=True).stdout
    assert not re.search(r"__aeabi_\w*d(add|sub|mul|div|cmp\w*|2\w+)\b|__aeabi_\w+2d\b", symbols)
    if kind != "m4f":
        assert not re.search(r"__aeabi_(f\w+|\w+2f)\b", symbols)
    code = subprocess.run(["arm-none-eabi-objdump", "-d", elf], capture_output=True, text=True, check=True).stdout
    assert not re.search(r"\.f64", code)


def test_no_double_in_the_sources_objects(tmp_path):
    """Compiled on this computer: no conversion to double, no arithmetic of doubles."""
    compiler = shutil.which("cc")
    for scalar in ("f32", "q31"):
        for name in (f"controller_{scalar}", f"curve_{scalar}", "fixed"):
            command = [compiler, "-std=c99", "-O2", "-I", str(REPOSITORY / "include"), "-S", "-o", str(tmp_path / "a.s"),
                       "-fno-math-errno", "-Wdouble-promotion", "-Werror", str(REPOSITORY / f"lib/{name}.c")]  # fmt: skip
            subprocess.run(command, check=True)
            code = (tmp_path / "a.s").read_text()
            assert not re.search(r"\b\w*(addsd|mulsd|subsd|divsd|cvtss2sd|cvtsi2sd|comisd)\b|__aeabi_d", code), name
