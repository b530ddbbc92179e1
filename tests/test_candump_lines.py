"""apps/candump: what a line of candump's log format holds, against a regular expression, on lines that are whole and on ones that are not."""

import random
import re

import numpy as np
import pytest
from talus.acquire_export import record
from talus.refused import Refused

HEX = "0123456789abcdefABCDEF"
LINE = re.compile(
    rb"\((\d{1,11})\.(\d{1,9})\) ([^ ]+) ([0-9a-fA-F]{3}|[0-9a-fA-F]{8})#(?:(R.?)|#(?:.((?:[0-9a-fA-F]{2}){0,64}))?|((?:[0-9a-fA-F]{2}){0,8}))(?: .)?\r?")
EXTENDED, ERROR = 1 << 31, 1 << 29


def drawn(generator):
    """A line as it should be, or nearly."""
    def some(characters, count):
        return "".join(generator.choices(characters, k=count))

    stamp = f"({some('0123456789', generator.choice((1, 10, 10, 10, 11, 12)))}.{some('0123456789', generator.choice((0, 1, 6, 6, 6, 9, 10)))})"
    name = generator.choice(("can0", "can1", "c", "vcan12", "x(y)", "a#b", "é", "a.b"))
    identifier = generator.choice((some(HEX, 3), "7" + some(HEX, 2), "2" + some(HEX, 7), "1" + some(HEX, 7), some(HEX, 8), some(HEX, 4)))
    payload = generator.choice((some(HEX, 16), some(HEX, 2 * generator.randrange(9)), some(HEX, generator.randrange(20)), "R", "R8", "R88",
                                f"#{some(HEX, 1)}{some(HEX, 2 * generator.choice((0, 8, 12, 64, 65)))}"))  # fmt: skip
    text = list(f"{stamp} {name} {identifier}#{payload}{generator.choice(('', '', ' R', ' T', chr(13), ' R' + chr(13)))}")
    if generator.random() < 0.3:
        text[generator.randrange(len(text))] = generator.choice("()#.Rx0f\t")
    return "".join(text).encode()


def expected(line):
    """(kind, time_ns, name, identifier, data), or None of a line that holds no frame."""
    found = LINE.fullmatch(line)
    if not found or int(found[1]) >= 2**63 // 10**9:
        return None
    short, identifier = len(found[4]) == 3, int(found[4], 16)
    if short and identifier >= 0x800:
        return None
    is_error = not short and identifier & ERROR
    kind = "remote" if found[5] is not None else "error" if is_error else "data"
    data = bytes.fromhex((found[6] or found[7] or b"").decode())
    return kind, int(found[1]) * 10**9 + int(found[2].ljust(9, b"0")), found[3].decode(), identifier | (0 if short or is_error else EXTENDED), data


def part(lines):
    read = record.Record("r.log")
    return record.part_of(read, b"".join(line + b"\n" for line in lines), {}), read


def test_lines_are_what_an_expression_says():
    generator = random.Random(1)
    lines = [drawn(generator) for _ in range(20_000)]
    held = [(line, one) for line in lines if (one := expected(line))]
    refused = [line for line in lines if not expected(line)]
    assert len(held) > 3000 < len(refused)
    for line in refused:
        with pytest.raises(Refused, match="no line of candump's log format"):
            part([line])
    got, read = part([line for line, _ in held])
    data = [(k, one) for k, (_, one) in enumerate(held) if one[0] == "data"]
    assert [read.remote, read.errors] == [sum(one[0] == kind for _, one in held) for kind in ("remote", "error")] and min(read.remote, read.errors) > 100
    assert got.line.tolist() == [k + 1 for k, _ in data]
    assert got.time_ns.tolist() == [one[1] for _, one in data]
    assert [read.sources[k] for k in got.source.tolist()] == [one[2] for _, one in data]
    assert got.identifier.tolist() == [one[3] for _, one in data]
    assert [bytes(row[:n]) for row, n in zip(got.data, got.length.tolist(), strict=True)] == [one[4] for _, one in data]
    assert all(not np.any(row[n:]) for row, n in zip(got.data, got.length.tolist(), strict=True))
