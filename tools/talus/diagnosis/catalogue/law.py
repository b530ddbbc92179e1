"""Columns of the library's own laws (lib/effects) along a scene."""

import numpy as np

from talus import ffi, lib, pointer

from ..kinds import kind_of


def law_column(effect, joints, amounts, shapes, sign=1.0):
    """A column of a law of the instant at some joints: the sum of its strengths' columns, each times its amount."""
    kind = kind_of(effect)
    shape, parts = kind.shape(shapes), [(kind.number(name), sign * amount) for name, amount in amounts.items()]

    def column(scene):
        shown = {}
        for j in joints:
            every = scene.latest((effect, j, *shape), lambda j=j: _at_instants(kind, shape, scene.instants(j)))
            torque = sum(amount * every[number] for number, amount in parts)
            shown[f"T{j}"] = scene.track.operate(torque / scene.ratio[j], j)
        return shown

    return column


def _at_instants(kind, shape, instants):
    """Torque at the joint per unit of each strength, (strengths, n)."""
    columns = np.empty((len(kind.strengths), len(instants)))
    of_c = ffi.from_buffer("tl_effect_instant[]", instants)
    lib.tl_effect_columns_at(kind.struct, pointer(shape), of_c, len(instants), pointer(columns))
    return columns


def column_along(effect, joint, strength, shapes):
    """A column of a law with memory, or of one that shows between sensors, along each scene. Slower than law_column: the
    library walks the scene's motion for it."""
    kind = kind_of(effect)
    shape, number = kind.shape(shapes), kind.number(strength)

    def column(scene):
        found = scene.latest((effect, joint, *shape), lambda: _along(scene, kind.struct, joint, shape))
        return {shown: values[number] for shown, values in found.items()}

    return column


def _along(scene, kind, joint, shape):
    """All columns of a kind of effect in every channel that shows them."""
    track, model = scene.track, scene.library_model()
    shown = {f"T{j}": j for j in range(scene.evidence.joints)}
    angles = {"E": lib.TL_EFFECT_SHOWS_ENCODER, "F": lib.TL_EFFECT_SHOWS_FOOT} if joint else {"K": lib.TL_EFFECT_SHOWS_SHANK}
    shown |= {name: number for name, number in angles.items() if name in scene.evidence.kinds}
    at_rows = {name: np.zeros((kind.strengths, len(scene.t_s))) for name in shown}
    for part in track.parts:
        rows = slice(part["begin"], part["end"])
        stretch, alive = _stretch(scene, model, part)
        for name, number in shown.items():
            column = np.zeros((kind.strengths, stretch.n))
            lib.tl_effect_columns_along(kind, joint, pointer(shape), stretch, number, pointer(column))
            at_rows[name][:, rows] = column
        del alive
    torque = {f"T{j}": j for j in range(scene.evidence.joints)}
    return {name: np.array([track.operate(x / scene.ratio[torque[name]], torque[name]) if name in torque else track.operate(x)
                            for x in columns]) for name, columns in at_rows.items()}  # fmt: skip


def _stretch(scene, model, part):
    """A part of the recording for the library; keep the second alive while it is used."""
    stretch, begin, end = ffi.new("tl_effect_stretch *"), part["begin"], part["end"]
    alive = [model, np.ascontiguousarray(scene.t_s[begin:end]), np.empty(lib.tl_effect_stretch_work(end - begin))]
    stretch.model, stretch.n, stretch.t_s, stretch.work = model.struct, end - begin, pointer(alive[1]), pointer(alive[2])
    for j in range(scene.evidence.joints):
        stops, sensing = part["stops"][j], scene.track.regression.struct.sensing[j]
        stretch.stop[j], stretch.stops[j] = stops, len(stops)
        stretch.window[j] = ffi.NULL if sensing.across else ffi.addressof(sensing, "window")
        for name in ("q", "v", "a", "slip"):
            alive.append(np.ascontiguousarray(getattr(scene, name)[j][begin:end]))
            getattr(stretch, name)[j] = pointer(alive[-1])
    return stretch, alive
