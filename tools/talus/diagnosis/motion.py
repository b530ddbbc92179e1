"""The motion gap: the library's simulation of the model under the recorded torque, against the recorded motion.

The recorded torque in open loop runs away from any recording, so the motion begins anew at the recorded state every
WINDOW_S. Effects that forward time knows act in the simulation; of all others, what they are along the recorded motion is
taken off the torque. docs/diagnosis.md has the limits.
"""

import numpy as np

from talus import TalusError, check, ffi, lib, pointer

from . import processors
from .catalogue.law import BASE
from .kinds import is_known, kind_of
from .torque_terms import model_at

WINDOW_S = 0.25
LONGEST_STEP_S = 0.005
MOST_OF_GIVEN = 4.0  # factor on the given inertia beyond which a fit's is not a plant's
POSES = 9  # of the last joint, at which the inertia is looked at


class Windows:
    """Ranges of the grid that do not overlap, in the rows that are kept at every joint."""

    def __init__(self, processed):
        self.steps = max(2, round(WINDOW_S / processed.step_s))
        self.step_s, begin, starts = processed.step_s, 0, []
        kept = np.all([kind != 0 for kind in processed.kind], axis=0)
        for part in processed.parts:
            first = begin
            while first + self.steps < begin + part["n"]:
                if kept[first:first + self.steps + 1].all():
                    starts.append(first)
                    first += self.steps
                else:
                    first += 1
            begin += part["n"]
        self.starts = np.array(starts, np.uint64)


# ---- the plant ---------------------------------------------------------------------


def inertia_over(model, angles):
    """Inertia matrices at some poses (poses, joints)."""
    joints, out = len(model.joints), []
    for pose in angles:
        matrix = np.zeros((joints, joints))
        lib.tl_inertia_matrix(model.struct, pointer(np.resize(pose, BASE).astype(float)), pointer(matrix))
        out.append(matrix)
    return np.array(out)


def has_inertia(dataset, base):
    """Could these base parameters be a machine's, where the recorded motion mostly is? An effect that is not in the model can turn its
    inertia negative."""
    poses = np.median(dataset.processed_recordings[0].q, axis=1)[None]
    try:
        np.linalg.cholesky(inertia_over(model_at(dataset, base), poses)[0])
    except np.linalg.LinAlgError:
        return False
    return True


def is_plausible(terms):
    """Is the fit's inertia one that a plant can have, and within a factor of the given one?"""
    poses = np.array([np.quantile(q[terms.processed.inside], np.linspace(0, 1, POSES)) for q in terms.q]).T
    mine, given = (inertia_over(model, poses) for model in (terms.model, terms.dataset.model))
    try:
        roots = np.linalg.inv(np.linalg.cholesky(given))
    except np.linalg.LinAlgError:
        return True  # nothing to compare with
    share = np.linalg.eigvalsh(roots @ mine @ np.swapaxes(roots, 1, 2))
    return bool(share.min() > 1 / MOST_OF_GIVEN and share.max() < MOST_OF_GIVEN)


def plant_of(terms):
    """The model of torque terms, its friction none below 0."""
    model = terms.model.copy()
    for j in range(terms.dataset.joints):
        drive = model.struct.drive[j]
        drive.coulomb_Nm, drive.viscous_Nms_rad = max(drive.coulomb_Nm, 0.0), max(drive.viscous_Nms_rad, 0.0)
    return model


# ---- effects -----------------------------------------------------------------------


def effect_of(dataset, candidate, strengths):
    """A candidate as the library's effect."""
    kind, values = kind_of(candidate.effect), candidate.entry(strengths)
    effect = ffi.new("tl_effect *", {"kind": kind.struct})
    joints = dataset.model.joints
    effect.joint = joints.index(candidate.joint) if candidate.joint in joints else BASE
    for k, parameter in enumerate(kind.parameters):
        effect.value[k] = values.get(parameter.name, parameter.default_value or 0.0)
    return effect


def acts_in_time(effect, model):
    """Does forward time know it: a mechanical law, within its range?"""
    known = effect.kind.acts == lib.TL_EFFECT_MECHANICAL and lib.tl_effect_fit_only(effect) < 0
    return known and lib.tl_effect_check(effect, model.struct) == lib.TL_OK


def acting(search, record, model, chosen, strengths):
    """(effects that act in the simulation, what the others are along the recorded motion, (joints, n) on the grid)."""
    terms, rest = search.all_terms[record], list(strengths)
    effects, fixed = [], np.zeros((terms.dataset.joints, len(terms.processed.grid_t_s)))
    for candidate in chosen:
        own, rest = rest[:len(candidate.columns)], rest[len(candidate.columns):]
        for part, mine in candidate.pieces(own):
            effect = effect_of(terms.dataset, part, mine) if is_known(part.effect) else None
            if effect is not None and acts_in_time(effect, model):
                effects.append(effect)
                continue
            for column, strength in zip(part.columns, mine):
                for name, values in column(terms).items():
                    if name[0] == "T":
                        fixed[int(name[1])] += strength * values
    return effects, fixed


# ---- the simulation ----------------------------------------------------------------


def deviations(terms, windows, model, effects, torque):
    """Simulated less recorded position of every joint in all windows, (joints, steps, windows); None where the plant
    cannot be simulated."""
    joints = range(terms.dataset.joints)
    q, v = ([np.ascontiguousarray(terms.grid(name, j)) for j in joints] for name in ("q", "v"))
    torque = [np.ascontiguousarray(x) for x in torque]
    out = np.zeros((len(joints), windows.steps, len(windows.starts)))
    every = ffi.new("tl_effect[]", max(len(effects), 1))
    for place, effect in enumerate(effects):
        every[place] = effect[0]
    spec = ffi.new("tl_windows *", {"model": model.struct, "effect": every, "effects": len(effects), "step_s": windows.step_s,
                   "begin_s": terms.processed.grid_t_s[0] - terms.processed.recording.origin.begin_s, "longest_step_s": LONGEST_STEP_S,
                   "first": ffi.from_buffer("size_t[]", windows.starts), "count": len(windows.starts), "steps": windows.steps,
                   "deviation": pointer(out)})  # fmt: skip
    for name, rows in (("q", q), ("v", v), ("torque", torque)):
        for j in joints:
            getattr(spec, name)[j] = pointer(rows[j])
    try:
        check(lib.tl_simulate_windows(spec))
    except TalusError:
        return None
    return out


def deviations_of(search, record, chosen, residuals):
    """Deviations of one recording, or None where it has no window."""
    dataset, windows = search.dataset, Windows(search.dataset.processed_recordings[record])
    if not len(windows.starts):
        return None
    given, joints = search.all_terms[record], range(dataset.joints)
    base = residuals.strengths[:dataset.bases]
    terms = given if np.array_equal(given.base, base) else given.at(base, given.torque_constant_error)
    if not is_plausible(terms):  # then the given model stands in, with what the fit leaves of the torque
        terms = given.at(dataset.prior)
        torque = [terms.grid("motor_Nm", j) + residuals.of[record, f"T{j}"] for j in joints]
        return deviations(terms, windows, plant_of(terms), [], torque)
    effects, fixed = acting(search, record, terms.model, chosen, residuals.strengths[search.gram.first:])
    torque = [terms.processed.resample(dataset.effort(record, j)) - fixed[j] for j in joints]
    return deviations(terms, windows, plant_of(terms), effects, torque)


def rms(search, chosen, residuals):
    """RMS of each joint's deviation over all recordings."""
    found = processors.each(lambda record: deviations_of(search, record, chosen, residuals), range(len(search.dataset.processed_recordings)))
    found = [x.reshape(len(x), -1) for x in found if x is not None]
    if not found:
        return np.full(search.dataset.joints, np.nan)
    return np.sqrt(np.mean(np.concatenate(found, axis=1) ** 2, axis=1))


def motion(search, fit, before, after):
    """`motion` of the report; empty where a sensor at the output was recorded: there the motion is not the drive's."""
    if search.dataset.load_sensor:
        return {}
    identified = rms(search, [], before)
    extended = rms(search, fit.chosen, after) if fit.chosen else identified
    unit = search.dataset.model.coordinate_unit
    return {name: {"unit": unit, "identified_rms": float(x), "extended_rms": float(y)}
            for name, x, y in zip(search.dataset.model.joints, identified, extended) if np.isfinite(x + y)}  # fmt: skip
