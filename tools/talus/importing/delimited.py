"""Text tables: encoding, separator, decimal sign, quoting, header, a row of units."""

import csv
import gzip
import re
from collections import Counter

from talus.refused import Refused

from . import headers
from .table import MISSING, Column, Table, is_number

SEPARATORS = ("\t", ";", "|", ",", " ")
WORDS = {"\t": "tabs", " ": "blanks"}
SAMPLED = 400  # lines that tell the separator
GROUPED = re.compile(r"^[+-]?\d{1,3}(?:\.\d{3})+,\d+$|^[+-]?\d+,\d+(?:[eE][+-]?\d+)?$")
POINTED = re.compile(r"^[+-]?\d*\.\d+(?:[eE][+-]?\d+)?$|^[+-]?\d{1,3}(?:,\d{3})+\.\d+$")
BUS_LOG = re.compile(r"^\([0-9.]+\) \S+ [0-9A-Fa-f]+#")  # a line of candump's
INSTANT = re.compile(r"\d\d?:\d\d:\d\d")


def decode(data, notes):
    """Text of bytes by byte order mark, by the zeros of UTF-16, as UTF-8, or as Windows' Western set with a word."""
    for mark, name in ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be")):
        if data.startswith(mark):
            return data[len(mark) :].decode(name, errors="replace")
    zeros = data[:2000].count(0)
    if zeros and zeros > len(data[:2000]) // 4:
        return data.decode("utf-16-le" if data[1:2] == b"\0" else "utf-16-be", errors="replace")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        notes.append("is no UTF-8; read as Windows-1252")
        return data.decode("cp1252", errors="replace")


def fields_of(line, separator):
    if separator == " ":
        return line.split()
    try:
        return [field.strip() for field in next(csv.reader([line], delimiter=separator), [])]
    except csv.Error:  # a byte that is no text, or a field without an end
        return [line]


def looks_numeric(field):
    plain = field.replace(",", ".", 1) if GROUPED.match(field) and field.count(",") == 1 else field
    return field.lower() in MISSING or is_number(plain) or bool(GROUPED.match(field) or POINTED.match(field) or INSTANT.search(field))


def separator_of(lines):
    """The separator under which most lines have as many fields, most of them numbers."""
    best, found = 0.0, None
    sampled = lines[-SAMPLED:]
    for separator in SEPARATORS:
        rows = [fields_of(line, separator) for line in sampled]
        (width, often), = Counter(map(len, rows)).most_common(1)
        if width < 2:
            continue
        cells = [field for row in rows if len(row) == width for field in row]
        points = often / len(rows) * sum(map(looks_numeric, cells)) / len(cells)
        if points > best + 1e-9:
            best, found = points, separator
    return found if best > 0.4 else None


def decimal_of(rows):
    """"," where numbers are written so and none with a point alone."""
    cells = [field for row in rows[:SAMPLED] for field in row]
    commas, points = sum(bool(GROUPED.match(c)) for c in cells), sum(bool(POINTED.match(c)) for c in cells)
    return "," if commas > points else "."


def lines_of(text):
    """(numbers, lines) of what is neither empty nor a comment."""
    numbered = [(n, line) for n, line in enumerate(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), 1)
                if line.strip() and not line.lstrip().startswith(("#", "%", "//"))]  # fmt: skip
    if numbered and re.fullmatch(r"sep=.", numbered[0][1].strip()):  # how a spreadsheet is told
        numbered = numbered[1:]
    return [n for n, _ in numbered], [line for _, line in numbered]


def is_units_row(row):
    said = [field.strip("[]() ") for field in row]
    return any(said) and all(not f or f == "-" or headers.written(f) for f in said)


def header_of(rows, path):
    """(row of the first data, names with units)."""
    width = Counter(map(len, rows[-SAMPLED:])).most_common(1)[0][0]
    whole = (i for i, row in enumerate(rows) if len(row) == width and all(map(looks_numeric, row)) and any(map(is_number_like, row)))
    first = next(whole, None)
    if first is None:  # a column of words: what has most numbers is data
        first = next((i for i, row in enumerate(rows) if len(row) == width and sum(map(is_number_like, row)) * 2 >= width), None)
    if first is None:
        raise Refused(2, f"{path}: no rows of numbers")
    if first == 0:
        return 0, [(f"column {i + 1}", None) for i in range(width)]
    names = rows[first - 1]
    if first > 1 and is_units_row(names) and len(rows[first - 2]) >= len(names) - 1:
        above = rows[first - 2] + [""] * len(names)
        return first, [(name, unit.strip("[]() ") or None) for name, unit in zip(above, names, strict=False)]
    return first, [headers.split(name) for name in names]


def is_number_like(field):
    return looks_numeric(field) and field.lower() not in MISSING


def check_widths(rows, numbers, width, path, notes):
    """Rows cut to the header's width where what is more is empty; a last row that is cut off is left out."""
    if rows and len(rows[-1]) < width:
        notes.append(f"line {numbers[-1]} is cut off and was left out")
        rows, numbers = rows[:-1], numbers[:-1]
    for i, row in enumerate(rows):
        if len(row) == width:
            continue
        if len(row) < width or any(row[width:]):
            raise Refused(2, f"{path}:{numbers[i]}: {len(row)} fields, expected {width} as in the header")
        rows[i] = row[:width]
    return rows, numbers


def named_once(named):
    """A name that stands twice gets numbers."""
    often, count = Counter(name for name, _ in named), Counter()
    for name, unit in named:
        count[name] += 1
        yield (name if often[name] == 1 else f"{name} ({count[name]})"), unit


def read(path, data):
    """A Table of a text file's bytes."""
    notes = []
    if data[:2] == b"\x1f\x8b":
        try:
            data = gzip.decompress(data)
        except (OSError, EOFError) as error:
            raise Refused(2, f"{path}: damaged: {error}") from error
    numbers, lines = lines_of(decode(data, notes))
    if len(lines) < 2:
        raise Refused(2, f"{path}: {'empty' if not lines else 'one line only'}")
    if BUS_LOG.match(lines[0]):
        raise Refused(2, f"{path}: a log of the bus, try: talus-acquire-export --dbc D.dbc --model M.yaml --out recording.csv '{path}'")
    separator = separator_of(lines)
    if separator is None:
        raise Refused(2, f"{path}: no separator parts its lines into columns of numbers (tried tab ; | , and blank)")
    rows = [fields_of(line, separator) for line in lines]
    first, named = header_of(rows, path)
    while named and not named[-1][0] and named[-1][1] is None:  # a separator behind the last name
        named = named[:-1]
    rows, numbers = check_widths(rows[first:], numbers[first:], len(named), path, notes)
    decimal = decimal_of(rows)
    if separator != "," or decimal != ".":
        notes.append(f"separated by {WORDS.get(separator, repr(separator))}, decimal sign '{decimal}'")
    if first == 0:
        notes.append("has no header")
    columns = zip(*rows, strict=True)
    return Table(str(path), [Column(name, unit, list(cells), numbers, decimal)
                             for (name, unit), cells in zip(named_once(named), columns, strict=True)], notes)  # fmt: skip
