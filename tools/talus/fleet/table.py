"""The table of a fleet, a recording a line, and the items of work that it asks for: what one diagnosis is made of."""

import csv
import hashlib
import math
import re
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

from talus.refused import Refused

NEEDED, OPTIONAL = ("recording", "model", "robot", "session"), ("temperature_C",)
COLDEST_C, HOTTEST_C = -100.0, 300.0


@dataclass(frozen=True)
class Item:
    """One diagnosis: recordings of one robot and session, and the model that they are held against. `name` is its folder."""

    name: str
    robot: str
    session: str
    model: str
    recordings: tuple[str, ...]
    temperature_C: float | None = None

    def plain(self):
        """For JSON."""
        return {**asdict(self), "recordings": list(self.recordings)}

    @staticmethod
    def of(plain):
        return Item(**{**plain, "recordings": tuple(plain["recordings"])})


def days(session):
    """A session's date as days since 1970; ValueError where it is none. Without a time zone it is taken for UTC.

    >>> days("1970-01-02"), days("1970-01-02T12:00")
    (1.0, 1.5)
    """
    when = datetime.fromisoformat(session)
    return (when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp() / 86400


def read(path, by_session=False):
    """[Item] of a table, in its order; with `by_session` all recordings of a robot and session make one item."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            rows = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise Refused(2, f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    header = [name.strip() for name in rows[0]] if rows else []
    _check_header(path, header)
    items = [_item(path, number, header, row) for number, row in enumerate(rows[1:], 2) if any(cell.strip() for cell in row)]
    if not items:
        raise Refused(2, f"{path}: no recording below the header")
    _check_once(path, items)
    return _sessions(path, items) if by_session else items


def _check_header(path, header):
    for name in NEEDED:
        if name not in header:
            raise Refused(2, f"{path}:1: missing column: {name}; found {', '.join(header) or 'nothing'}")
    for name in header:
        if name not in NEEDED + OPTIONAL or header.count(name) > 1:
            raise Refused(2, f"{path}:1: unexpected column: {name}; expected {', '.join(NEEDED)} and perhaps {', '.join(OPTIONAL)}")


def _item(path, number, header, row):
    """The item of a line."""
    place = f"{path}:{number}"
    if len(row) != len(header):
        raise Refused(2, f"{place}: expected {len(header)} fields, found {len(row)}")
    cells = {name: cell.strip() for name, cell in zip(header, row)}
    for name in NEEDED:
        if not cells[name]:
            raise Refused(2, f"{place}: {name} is empty")
    try:
        days(cells["session"])
    except ValueError:
        raise Refused(2, f"{place}: session: expected a date such as 2026-03-01 or 2026-03-01T14:30, found '{cells['session']}'") from None
    folder = Path(path).resolve().parent
    model, recording = (str(folder / cells[key]) for key in ("model", "recording"))
    name = _name(cells["robot"], cells["session"], cells["recording"])
    return Item(name, cells["robot"], cells["session"], model, (recording,), _temperature(place, cells.get("temperature_C", "")))


def _temperature(place, text):
    """A temperature in degrees Celsius; None where the cell is empty."""
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not COLDEST_C <= value <= HOTTEST_C:
        raise Refused(2, f"{place}: temperature_C: expected a number from {COLDEST_C:g} to {HOTTEST_C:g}, found '{text}'")
    return value


def _check_once(path, items):
    """The same recording twice is a slip of the pen, and would count twice."""
    seen = set()
    for item in items:
        if item.recordings in seen:
            raise Refused(2, f"{path}: {item.recordings[0]} stands there twice")
        seen.add(item.recordings)


def _name(robot, session, *more):
    """A folder's name: readable, and unique by a hash of what it stands for."""
    digest = hashlib.sha256("\0".join((robot, session, *more)).encode()).hexdigest()[:10]
    readable = [re.sub(r"[^A-Za-z0-9]+", "-", text).strip("-")[:40] for text in (robot, session)]
    return "_".join([*readable, digest])


def _sessions(path, items):
    """Items joined by robot and session, at the mean of their temperatures."""
    groups = {}
    for item in items:
        groups.setdefault((item.robot, item.session), []).append(item)
    out = []
    for (robot, session), own in groups.items():
        if len({item.model for item in own}) > 1:
            raise Refused(2, f"{path}: {robot}, {session}: expected one model for the session's recordings")
        temperatures = [item.temperature_C for item in own if item.temperature_C is not None]
        mean = math.fsum(temperatures) / len(temperatures) if temperatures else None
        recordings = tuple(recording for item in own for recording in item.recordings)
        out.append(Item(_name(robot, session), robot, session, own[0].model, recordings, mean))
    return out
