"""README.md and docs/: their commands run, their programs compile, what they show is what comes out, their links lead
somewhere, and the drawing of the house is the house.

What a fenced block is decides what happens to it, in the order of the page and in one folder a page:

    ```sh         is run by bash and must succeed; build/bin is on PATH, models/ is there
    ```console    "$ command" and what it prints: words must be the same, numbers may differ by 5 %; "..." stands
                  for any rest of a line, or for any lines
    ```python     is run by Python, with tools/ on its path
    ```c          is compiled by `cc $(pkg-config --cflags --libs talus)` and run, after the page's sh blocks that
                  write a header which it includes
    ```any other  is left alone

<!-- file: NAME --> before a block, whatever it is, writes the block to that file and nothing more.

In c and python, the next ```text block is what it prints.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support import BUILD, REPOSITORY, run

PAGES = ["README.md", *sorted(f"docs/{path.name}" for path in (REPOSITORY / "docs").glob("*.md"))]
# films that are drawn and followed, and many diagnoses
LONG = ("docs/camera.md", "docs/diagnosis.md", "docs/effects.md", "docs/python.md", "docs/talus-fleet.md", "docs/talus-track.md")
CHINESE = "README.zh.md"
BLOCK = re.compile(r"(?:<!-- file: (\S+) -->\n)?^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def blocks(page):
    """(file name or "", language, text) of each fenced block."""
    return [(name or "", kind, text) for name, kind, text in BLOCK.findall((REPOSITORY / page).read_text())]


def commands_on(page):
    return [text for _, kind, text in blocks(page) if kind in ("sh", "console", "python")]


# ---- what is shown ---------------------------------------------------------------------


def alike(shown, got):
    """Is a printed line the one that the page shows?"""
    if shown.endswith("..."):
        words = len(shown.removesuffix("...").split())
        shown, got = shown.removesuffix("..."), " ".join(got.split()[:words])
    shown, got = " ".join(shown.split()), " ".join(got.split())
    if NUMBER.sub("#", shown) != NUMBER.sub("#", got):
        return False
    pairs = zip(map(float, NUMBER.findall(shown)), map(float, NUMBER.findall(got)), strict=True)
    return all(abs(a - b) <= 0.05 * abs(a) for a, b in pairs)


def check_shown(shown, got):
    """Every line of the page's output, in order; a line of "..." skips any number of printed ones."""
    printed, skipping = iter(got.splitlines()), False
    for line in shown.splitlines():
        if line == "...":
            skipping = True
            continue
        found = any(alike(line, candidate) for candidate in printed) if skipping else alike(line, next(printed, ""))
        assert found, f"the page shows\n{line}\nand it prints\n{got}"
        skipping = False
    assert skipping or next(printed, None) is None, f"more is printed than the page shows:\n{got}"


def test_what_counts_as_shown():
    check_shown("a 1.00 b\n...\nlast", "a 1.04 b\nother\nother\nlast")
    check_shown("sim: the limit is 10.5 rad/s ...", "sim: the limit is 10.5 rad/s (more 3)")
    check_shown("one\n...", "one\ntwo")
    for shown, got in (("a 1.00", "a 1.06"), ("a", "b"), ("a", "a\nb"), ("a\nb", "a"), ("1", "-1"), ("1.0e-5", "1.0e-6")):
        with pytest.raises(AssertionError):
            check_shown(shown, got)


# ---- what is run -----------------------------------------------------------------------


@pytest.fixture(scope="session")
def installed(tmp_path_factory):
    """The environment of somebody who has run `make install`."""
    folder = tmp_path_factory.mktemp("installed")
    install = ["make", "-C", str(REPOSITORY), f"BUILD={BUILD}", "install", f"DESTDIR={folder}", "PREFIX=/usr"]
    subprocess.run(install, check=True, capture_output=True)
    library = folder / "usr/lib"
    return {"PKG_CONFIG_PATH": str(library / "pkgconfig"), "PKG_CONFIG_SYSROOT_DIR": str(folder),
            "LD_LIBRARY_PATH": str(library)}  # fmt: skip


@pytest.fixture(scope="session")
def arm(tmp_path_factory):
    """Recordings of an arm that was there before."""
    there = tmp_path_factory.mktemp("arm")
    for name, seed in (("arm.csv", 1), ("arm_again.csv", 2)):
        run("talus-sim", "--model", REPOSITORY / "models/pendulum.yaml", "--out", there / name, "--seed", seed)
    return there


@pytest.fixture
def folder(arm, tmp_path):
    """Where a page's blocks run: the repository's models, and recordings of its own, which it may change."""
    (tmp_path / "models").symlink_to(REPOSITORY / "models")
    for recording in arm.iterdir():
        shutil.copy(recording, tmp_path)
    return tmp_path


def environment(**more):
    paths = [str(BUILD / "bin"), str(Path(sys.executable).parent), os.environ["PATH"]]
    return {**os.environ, "PATH": ":".join(paths), "PYTHONPATH": str(REPOSITORY / "tools"), "TALUS_BUILD": str(BUILD), **more}


def execute(command, folder, status=0, **more):
    options = {"cwd": folder, "check": False, "text": True, "stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE,
               "stderr": subprocess.STDOUT, "timeout": 300}  # fmt: skip
    done = subprocess.run(command, env=environment(**more), **options)
    assert status is None or done.returncode == status, done.stdout
    return done.stdout


def session(text, folder):
    """A console block: each command, and what follows up to the next one."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command = part.splitlines()[0]
        while command.endswith("\\"):
            part = part.split("\n", 1)[1]
            command = command[:-1] + part.splitlines()[0]
        check_shown("".join(part.splitlines(keepends=True)[1:]), execute(["bash", "-c", command], folder, status=None))


# What the page's own `make` goal does is run by this test.
RUN_ELSEWHERE = {"across": "test_across.py", "bench": "test_benchmarks.py", "blind": "test_blind.py", "demo": "test_demo.py",
                 "paper": "test_paper.py", "rig": "rig/test_gpio.py", "spike": "test_spike.py"}  # fmt: skip


@pytest.mark.parametrize("page", PAGES)
def test_a_page_opens_with_an_example_that_is_run(page):
    opening = re.split(r"^## ", (REPOSITORY / page).read_text(), flags=re.MULTILINE)
    name, begin = Path(page).stem, "## ".join(opening[:2])
    if name in RUN_ELSEWHERE:
        assert f"make {name}" in begin and (REPOSITORY / "tests" / RUN_ELSEWHERE[name]).exists()
    elif page != "README.md":
        assert any(kind in ("sh", "console", "python", "c") for _, kind, _ in BLOCK.findall(begin)), page


def compile_and_run(text, folder, request):
    there = request.getfixturevalue("installed")
    (folder / "example.c").write_text(text)
    warnings = "-std=c99 -pedantic -Wall -Wextra -Werror"
    command = f"cc {warnings} -o example example.c $(pkg-config --cflags --libs talus)"
    clean = {"LD_PRELOAD": ""}  # the compiler is not ours to sanitize
    execute(["bash", "-euo", "pipefail", "-c", command], folder, **there, **clean)
    return execute([folder / "example"], folder, **there)


@pytest.mark.parametrize("page", [pytest.param(page, marks=pytest.mark.long) if page in LONG else page for page in PAGES if commands_on(page)])
def test_examples(page, folder):
    printed = None
    for name, kind, text in blocks(page):
        if name:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text)
        elif kind == "sh":
            execute(["bash", "-euo", "pipefail", "-c", text], folder)
        elif kind == "console":
            session(text, folder)
        elif kind == "python":
            printed = execute([sys.executable, "-c", text], folder)
        elif kind == "text" and printed is not None:
            check_shown(text, printed)
        printed = printed if kind == "python" else None


@pytest.mark.release
@pytest.mark.builds
@pytest.mark.parametrize("page", [page for page in PAGES if any(kind == "c" and not name for name, kind, _ in blocks(page))])
def test_programs_in_c(page, folder, request):
    all_blocks = blocks(page)
    included = {name for _, kind, text in all_blocks if kind == "c" for name in re.findall(r'^#include "(\w+\.h)"', text, re.MULTILINE)}
    for _, kind, text in all_blocks:  # commands that write a header which a program includes
        if kind == "sh" and any(f"--out {name}" in text for name in included):
            execute(["bash", "-euo", "pipefail", "-c", text], folder)
    for (name, kind, text), (_, following, shown) in zip(all_blocks, [*all_blocks[1:], ("", "", "")], strict=True):
        if kind == "c" and not name:
            printed = compile_and_run(text, folder, request)
            if following == "text":
                check_shown(shown, printed)


# ---- links, and what has a page ----------------------------------------------------------


def anchors(path):
    """The anchors that a page's headings get."""
    titles = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", path.read_text(), flags=re.DOTALL), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", [*PAGES, CHINESE, "tests/README.md", "CHANGELOG.md"])
def test_links_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", (REPOSITORY / page).read_text(), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith("http"):
            continue
        file, _, anchor = target.partition("#")
        path = (REPOSITORY / page).parent / file if file else REPOSITORY / page
        assert path.exists(), target
        assert not anchor or anchor in anchors(path), target


def test_every_command_and_every_page_is_in_the_readme():
    text = (REPOSITORY / "README.md").read_text()
    for program in (BUILD / "bin").glob("talus-*"):
        assert f"docs/{program.name}.md" in text and (REPOSITORY / f"docs/{program.name}.md").exists()
    for page in PAGES[1:]:
        assert f"]({page}" in text, f"{page} is not linked"


# ---- the other language ------------------------------------------------------------------


def without_comments(text):
    return [re.split(r"\s+# ", line)[0].rstrip() for line in text.splitlines()]


def commands(page):
    """All that is run or shown: fenced blocks, indented lines and the commands of tables, without comments, which are translated."""
    text = BLOCK.sub("", (REPOSITORY / page).read_text())
    indented = [line for line in without_comments(text) if line.startswith("    ")]
    spoken = sorted(set(re.findall(r"`((?:make|pip|talus)[-. ][^`]+)`", text)))
    return [(name, kind, without_comments(block)) for name, kind, block in blocks(page)], indented, spoken


def test_the_chinese_readme_has_the_commands_links_and_figures_of_the_english_one():
    """So that what runs here of the one is true of the other."""
    assert commands(CHINESE) == commands("README.md") and len(commands(CHINESE)[0]) > 6
    english, chinese = ((REPOSITORY / page).read_text() for page in ("README.md", CHINESE))
    links = [re.findall(r"\]\(([^)\s]+)\)", text) for text in (english, chinese)]
    assert set(links[0]) - {CHINESE} == set(links[1]) - {"README.md"}
    assert CHINESE in links[0] and "README.md" in links[1]
    tables = [[re.findall(r"\d[\d.,]*\d|\d", row) for row in re.findall(r"^\|.*$", text, re.MULTILINE)] for text in (english, chinese)]
    assert [sorted(row) for row in tables[0]] == [sorted(row) for row in tables[1]]


def test_commands_pages_name_every_option():
    for program in (BUILD / "bin").glob("talus-*"):
        text = (REPOSITORY / f"docs/{program.name}.md").read_text()
        for option in re.findall(r"^  (?:-\w, |    )--([\w-]+)", run(program.name, "--help").stdout, re.MULTILINE):
            assert option in ("help", "version") or f"--{option}" in text, f"{program.name} --{option}"


# ---- the drawing of the house -----------------------------------------------------------


def floors():
    """{module: floor} from the table of docs/architecture.md."""
    text = (REPOSITORY / "docs/architecture.md").read_text()
    rows = re.findall(r"^\| (\d) \| ([^|]*) \|", text, re.MULTILINE)
    return {name: int(number) for number, names in rows for name in re.findall(r"`(\w+)`", names)}


def module_of(path, names):
    """The module that a file of lib/ belongs to: the longest whose name it begins with."""
    if path.parent.name not in ("lib", "talus", "experimental"):  # a module's folder: effects/
        fitting = [name for name in names if name == path.parent.name.rstrip("s")]
    else:
        fitting = [name for name in names if path.stem == name or path.stem.startswith(f"{name}_")]
    assert fitting, f"{path.name} stands on no floor of docs/architecture.md"
    return max(fitting, key=len)


# What floors above include of a module's sources, for speed (docs/architecture.md).
INLINE_HALVES = r"(math|random|fixed)_inline\.h|transmission_internal\.h|fixed_scalar_\w+\.h|curve_template\.h"


def test_the_house_is_as_drawn():
    """Every file of the library stands on a floor, and includes only what is below or in its own module."""
    of = floors()
    headers = {path.stem: path for path in (REPOSITORY / "include/talus").rglob("*.h") if path.stem not in ("talus", "experimental")}
    assert set(headers) == set(of)
    sources = [*(REPOSITORY / "lib").rglob("*.[ch]"), *headers.values()]
    owner = {path.name: module_of(path, of) for path in sources if path.suffix == ".h"}
    for path in sources:
        mine = module_of(path, of)
        for name in re.findall(r'#include "([^"]+)"', path.read_text()):
            other = owner.get(Path(name).name, mine)  # one that the build makes belongs to who reads it
            assert mine == other or of[other] < of[mine], f"{path.name} ({mine}) includes {name} ({other})"
            private = not name.startswith("talus/") and not re.fullmatch(INLINE_HALVES, Path(name).name)
            assert mine == other or not private, f"{path.name} ({mine}) includes {name}, which is {other}'s own"


def test_every_program_is_in_the_drawing():
    text = (REPOSITORY / "docs/architecture.md").read_text()
    for folder in {path.parent for path in (REPOSITORY / "apps").glob("*/main.c")}:
        assert f"`{folder.name}/`" in text, folder.name


def test_no_page_names_a_machine():
    """Paths of one machine and names of hosts have no place in the pages."""
    for page in [*PAGES, "CHANGELOG.md", "tests/README.md"]:
        text = (REPOSITORY / page).read_text()
        assert not re.search(r"/(?:home|root|work|tmp)/", text), page
