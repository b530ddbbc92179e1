"""Columns of the library's effects (lib/effects) along recordings: many at once, so that what they share is made once."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from talus import constants, ffi, lib, pointer

from ..kinds import kind_of

BASE = constants.TL_MAX_JOINTS
TOGETHER = 1 << 16  # numbers of one channel's columns that are made at once
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
        return self.along([terms])[0]

    def along(self, all_terms):
        """The same of each recording; links behind a spring are stepped together."""
        every = [(self.shape, [self])]
        if self.is_of_the_instant:
            found = [_of_the_instant(terms, kind_of(self.effect), self.joints, self.session, every)[1] for terms in all_terms]
        else:
            found = _over_segments(all_terms, kind_of(self.effect), self.joints[0], _strengths(every), every)[1]
        return [{name: values[0] for name, values in shown.items() if shows(values[0])} for shown in found]

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
        for shape in shapes.items():
            by_strengths.setdefault(_strengths([shape]), []).append(shape)
        for wanted, every in by_strengths.items():
            for some in _some(every, kind, terms):
                own, (shown,) = _over_segments([terms], kind, joints[0], wanted, some)
                yield own, shown


def _strengths(shapes):
    """Set, as 1 << number, of the strengths whose columns are summed."""
    return sum({1 << number for _, own in shapes for one in own for number, _ in one.amounts})


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


def _over_segments(all_terms, kind, joint, strengths, shapes):
    """(columns, [{channel: (columns, grid)} of each recording]) of some shapes of a kind that is no law of the instant, all with the
    same strengths."""
    columns = [one for _, own in shapes for one in own]
    raw = _raw(all_terms, kind, joint, strengths, np.array([shape for shape, _ in shapes]))
    out = []
    for terms in all_terms:
        parts = [_of_part(terms, kind, shapes, number, next(raw)) for number in range(len(terms.processed.parts))]
        silent = [np.zeros((len(columns), part["n"])) for part in terms.processed.parts]
        shown = sorted({name for part in parts for name in part})
        out.append({name: np.concatenate([part.get(name, none) for part, none in zip(parts, silent)], axis=1) for name in shown})
    return columns, out


def _raw(all_terms, kind, joint, strengths, shapes):
    """Iterator over {channel: (shapes, strengths, samples)} of each part of each recording, of channels that show anything; only
    the strengths that are asked for are written."""
    prepared = [terms.prepared(number) for terms in all_terms for number in range(len(terms.processed.parts))]
    channels = [terms.channels_of(joint) for terms in all_terms for _ in terms.processed.parts]
    raw = [{name: np.empty((len(shapes), len(kind.strengths), one.segment.n)) for name in names}
           for one, names in zip(prepared, channels)]  # fmt: skip
    wanted = ffi.new("tl_effect_wanted[]", [{"strengths": strengths} for _ in prepared])
    for one, shown in zip(wanted, raw):
        for name, values in shown.items():
            one.shown[_CHANNEL[name]] = pointer(values)
    lanes = min(len(shapes) * len(prepared), constants.TL_TWO_MASS_LANES) if kind.struct.link else 0
    work = np.empty(lanes * lib.tl_effect_link_memory(max(one.segment.n for one in prepared)))
    lib.tl_effect_segments_columns(kind.struct, joint, pointer(shapes.reshape(-1)), len(shapes), prepared, wanted, len(prepared),
                                   pointer(work), lanes)  # fmt: skip
    numbers = [k for k in range(len(kind.strengths)) if strengths >> k & 1]
    seen = lambda values: any(shows(one[k]) for one in values for k in numbers)
    return ({name: values for name, values in shown.items() if seen(values)} for shown in raw)


def _of_part(terms, kind, every, number, shown):
    """{channel: (columns, grid)} of one part of a recording from its raw columns."""
    out = {}
    for name, values in shown.items():
        torque = int(name[1]) if name[0] == "T" else None
        sums = np.array([_sum(values[k], one) for k, (_, own) in enumerate(every) for one in own])
        out[name] = terms.operated_part(sums, torque, number, bridged=bool(kind.struct.bridged))
    return out


_CHANNEL = {"T0": 0, "T1": 1, "E": lib.TL_EFFECT_SHOWS_ENCODER, "K": lib.TL_EFFECT_SHOWS_SHANK,
            "F": lib.TL_EFFECT_SHOWS_FOOT}  # fmt: skip
