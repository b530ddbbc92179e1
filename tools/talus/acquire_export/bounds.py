"""How large a DBC's numbers may be: cantools makes lists as long as they say, so they are looked at before it."""

import re

from talus.refused import Refused

MOST_BYTES = 1785  # of a message: J1939's transport carries no more
MOST_SELECTED = 10_000  # values of multiplexers in all ranges of a file; cantools keeps an entry for each
NUMBER = r"(?<!\d)(\d+)(?!\d)"
NO_NUMBERS = re.compile(r'"(?:\\"|[^"])*?"|//.*?\n')  # strings and comments, as cantools' own reader finds them
BITS = re.compile(rf"{NUMBER}\s*\|\s*{NUMBER}\s*@")  # of a signal: the first one and how many
BYTES = re.compile(rf"\bBO_\s+\d+\s+\w+\s*:\s*{NUMBER}")
SELECTED = re.compile(r"\bSG_MUL_VAL_\b([^;]*)")
RANGE = re.compile(rf"{NUMBER}\s*-{NUMBER}")


def check(text):
    """Refused with status 2, the line named, where a number of the DBC is out of bounds."""
    text = NO_NUMBERS.sub(lambda found: "\n" * found.group().count("\n") or " ", text)
    for found in BITS.finditer(text):
        if max(map(int, found.groups())) > 8 * MOST_BYTES:
            refuse(text, found, f"a signal's bits {found.group()[:-1].strip()[:40]}", f"numbers up to {8 * MOST_BYTES}")
    for found in BYTES.finditer(text):
        if int(found.group(1)) > MOST_BYTES:
            refuse(text, found, f"a message of {found.group(1)[:40]} bytes", f"at most {MOST_BYTES}")
    selected = 0
    for found in SELECTED.finditer(text):
        selected += sum(max(int(last) - int(first) + 1, 0) for first, last in RANGE.findall(found.group(1)))
        if selected > MOST_SELECTED:
            refuse(text, found, f"{selected} values of multiplexers up to here", f"at most {MOST_SELECTED} in a file")


def refuse(text, found, what, expected):
    line = 1 + text.count("\n", 0, found.start())
    raise Refused(2, f"line {line}: {' '.join(what.split())}; expected {expected}")
