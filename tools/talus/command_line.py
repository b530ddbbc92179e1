"""What the programs of this package do alike at the command line: options, --help and --version, and one line for what is
refused."""

from __future__ import annotations

import getopt
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence

from ._library import constants
from .refused import Refused


def parsed(name: str, arguments: Sequence[str], long: Sequence[str], short: Mapping[str, str]) -> tuple[list[tuple[str, str]], list[str]]:
    """([(option, value)], inputs): options under their long names ("--out"), values "" where there is none. `long` is getopt's
    ("out=" takes a value), `short` maps "-o" to "--out"."""
    letters = "".join(letter[1:] + (":" if f"{option[2:]}=" in long else "") for letter, option in short.items())
    try:
        pairs, inputs = getopt.gnu_getopt(arguments, letters, long)
    except getopt.GetoptError as error:
        raise Refused(2, f"{error.msg}; {name} --help says what there is") from error
    return [(short.get(option, option), value) for option, value in pairs], inputs


def answered(flags: Iterable[str], name: str, usage: str) -> bool:
    """Was --help or --version asked for? Then it is printed, and nothing else is to be done."""
    if "--help" in flags:
        print(usage, end="")
        return True
    if "--version" in flags:
        print(f"{name} {constants.TL_VERSION}")
        return True
    return False


def status(name: str, run: Callable[[list[str]], int | None], arguments: list[str]) -> int:
    """Exit status of a program: `run` gives it, None for 0, or raises Refused; one line then says what was."""
    try:
        return run(arguments) or 0
    except Refused as refused:
        print(f"{name}: {' '.join(refused.text.split())}", file=sys.stderr)
        return refused.status
    except KeyboardInterrupt:
        return 130
