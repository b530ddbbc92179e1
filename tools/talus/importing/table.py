"""A file's columns, whatever its format."""

import re
from dataclasses import dataclass, field

import numpy as np

from talus.refused import Refused

from . import headers

MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "--", "inf", "-inf", "+inf", "#n/a", "nat", "?"}
NUMBERED = re.compile(r"\s*(\[\d+\]|\(\d+\))$")  # of a matrix' or list's column, or of a header that stands twice


@dataclass
class Column:
    """One column: `raw` is a list of texts or a numeric array; `unit` as its header says it."""

    name: str
    unit: str | None
    raw: object
    lines: object = None  # of the file, for messages
    decimal: str = "."

    @property
    def label(self):
        """Its name with its unit."""
        return self.name if self.unit is None else f"{self.name} [{self.unit}]"

    def plain(self):
        """Texts with a point as decimal sign and no thousands' signs; arrays as they are."""
        if isinstance(self.raw, np.ndarray):
            return self.raw
        if self.decimal == ",":
            return [text.replace(".", "").replace(",", ".") for text in self.raw]
        return [text.replace(",", "") for text in self.raw] if any("," in text for text in self.raw[:1000]) else self.raw

    def numbers(self, path):
        """float64, NaN where nothing stands; Refused names the line of what is no number."""
        plain = self.plain()
        if isinstance(plain, np.ndarray):
            return np.where(np.isfinite(plain.astype(float)), plain.astype(float), np.nan)
        try:
            return np.array([np.nan if text.lower() in MISSING else float(text) for text in plain])
        except ValueError:
            row = next(i for i, text in enumerate(plain) if text.lower() not in MISSING and not is_number(text))
            raise Refused(2, f"{path}:{self.lines[row]}: {self.name}: '{self.raw[row][:40]}' is not a number") from None

    def is_numeric(self):
        if isinstance(self.raw, np.ndarray):
            return self.raw.dtype.kind in "fiub"
        plain = [text for text in self.plain()[:200] if text.lower() not in MISSING]
        return bool(plain) and all(map(is_number, plain))


@dataclass
class Table:
    """A file that was read, or what one of its clocks times; `notes` are words on how, `clock` is the time, where the format knows it."""

    path: str
    columns: list
    notes: list = field(default_factory=list)
    clock: Column | None = None

    def called(self, name):
        """The columns that a name may mean: the one of this name, with or without its unit and as its header writes it; else all
        that bear it with a number."""
        wanted = " ".join(name.split())
        said = headers.split(wanted)
        stems = [NUMBERED.sub("", c.name) for c in self.columns]
        found = [c for c in self.columns if wanted in (c.name, c.label) or said == (c.name, c.unit)]
        return found or [c for c, stem in zip(self.columns, stems, strict=True) if wanted == stem or said == (stem, c.unit)]


def is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True
