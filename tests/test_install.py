"""`make install`: a stranger's program builds against it, by pkg-config, both ways."""

import json
import os
import re
import subprocess
import sys

import pytest
from support import BUILD, REPOSITORY, make_variable, run

pytestmark = [pytest.mark.release, pytest.mark.builds]

PROGRAM = """
#include <stdio.h>
#include <talus/talus.h>

int main(void) {
  printf("%s %s %s\\n", tl_version(), TL_VERSION, tl_status_text(TL_ERR_RANGE));
  return 0;
}
"""


def make(*arguments):
    # variables given to the make that runs the tests (CC, CFLAGS) reach this one through MAKEFLAGS
    subprocess.run(["make", "-C", str(REPOSITORY), *arguments], check=True, capture_output=True)


def files(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if not p.is_dir())


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("root")
    make("install", f"DESTDIR={folder}", "PREFIX=/opt/talus")
    return folder


def test_a_folder_by_its_absolute_path_is_the_same_build():
    """`make install BUILD=...` once made every object anew."""
    given = "build/elsewhere", f"{REPOSITORY}/build/elsewhere"
    one, other = (make_variable("FLAGS_ID", f"BUILD={folder}") for folder in given)
    assert one == other != make_variable("FLAGS_ID", "BUILD=/elsewhere")


def test_what_is_asked_for_by_its_absolute_path_is_built(tmp_path):
    for folder in (REPOSITORY / "build/elsewhere", tmp_path):
        asked = ["make", "-n", "-C", str(REPOSITORY), f"BUILD={folder}", f"{folder}/bin/talus-sim"]
        assert "apps/sim/main.c" in subprocess.run(asked, check=True, capture_output=True, text=True).stdout


def build_and_run(folder, tmp_path, *extra):
    source = tmp_path / "stranger.c"
    source.write_text(PROGRAM)
    library = folder / "opt/talus/lib"
    environment = {
        **os.environ,
        "PKG_CONFIG_PATH": str(library / "pkgconfig"),
        "PKG_CONFIG_SYSROOT_DIR": str(folder),
        "LD_LIBRARY_PATH": str(library),
    }
    query = ["pkg-config", "--cflags", "--libs", *extra, "talus"]
    flags = subprocess.run(query, check=True, capture_output=True, text=True, env=environment).stdout.split()
    binary = str(tmp_path / "stranger")
    warnings = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["cc", *warnings, "-o", binary, str(source), *flags], check=True)
    return subprocess.run([binary], check=True, capture_output=True, text=True, env=environment).stdout


def test_program_against_the_shared_library(installed, tmp_path):
    version = make_variable("VERSION")[0]
    assert build_and_run(installed, tmp_path) == f"{version} {version} value out of range\n"
    needed = subprocess.run(["objdump", "-p", tmp_path / "stranger"], check=True, capture_output=True, text=True)
    assert f"NEEDED               libtalus.so.{version.split('.')[0]}\n" in needed.stdout


def test_program_against_the_archive(installed, tmp_path):
    (installed / "opt/talus/lib/libtalus.so").rename(installed / "opt/talus/lib/hidden")
    try:
        version = make_variable("VERSION")[0]
        assert build_and_run(installed, tmp_path, "--static") == f"{version} {version} value out of range\n"
    finally:
        (installed / "opt/talus/lib/hidden").rename(installed / "opt/talus/lib/libtalus.so")


def test_the_commands_that_are_python_run_from_where_they_are_installed(tmp_path):
    """Away from the project's folder, with any Python that has what they need."""
    make("install", f"PREFIX={tmp_path / 'there'}")
    place = os.path.dirname(sys.executable)
    environment = {"PATH": f"{place}:{os.environ['PATH']}", "HOME": str(tmp_path)}

    def run(program, *arguments):
        command = [tmp_path / "there/bin" / program, *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True, env=environment, cwd=tmp_path)

    for program in ("talus-gap", "talus-import", "talus-acquire-export", "talus-fleet"):
        assert run(program, "--version").stdout == f"{program} {make_variable('VERSION')[0]}\n"
        assert str(REPOSITORY / "tools") not in (tmp_path / "there/bin" / program).read_text()
    model = REPOSITORY / "models/leg.yaml"
    run("talus-sim", "--model", model, "--out", "leg.csv", "--duration", "20")
    run("talus-gap", "--model", model, "--report", "gap.json", "--html", "gap.html", "leg.csv")
    assert json.loads((tmp_path / "gap.json").read_text())["schema"] == "talus-gap/1"


def words_of(text):
    """The words of a page or a help, without roff's."""
    plain = re.sub(r"^\.(TH.*|SH.*|TP|nf|fi|B )", "", text, flags=re.MULTILINE)
    return plain.replace(r"\-", "-").replace(r"\e", "\\").replace(r"\&", "").split()


@pytest.mark.parametrize("program", sorted(path.name for path in (BUILD / "bin").glob("talus-*")))
def test_a_manual_page_says_what_the_help_says(program, installed):
    page = (installed / f"opt/talus/share/man/man1/{program}.1").read_text()
    told = run(program, "--help").stdout
    assert page.startswith(f'.TH {program.upper()} 1 "" "talus {make_variable("VERSION")[0]}"')
    for section in ("NAME", "SYNOPSIS", "OPTIONS"):
        assert f"\n.SH {section}\n" in page
    options = re.findall(r"^  (?:-\w, |    )--([\w-]+)", told, re.MULTILINE)
    entries = [line for line in page.replace(r"\-", "-").splitlines() if line.startswith(".B ")]
    assert [re.search(r"--([\w-]+)", line)[1] for line in entries if "--" in line] == options
    # every word is there, in whatever order, with the program's name once more before its summary
    assert sorted([*words_of(told.removeprefix("usage: ")), program, "-"]) == sorted(words_of(page))


def test_models_bus_and_docs_are_installed(installed):
    share = installed / "opt/talus/share"
    for place, source in (("talus/models", "models"), ("doc/talus/docs", "docs"), ("doc/talus/docs/images", "docs/images")):
        there = {path.name for path in (REPOSITORY / source).iterdir() if path.is_file()}
        assert {path.name for path in (share / place).iterdir() if path.is_file()} == there, place
    assert {"README.md", "README.zh.md", "CHANGELOG.md", "LICENSE"} <= {path.name for path in (share / "doc/talus").iterdir()}


def test_uninstall_leaves_nothing(tmp_path):
    make("install", f"DESTDIR={tmp_path}", "PREFIX=/usr")
    assert "usr/include/talus/talus.h" in files(tmp_path)
    make("uninstall", f"DESTDIR={tmp_path}", "PREFIX=/usr")
    assert files(tmp_path) == []
