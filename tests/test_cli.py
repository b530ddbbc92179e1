"""apps/common/cli.c and progress.c, through a program that has an option of each kind."""

import os
import pty
import re

import pytest
from helper_programs import complaint, helper
from support import BUILD, REPOSITORY, run


def said(*arguments):
    return helper("cli_demo", *arguments).stdout.decode().strip().split("|")


def test_options_of_every_kind():
    assert said("-m", "a.yaml", "r1") == ["a.yaml", "none", "0.5", "0", "1", "r1"]
    everything = ["a.yaml", "n", "-2.5", "1", "18446744073709551615", "r1 r2"]
    assert said("--model=a.yaml", "--note", "n", "--width", "-2.5", "--quick", "--seed",
                "18446744073709551615",                "r1", "r2") == everything  # fmt: skip
    assert (
        said("r1", "-qw", "-2.5", "r2", "--seed=18446744073709551615", "--note=n", "-ma.yaml") == everything
    )
    assert said("-m", "a.yaml", "--", "--note")[5] == "--note"
    assert said("--mod", "a.yaml", "r1")[0] == "a.yaml"  # what is unambiguous may be cut short


def test_help_and_version():
    for option in ("--help", "-h"):
        done = helper("cli_demo", option)
        text = done.stdout.decode()
        assert done.stderr == b""
        assert text.startswith("usage: cli_demo --model M.yaml [OPTION...] REC.csv...\n\n"
                               "    cli_demo --model leg.yaml run.csv\n    cli_demo --model leg.yaml --quick run1.csv run2.csv\n\n"
                               "shows what it was told\n\n  -m, --model M.yaml ")  # fmt: skip
        for piece in ("-m, --model M.yaml", "--note TEXT", "-w, --width SECONDS", "-q, --quick", "--seed N",
                      "--help", "--version", "shows what it was told", "The end."):  # fmt: skip
            assert piece in text
        assert max(map(len, text.splitlines())) < 100
    header = (REPOSITORY / "include/talus/version.h").read_text()
    numbers = [header.split(f"TL_VERSION_{part} ")[1].split()[0] for part in ("MAJOR", "MINOR", "PATCH")]
    assert helper("cli_demo", "--version").stdout.decode() == f"cli_demo {'.'.join(numbers)}\n"


@pytest.mark.parametrize(("arguments", "words"), [
    ([], "--model M.yaml is missing"), (["r1"], "--model M.yaml is missing"),
    (["-m", "a"], "REC.csv... is missing"), (["-m", "a", *"1234"], "more arguments than expected"),
    (["-x"], "unknown option -x"), (["--nonsense"], "unknown or ambiguous option --nonsense"),
    (["--"], "--model M.yaml is missing"), (["--quick=1"], "--quick=1: this option takes no value"),
    (["--seed"], "--seed needs a value"), (["-m"], "-m needs a value"),
    (["-m", "a", "r", "--seed", "-1"], "--seed: expected a whole number, found '-1'"),
    (["-m", "a", "r", "--seed", "1.5"], "expected a whole number, found '1.5'"),
    (["-m", "a", "r", "--seed", "18446744073709551616"], "expected a whole number"),
    (["-m", "a", "r", "--seed", ""], "expected a whole number, found ''"),
    (["-m", "a", "r", "--width", "nan"], "--width: expected a number, found 'nan'"),
    (["-m", "a", "r", "--width", "1x"], "--width: expected a number, found '1x'"),
    (["-m", "a", "r", "--width", "1\n2"], "found '1?2'"),
])  # fmt: skip
def test_wrong_usage_ends_with_a_hint(arguments, words):
    message = complaint("cli_demo", *arguments)
    assert words in message and message.endswith("(cli_demo --help tells more)")


def test_progress_is_shown_to_a_terminal_only():
    arguments = [BUILD / "tests" / "cli_demo", "-m", "a", "r"]
    assert helper("cli_demo", *arguments[1:]).stderr == b""
    shown = b""
    pid, terminal = pty.fork()
    if pid == 0:
        os.execv(arguments[0], [str(a) for a in arguments])
    try:
        while chunk := os.read(terminal, 4096):
            shown += chunk
    except OSError:  # the terminal is closed
        pass
    assert os.waitpid(pid, 0)[1] == 0
    assert b"a|none|0.5|0|1|r" in shown
    if b"cli_demo: working file.csv" in shown:
        # what was drawn is wiped before the answer
        assert shown.rindex(b"working") < shown.rindex(b"\x1b[K") < shown.index(b"a|none")


CALLED = {"talus-export-simulator": "talus-export", "talus-acquire export": "talus-acquire-export"}  # what runs them, and what they run
COMMANDS = ["talus-acquire export", "talus-acquire info", *(f"talus-track {name}" for name in ("align", "calibrate", "lens", "tilt"))]


@pytest.mark.parametrize("command", sorted(path.name for path in (BUILD / "bin").glob("talus-*")) + COMMANDS)
def test_help_begins_with_an_example_that_has_what_is_needed(command):
    name = CALLED.get(command, command)
    usage, examples, *rest = run(*command.split(), "--help").stdout.split("\n\n")
    assert usage.startswith(f"usage: {name} ") and examples.startswith(f"    {name} ")
    options = set(re.findall(r"^  (?:-\w, |    )(--[\w-]+)", "\n".join(rest), re.MULTILINE))
    used = re.findall(r"(?<= )--[\w-]+", examples.splitlines()[0].split(" # ")[0])
    assert set(used) <= options and len(used) == len(set(used))
    assert "--suggest" in used or set(re.findall(r"--[\w-]+", usage.split("[OPTION")[0])) <= set(used)  # a draft needs no --out
