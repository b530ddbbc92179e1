"""Columns of the library's effects (lib/effects) along recordings: many at once, so that what they share is made once."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from talus import constants, ffi, lib, pointer

from ..kinds import kind_of

BASE = constants.TL_MAX_JOINTS
TOGETHER = 1 << 17  # numbers of one channel's columns that are made at once
# an instant at which every law of the instant shows each of its strengths
ANY_INSTANT = {"q": 0.31, "v": 1.3, "slip": 1.0, "load_Nm": 1.7, "rotor_Nm": 0.3, "friction_Nm": 0.4, "offset_Nm": 0.2, "motor_Nm": 0.9,
               "motor_rad": 2.3, "ratio": 3.0, "effort_Nm": 0.6, "gravity_tilt_Nm": 0.7, "t_s": 5.0, "temp_C": 40.0}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """A sum of an effect's strengths' columns, each times its amount: what shows per unit of a candidate's strength.
    `amounts` are ((number of the strength, amount), ...). Time counts from each recording's begin, or over the session."""

    effect: str
    joints: tuple  # at which the law acts; of an effect of the base that is no law of the instant (BASE,)
    amounts: tuple
    shape: tuple
    sign: float = 1.0
    session: bool = False
    _hash: int = field(default=0, compare=False, repr=False)

    def __post_init__(self):
        of = self.effect, self.joints, self.amounts, self.shape, self.sign, self.session
        object.__setattr__(self, "_hash", hash(of))

    def __hash__(self):
        return self._hash

    def __call__(self, terms):
        """{channel: column on the grid} of one recording."""
        (_, shown), = batches(terms, [self])
        return {name: values[0] for name, values in shown.items() if shows(values[0])}

    @property
    def is_of_the_instant(self):
        return _is_of_the_instant(self.effect, self.amounts[0][0])


def column(effect, joints, amounts, shapes, sign=1.0, session=False):
    """A column from amounts and shapes by name; other shapes as the table has them."""
    kind = kind_of(effect)
    return Column(effect, tuple(joints), tuple((kind.number(name), float(x)) for name, x in amounts.items()),
                  tuple(kind.shape(shapes)), sign, session)  # fmt: skip


@lru_cache(None)
def _is_of_the_instant(effect, number):
    """Is a strength's column one of the law of the instant, or of the kind's columns over a segment?"""
    struct = kind_of(effect).struct
    if struct.law == ffi.NULL or struct.columns == ffi.NULL:
        return struct.law != ffi.NULL
    out = np.zeros(struct.strengths)
    lib.tl_effect_columns(struct, pointer(np.ones(max(struct.shapes, 1))), ffi.new("tl_effect_instant *", ANY_INSTANT),
                          pointer(out))  # fmt: skip
    return out[number] != 0


def batches(terms, columns):
    """Yields (some of the columns, {channel: their values on the grid, (columns, grid)}); equal shapes are evaluated once. A
    column that a channel does not show is 0 there."""
    groups = {}
    for one in columns:
        groups.setdefault((one.effect, one.joints, one.session, one.is_of_the_instant), {}).setdefault(one.shape, []).append(one)
    for (effect, joints, session, of_the_instant), shapes in groups.items():
        kind = kind_of(effect)
        if of_the_instant:
            for some in _some(list(shapes.items()), kind, terms):
                yield _of_the_instant(terms, kind, joints, session, some)
            continue
        by_strengths = {}
        for shape, own in shapes.items():
            wanted = sum({1 << number for one in own for number, _ in one.amounts})
            by_strengths.setdefault(wanted, []).append((shape, own))
        for wanted, every in by_strengths.items():
            for some in _some(every, kind, terms):
                yield _over_segments(terms, kind, joints[0], wanted, some)


def _some(shapes, kind, terms):
    """So many shapes at once that their columns stay small."""
    at_once = max(1, TOGETHER // (len(kind.strengths) * len(terms.t_s)))
    return (shapes[begin:begin + at_once] for begin in range(0, len(shapes), at_once))


def shows(values):
    """Is a column other than 0? By its squares, which is faster than to ask each."""
    with np.errstate(over="ignore", invalid="ignore"):  # of a link that has run away
        return values @ values != 0


# ---- laws of the instant ---------------------------------------------------------------


def _of_the_instant(terms, kind, joints, session, shapes):
    """Columns of some shapes of a law."""
    columns, shown = [one for _, own in shapes for one in own], {}
    for j in joints:
        now, torque = ffi.from_buffer("tl_effect_instant[]", terms.instants(j, session)), []
        every = np.empty((len(kind.strengths), len(terms.t_s)))
        for shape, own in shapes:
            lib.tl_effect_columns_at(kind.struct, pointer(np.array(shape)), now, len(terms.t_s), pointer(every))
            torque += [_sum(every, one) for one in own]
        shown[f"T{j}"] = terms.operated(np.array(torque), j)
    return columns, shown


def law_at(terms, joint, effect, strength, shapes):
    """Torque at the joint per unit of a strength of a law of the instant, at the samples."""
    kind = kind_of(effect)
    every = np.empty((len(kind.strengths), len(terms.t_s)))
    now = ffi.from_buffer("tl_effect_instant[]", terms.instants(joint))
    lib.tl_effect_columns_at(kind.struct, pointer(kind.shape(shapes)), now, len(terms.t_s), pointer(every))
    return every[kind.number(strength)]


def _sum(every, column):
    """The column's sum over (strengths, n)."""
    (first, amount), *others = column.amounts
    out = column.sign * amount * every[first]
    for number, more in others:
        out += column.sign * more * every[number]
    return out


# ---- over segments ---------------------------------------------------------------------


def _over_segments(terms, kind, joint, strengths, shapes):
    """Columns of some shapes of a kind that is no law of the instant, all with the same strengths."""
    columns = [one for _, own in shapes for one in own]
    parts = [_of_part(terms, kind, joint, strengths, shapes, number) for number in range(len(terms.processed.parts))]
    silent = [np.zeros((len(columns), part["n"])) for part in terms.processed.parts]
    shown = sorted({name for part in parts for name in part})
    return columns, {name: np.concatenate([part.get(name, none) for part, none in zip(parts, silent)], axis=1) for name in shown}


def _of_part(terms, kind, joint, strengths, every, number):
    """{channel: (columns, grid)} of one part of a recording, of channels that show anything."""
    prepared = terms.prepared(number)
    n = prepared.segment.n
    shown = {name: np.zeros((len(every), len(kind.strengths), n)) for name in terms.channels_of(joint)}
    wanted = ffi.new("tl_effect_wanted *", {"strengths": strengths})
    for name, values in shown.items():
        wanted.shown[_CHANNEL[name]] = pointer(values)
    lib.tl_effect_segment_columns(kind.struct, joint, pointer(np.array([shape for shape, _ in every]).reshape(-1)), len(every),
                                  prepared, wanted)  # fmt: skip
    out = {}
    for name, values in shown.items():
        if not shows(values.reshape(-1)):
            continue
        torque = int(name[1]) if name[0] == "T" else None
        sums = np.array([_sum(values[k], one) for k, (_, own) in enumerate(every) for one in own])
        out[name] = terms.operated_part(sums, torque, number, bridged=bool(kind.struct.bridged))
    return out


_CHANNEL = {"T0": 0, "T1": 1, "E": lib.TL_EFFECT_SHOWS_ENCODER, "K": lib.TL_EFFECT_SHOWS_SHANK,
            "F": lib.TL_EFFECT_SHOWS_FOOT}  # fmt: skip
