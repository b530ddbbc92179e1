"""`make wheel`: pip installs the file in an empty Debian 12, and six lines of Python diagnose a recording there."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import pytest
from support import BUILD, REPOSITORY, make_variable, run

pytestmark = [
    pytest.mark.long,
    pytest.mark.release,
    pytest.mark.builds,
    pytest.mark.skipif(os.geteuid() != 0, reason="only root makes another system's folder and enters it"),
]
SIX_LINES = """\
import talus
model, recording = talus.read("arm.yaml"), talus.read("arm.csv")
diagnosis = talus.diagnose(model, recording)
print(diagnosis.verdict["effect"], diagnosis.verdict["joint"])
diagnosis.write("gap.json")
diagnosis.plot().savefig("gap.png")
"""
STRIBECK = "\neffects: [{effect: stribeck, joint: joint, parameters: {extra_Nm: 0.3, speed_rad_s: 0.2, exponent: 1}}]\n"
KERNELS = {name: value for name, value in os.environ.items() if name.startswith("OPENBLAS_")}  # another kernel, other last digits
CLEAN = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/", "LC_ALL": "C.UTF-8", **KERNELS}


@pytest.fixture(scope="module")
def wheel():
    done = subprocess.run(["make", "-C", str(REPOSITORY), f"PYTHON={sys.executable}", "wheel-file"], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    (made,) = (REPOSITORY / "build/wheel").glob("*.whl")
    return made


@pytest.fixture(scope="module")
def debian():
    """An empty Debian 12 with Python and nothing of ours, beside the build."""
    with tempfile.TemporaryDirectory(dir=BUILD, prefix="debian-12-") as folder:
        make = ["/usr/sbin/debootstrap", "--variant=minbase", "--include=python3-venv", "bookworm", folder]
        done = subprocess.run(make, check=False, capture_output=True, text=True, env={**os.environ, **CLEAN})
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr
        yield Path(folder)


def inside(debian, *command):
    """What a command says in that system, with a /proc that only the command sees: programs look there for their own place."""
    enter = ["unshare", "--mount", "sh", "-c", 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"', str(debian), *map(str, command)]
    done = subprocess.run(enter, check=False, capture_output=True, text=True, env=CLEAN)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_wheel_carries_its_libraries(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    for library in ("libyaml-0", "libjansson"):
        assert any(name.startswith(f"talus.libs/{library}") for name in names), library
    assert not any("opencv" in name for name in names)
    name, version, *tag = wheel.name.removesuffix(".whl").split("-")
    assert [name, version, tag[0], tag[1]] == ["talus", make_variable("VERSION")[0], "py3", "none"]
    glibc = tag[2].removeprefix("manylinux_2_").split("_")[0]
    assert int(glibc) <= 36, "newer than Debian 12"


def test_the_empty_system_is_empty(debian):
    assert "bookworm" in (debian / "etc/os-release").read_text()
    for pattern in ("usr/lib/*/libyaml*", "usr/lib/*/libjansson*", "usr/lib/*/libgpiod*", "usr/bin/*gcc*", "usr/lib/python3/dist-packages/numpy"):
        assert list(debian.glob(pattern)) == [], pattern


@pytest.fixture(scope="module")
def installed(wheel, debian):
    """The wheel and what it needs, fetched outside, installed inside without a network: the folder where one works there."""
    shelf = debian / "wheels"
    fetch = [sys.executable, "-m", "pip", "download", "--quiet", "--only-binary", ":all:", "--python-version", "3.11", "--dest", str(shelf),
             "--constraint", str(REPOSITORY / "tools/requirements.txt"), f"{wheel}[plot]"]  # fmt: skip
    subprocess.run(fetch, check=True, capture_output=True)
    inside(debian, "python3", "-m", "venv", "/there")
    inside(debian, "/there/bin/pip", "install", "--quiet", "--no-index", "--find-links", "/wheels", f"/wheels/{wheel.name}[plot]")
    work = debian / "bench"
    work.mkdir()
    shutil.copy(REPOSITORY / "models/pendulum.yaml", work / "arm.yaml")
    (work / "truth.yaml").write_text((work / "arm.yaml").read_text() + STRIBECK)
    run("talus-sim", "--model", work / "truth.yaml", "--out", work / "arm.csv", "--duration", 40, "--seed", 3)
    return work


def test_six_lines_diagnose_a_recording_and_plot(installed, debian):
    (installed / "six.py").write_text(SIX_LINES)
    assert inside(debian, "sh", "-c", "cd /bench && /there/bin/python six.py") == "stribeck joint\n"
    assert (installed / "gap.png").read_bytes().startswith(b"\x89PNG")
    run("talus-gap", "--model", installed / "arm.yaml", "--report", installed / "here.json", installed / "arm.csv")
    there, here = (json.loads((installed / name).read_text()) for name in ("gap.json", "here.json"))
    assert there["verdict"] == here["verdict"] and there["gap"]["joint"]["unit"] == "Nm"


def test_the_commands_run_in_the_empty_system(installed, debian):
    for program in ("talus-gap", "talus-import", "talus-export"):
        assert make_variable("VERSION")[0] in inside(debian, f"/there/bin/{program}", "--version")
    for path in (debian / "there/lib/python3.11/site-packages/talus/_native/bin").iterdir():
        assert "usage" in inside(debian, f"/{path.relative_to(debian)}", "--help"), path
    python = "import talus; talus.Recording({'time_s': [0, 1], 'joint_rad': [0, 1]}).to_pandas()"
    assert inside(debian, "/there/bin/python", "-c", f"try:\n {python}\nexcept ImportError as e: print(e)") == (
        "pandas is not there; pip install pandas, or 'talus[frame]'\n")  # fmt: skip
