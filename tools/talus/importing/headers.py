"""Name and unit of a header's field; what a unit is worth, through pint."""

import functools
import re

from talus.refused import Refused

# How headers write units, where that is not how pint writes them.
WRITTEN = {
    "°": "degree", "deg": "degree", "degs": "degree", "degrees": "degree", "grad": "degree", "rad": "radian", "rads": "radian",
    "radians": "radian", "rev": "turn", "revs": "turn", "turn": "turn", "turns": "turn", "u": "turn", "umdrehungen": "turn",
    "mrad": "milliradian", "rad/s": "radian/second", "rad_s": "radian/second", "rads/s": "radian/second",
    "rad/sec": "radian/second", "rad*s^-1": "radian/second", "deg/s": "degree/second", "deg_s": "degree/second",
    "deg/sec": "degree/second", "°/s": "degree/second", "dps": "degree/second", "rpm": "rpm", "u/min": "rpm", "1/min": "rpm",
    "min^-1": "rpm", "min-1": "rpm", "rev/s": "turn/second", "rev_s": "turn/second", "s": "second", "sec": "second",
    "secs": "second", "second": "second", "seconds": "second", "sek": "second", "sekunden": "second", "ms": "millisecond",
    "msec": "millisecond", "us": "microsecond", "µs": "microsecond", "μs": "microsecond", "usec": "microsecond",
    "ns": "nanosecond", "nsec": "nanosecond", "min": "minute", "a": "ampere", "amp": "ampere", "amps": "ampere",
    "ma": "milliampere", "ka": "kiloampere", "nm": "newton*meter", "n*m": "newton*meter", "n·m": "newton*meter",
    "n m": "newton*meter", "mnm": "millinewton*meter", "ncm": "newton*centimeter", "c": "degC", "°c": "degC", "degc": "degC",
    "k": "kelvin", "°f": "degF", "degf": "degF", "v": "volt", "mv": "millivolt", "m": "meter", "mm": "millimeter",
    "cm": "centimeter", "um": "micrometer", "µm": "micrometer", "n": "newton", "kn": "kilonewton", "mn": "millinewton",
    "count": "count", "counts": "count", "cts": "count", "ticks": "count", "inc": "count", "lsb": "count",
}  # fmt: skip
CASED = {"Ms": None, "MA": "megaampere", "nm": "nanometer", "MN": "meganewton", "mN": "millinewton", "S": None}
TARGET = {"rad_s": "radian/second", "rad": "radian", "A": "ampere", "Nm": "newton*meter", "C": "degC", "V": "volt",
          "m": "meter", "N": "newton", "s": "second"}  # fmt: skip
BRACKETS = re.compile(r"^(.*?)\s*[\[({<]\s*([^\[\](){}<>]+?)\s*[\])}>]\s*$")
AFTER = re.compile(r"^(.+?)(?:\s+/\s*|\s*,\s+|\s+in\s+)(\S+)$")
INDEX = re.compile(r"^(.*\S)(\s*\[\d+\])$")
CAMEL = re.compile(r"^(.*[a-z0-9])(Deg|Rad|Rpm|Sec|Ms|Us|Ns|Amps?|Nm)$")
SUFFIXES = {"deg", "degs", "degrees", "rad", "rads", "radians", "rev", "turns", "mrad", "rad_s", "deg_s", "rev_s", "dps", "rpm",
            "s", "sec", "secs", "seconds", "ms", "msec", "us", "usec", "ns", "nsec", "a", "amp", "amps", "ma", "nm", "mnm",
            "ncm", "c", "degc", "v", "mv", "m", "mm", "cm", "um", "n", "kn", "counts", "ticks"}  # fmt: skip


def written(text):
    """pint's word for a unit as headers write it, or None."""
    text = text.strip().replace("⋅", "*").replace("·", "*").replace("²", "^2")
    if text in CASED:
        return CASED[text]
    return WRITTEN.get(text.lower())


def split(header):
    """(name, unit or None) of a header's field: "Winkel [°]", "angle_deg", "Strom / mA", "timeMs". A number in brackets is no unit
    but says which one, also behind a unit: "state[0]", "angle_deg[0]"."""
    header = " ".join(header.split())
    one_of = INDEX.match(header)
    if one_of:
        name, unit = split(one_of[1])
        return name + one_of[2], unit
    for pattern in (BRACKETS, AFTER):
        match = pattern.match(header)
        if match and match[1] and (written(match[2]) or pattern is BRACKETS and not match[2].isdecimal()):
            return match[1], match[2]
    match = CAMEL.match(header)
    if match:
        return match[1], "Nm" if match[2] == "Nm" else match[2].lower()
    words = re.split(r"[_. ]", header)
    for n in (2, 1):
        if len(words) > n and "_".join(words[-n:]).lower() in SUFFIXES:
            unit = "_".join(words[-n:])
            return header[: -len(unit) - 1], "Nm" if unit.lower() == "nm" else unit
    return header, None


def beside(header, unit):
    """(name, unit) of a header where the unit stands beside it, if it does: once, where the header says it too."""
    name, said = split(header)
    if not unit:
        return name, said
    same = said is not None and written(said) == (written(unit) or unit)
    return (name if same else header), unit


@functools.cache
def registry():
    try:
        import pint
    except ImportError as error:
        raise Refused(1, "units need the Python package pint: pip install pint") from error
    return pint.UnitRegistry(cache_folder=None, autoconvert_offset_to_baseunit=True)


@functools.cache
def parse(unit):
    """A pint quantity of what the header or the map calls `unit`; None where nobody knows it."""
    expression = written(unit) or unit
    try:
        quantity = registry().Quantity(1, expression) if expression in ("degC", "degF") else registry().parse_expression(expression)
        return quantity if hasattr(quantity, "units") else registry().Quantity(quantity, "")
    except Refused:
        raise
    except Exception:  # noqa: BLE001  pint raises many kinds for a text that is no unit
        return None


def target_of(column):
    """The unit that stands in a column's name, in pint's words."""
    return next(TARGET[end] for end in sorted(TARGET, key=len, reverse=True) if column.endswith(f"_{end}"))


def fits(unit, column):
    """Is this a unit for that column? An angle is no count, though both are plain numbers to physics."""
    quantity, target = parse(unit), registry().Quantity(1, target_of(column))
    if quantity is None:
        return False
    if target.units == registry().degC:
        return quantity.dimensionality == target.dimensionality
    return quantity.to_base_units().units == target.to_base_units().units


def conversion(unit, column):
    """(factor, offset): value in the column's unit = factor x value + offset; Refused where the unit is none for it."""
    if not fits(unit, column):
        example = {"radian": "deg", "ampere": "mA", "second": "ms", "newton*meter": "mNm"}.get(target_of(column), target_of(column))
        raise Refused(2, f"{column}: '{unit}' is no unit for it; expected one such as {example}")
    if target_of(column) == "degC":
        values = [registry().Quantity(x, parse(unit).units).to("degC").magnitude for x in (0.0, 1.0)]
        return values[1] - values[0], values[0]
    return float(parse(unit).to(target_of(column)).magnitude), 0.0
