"""The map: which column comes from which source, in which unit, with which sign, zero and wrap."""

from dataclasses import dataclass
from pathlib import Path

import yaml

import talus
from talus.refused import Refused

KEYS = {"source", "unit", "sign", "zero", "wrap", "file"}


@dataclass
class Entry:
    """value = sign x (source - zero) in `unit`, put into the column's unit; `wrap` is the period at which the source
    starts again, `file` the number of the input it stands in (from 1 on)."""

    source: str
    unit: str | None = None
    sign: float = 1.0
    zero: float = 0.0
    wrap: float | None = None
    file: int | None = None

    def tree(self):
        plain = {"source": self.source, "unit": self.unit}
        plain |= {"sign": int(self.sign)} if self.sign != 1 else {}
        return plain | {k: v for k, v in (("zero", self.zero or None), ("wrap", self.wrap), ("file", self.file)) if v is not None}


class Map:
    """Entries by column; `clocks` holds {number of input: Entry of its time, offset_s}."""

    def __init__(self, plant=None):
        self.plant, self.columns, self.clocks = plant, {}, {}

    def text(self, doubts=()):
        tree = {"plant": self.plant, "columns": {name: entry.tree() for name, entry in self.columns.items()}}
        if self.clocks:
            tree["clocks"] = self.clocks
        lines = [f"# unsure: {doubt}\n" for doubt in doubts]
        return "".join(lines) + yaml.safe_dump(tree, sort_keys=False, allow_unicode=True)


def _fail(path, text):
    raise Refused(2, f"{path}: {text}")


def check_column(path, name):
    if name not in talus.channels():
        _fail(path, f"'{name[:40]}' is no column of a recording; there are {', '.join(sorted(talus.channels()))}")


def _number(path, key, value):
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        _fail(path, f"{key}: expected a number, found '{value}'")
    return float(value)


def entry_of(path, name, tree):
    """An Entry of the map's own mapping."""
    check_column(path, name)
    if isinstance(tree, str):
        tree = {"source": tree}
    if not isinstance(tree, dict) or "source" not in tree:
        _fail(path, f"{name}: expected source, unit and, where it needs them, sign, zero, wrap, file")
    unknown = set(tree) - KEYS
    if unknown:
        _fail(path, f"{name}: unknown key {sorted(map(str, unknown))[0]}; there are {', '.join(sorted(KEYS))}")
    numbers = {key: _number(path, f"{name}: {key}", tree[key]) for key in ("sign", "zero", "wrap") if tree.get(key) is not None}
    if numbers.get("sign", 1.0) not in (1.0, -1.0) or numbers.get("wrap", 1.0) <= 0:
        _fail(path, f"{name}: expected sign 1 or -1 and wrap above 0")
    unit = None if tree.get("unit") is None else str(tree["unit"])
    return Entry(str(tree["source"]), unit, file=tree.get("file"), **numbers)


def read(path):
    """A Map of a YAML file."""
    try:
        tree = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise Refused(2, f"{path}: {error.strerror}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        line = getattr(getattr(error, "problem_mark", None), "line", None)
        raise Refused(2, f"{path}{'' if line is None else f':{line + 1}'}: is no YAML") from error
    if not isinstance(tree, dict) or not isinstance(tree.get("columns"), dict):
        _fail(path, "expected columns: with an entry for each column")
    unknown = set(tree) - {"plant", "columns", "clocks"}
    if unknown:
        _fail(path, f"unknown key {sorted(map(str, unknown))[0]}; there are plant, columns, clocks")
    out = Map(tree.get("plant"))
    out.columns = {str(name): entry_of(path, str(name), item) for name, item in tree["columns"].items()}
    for number, item in (tree.get("clocks") or {}).items():
        if not isinstance(item, dict) or set(item) - {"offset_s"}:
            _fail(path, f"clocks: {number}: expected offset_s")
        out.clocks[number] = {"offset_s": _number(path, f"clocks: {number}: offset_s", item.get("offset_s"))}
    return out


def add(mapped, text):
    """An entry given as COLUMN=SOURCE:UNIT, also -SOURCE for a turned sign; a unit has no colon, a source may."""
    column, equals, rest = text.partition("=")
    if not equals or not rest:
        raise Refused(2, f"--map: expected MAP.yaml or COLUMN=SOURCE:UNIT, found '{text[:60]}'")
    check_column("--map", column)
    source, colon, unit = rest.rpartition(":")
    source, unit = (source, unit) if colon else (rest, None)
    sign = -1.0 if source.startswith("-") else 1.0
    mapped.columns[column] = Entry(source.lstrip("-") if sign < 0 else source, unit or None, sign)
