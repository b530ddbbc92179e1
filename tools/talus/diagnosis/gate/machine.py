"""Columns that do not belong to the model's machine as they stand: units, signs, the motor's angle for the joint's, unsigned
currents, recordings of different machines.

What the plain model needs of each recording (its regressor's rows, joint by joint) is fitted by least squares, and its torque
terms are compared with those of the model file: inertia, gravity and friction that are a hundred times too small do not
come from a wrong drawing. An explanation is named only if it makes all terms plausible that were not so.
"""

from dataclasses import dataclass

import numpy as np

import talus
from talus import ffi, lib

from .finding import Finding

FAR, NEAR = np.log(3.5), np.log(2.2)  # of a torque term, from the model file's: out of the question, and plausible
HARDLY = 0.05  # of the measured torque: smaller terms tell nothing
FEWEST_ROWS = 200
MOST_SAMPLES = 60_000  # of a recording: a wrong unit shows in a minute as in an hour
WORSE_FIT = 1.5  # of the residual, that an explanation may leave more
OTHER_RESIDUAL, OTHER_SHARE = 3.0, 0.25  # times what each leaves by itself, and of the torque beside it: one machine, changed by an effect
NEVER_NEGATIVE, RINGING, NEGATIVE_SHARE = 1e-3, 0.05, 0.15
DEGREES, TURNS = np.pi / 180, 2 * np.pi


@dataclass(frozen=True)
class Explanation:
    """Columns times a factor: the joint's angle, its torque."""

    id: str
    words: str
    remedy: str
    angle: float = 1.0
    torque: float = 1.0


@dataclass
class Rows:
    """Rows of one joint in one recording that count: regressor, measured, and what of it is known."""

    x: np.ndarray
    measured: np.ndarray
    known: np.ndarray
    prior: np.ndarray


def explanations(gear):
    """What columns are mistaken for."""
    yield Explanation("units", "its angle were in degrees", "convert the angle to rad", DEGREES)
    yield Explanation("units", "its angle were in turns", "convert the angle to rad", TURNS)
    yield Explanation("units", "its current were in mA", "convert the current to A", 1.0, 1e-3)
    yield Explanation("sign", "its current or its angle counted the other way", "turn the sign of the current or of the angle", 1.0, -1.0)
    if gear > 1.5:
        yield Explanation("ratio", "its angle were on the other side of the gear: the joint's where the motor's belongs",
                          "multiply the angle by the ratio", gear)  # fmt: skip
        yield Explanation("ratio", "its angle were on the other side of the gear: the motor's where the joint's belongs",
                          "divide the angle by the ratio", 1 / gear)  # fmt: skip
        yield Explanation("ratio", "its torque were on the other side of the gear", "give the torque on the side that the column names",
                          1.0, gear)  # fmt: skip


class Read:
    """Recordings as the plain model reads them, once for all joints."""

    def __init__(self, model, recordings):
        self.regressions = [talus.Regression(model, recording.head(MOST_SAMPLES)) for recording in recordings]
        self.parts = [regression.rows() for regression in self.regressions]


def joint_rows(model, every, joint):
    """Rows of a joint in each recording, of all whose parts are `every`; None where there are too few."""
    out, prior = [], np.array(list(model.base.values()))
    for parts in every:
        kept = [part for part in parts[joint] if np.any(part.kind == lib.TL_ROW_SCORED)]
        if sum(int(np.sum(part.kind == lib.TL_ROW_SCORED)) for part in kept) < FEWEST_ROWS:
            out.append(None)
            continue
        rows = [part.kind == lib.TL_ROW_SCORED for part in kept]
        x, measured, target = (np.concatenate([getattr(part, name)[r] for part, r in zip(kept, rows)])
                               for name in ("x", "measured", "target"))  # fmt: skip
        out.append(Rows(x, measured, measured - target, prior[kept[0].index]))
    return out


def stacked(rows):
    """Rows of several recordings as one; None where there are none."""
    rows = [r for r in rows if r is not None]
    if not rows:
        return None
    out = Rows(*(np.concatenate([getattr(r, n) for r in rows]) for n in ("x", "measured", "known")), rows[0].prior)
    return out if np.isfinite(out.x).all() and np.isfinite(out.known).all() else None  # no linkage stands there


def fitted(rows, torque=1.0):
    """Least squares: base parameters, and the residual over the measured torque (RMS)."""
    size = np.sqrt(np.mean(rows.x**2, axis=0)) + 1e-300
    target = torque * rows.measured - rows.known
    found = np.linalg.lstsq(rows.x / size, target, rcond=1e-10)[0] / size
    scale = np.sqrt(np.mean(rows.measured**2)) * abs(torque) + 1e-300
    return found, float(np.sqrt(np.mean((target - rows.x @ found) ** 2)) / scale)


def distance(rows, found, torque=1.0):
    """The largest logarithm by which a torque term differs from the model file's; a term that works the other way counts as
    far. Terms that hardly bear on the torque do not count."""
    size = np.sqrt(np.mean(rows.x**2, axis=0))
    scale = np.sqrt(np.mean(rows.measured**2)) * abs(torque)
    own, given = found * size, rows.prior * size
    logs = np.abs(np.log((np.abs(own) + HARDLY * scale) / (np.abs(given) + HARDLY * scale)))
    against = (own * np.sign(given) < -4 * HARDLY * scale) & (given != 0)
    return float(np.max(np.where(against, 2 * FAR, np.where(given == 0, 0.0, logs))))


def joint_findings(model, names, recordings, read, joint):
    """What is wrong with a joint's angle or torque; the recordings as they are `read`."""
    name, every = model.joints[joint], joint_rows(model, read.parts, joint)
    rows = stacked(every)
    if rows is None:
        return
    found, left = fitted(rows)
    far = distance(rows, found)
    unsigned = _unsigned(name, rows, left)
    if unsigned:
        yield unsigned
    elif far > FAR:
        best = min(_tried(model, read, joint, rows), key=lambda x: x[0], default=None)
        if best and best[0] < NEAR and best[1] < WORSE_FIT * left + HARDLY:
            yield Finding(best[2].id, True, _column(model, joint, best[2]),
                          f"the {name}'s torque terms are up to {np.exp(far):.0f} times off those of the model file, as if {best[2].words}",
                          best[2].remedy)  # fmt: skip
    yield from _other_machine(name, names, every, [recording.origin.path for recording in recordings])


def _tried(model, read, joint, rows):
    """(distance, residual, explanation) of each."""
    for explanation in explanations(_gear(model, joint)):
        tried = rows if explanation.angle == 1.0 else _at_angle(model, read, joint, explanation.angle)
        if tried is not None:
            found, left = fitted(tried, explanation.torque)
            yield distance(tried, found, explanation.torque), left, explanation


def _at_angle(model, read, joint, factor):
    """Rows of a joint whose angle columns are multiplied."""
    columns = angle_columns(model, joint)
    try:
        changed = [regression.reread(talus.Recording({n: factor * x if n in columns else x for n, x in regression.recording.columns.items()}),
                                     joint) for regression in read.regressions]  # fmt: skip
        return stacked(joint_rows(model, [regression.rows() for regression in changed], joint))
    except talus.TalusError:  # the drive cannot stand there
        return None


def angle_columns(model, joint):
    """The columns that tell a joint's motion."""
    name = model.joints[joint]
    return {f"{name}_motor_rad", f"{name}_rad", f"{name}_velocity_rad_s", f"{name}_m"}


def _column(model, joint, explanation):
    name = model.joints[joint]
    if explanation.angle != 1.0:
        return f"{name}_motor_rad" if len(model.joints) > 1 else f"{name}_rad"
    return f"{name}_current_A"


def _gear(model, joint):
    """The drive's ratio at angle 0."""
    ratio, slope = ffi.new("double *"), ffi.new("double *")
    lib.tl_transmission_ratio(ffi.addressof(model.struct.drive[joint], "transmission"), 0.0, ratio, slope)
    return abs(ratio[0])


def _unsigned(name, rows, left):
    """A torque that is never negative, where the model's must be: with the model's sign it fits twice as well."""
    ringing = RINGING * np.sqrt(np.mean(rows.measured**2))  # of the low-pass at a corner
    if np.mean(rows.measured < -ringing) > NEVER_NEGATIVE:
        return None
    expected = rows.known + rows.x @ rows.prior
    for _ in range(3):
        if np.mean(expected < 0) < NEGATIVE_SHARE:
            return None
        signed = Rows(rows.x, rows.measured * np.sign(expected), rows.known, rows.prior)
        found, signed_left = fitted(signed)
        expected = rows.known + rows.x @ found
    if signed_left < 0.5 * left:
        return Finding("unsigned", True, f"{name}_current_A", f"the {name}'s torque is never negative, and with the model's sign "
                       f"{100 * signed_left:.0f} % instead of {100 * left:.0f} % of it remain unexplained",
                       "record the current with its sign")  # fmt: skip
    return None


def _other_machine(name, names, every, files):
    """Recordings that one set of parameters cannot serve, though each by itself is well served. Both are fitted together: what
    slow ramps do not tell, an inertia above all, they do not speak against. Two stretches of one of the `files` are of one machine: where
    they differ, it has changed, and that is a cause to be found."""
    fits = [(k, rows, fitted(rows)[1]) for k, rows in enumerate(every) if rows is not None]
    for i, rows, left in fits:
        for k, others, others_left in fits[:i]:
            if files[i] is not None and files[i] == files[k]:
                continue
            together = left_together([rows, others], [left, others_left])
            excess = [t - OTHER_RESIDUAL * own for t, own in zip(together, (left, others_left))]
            if max(excess) > OTHER_SHARE:
                worst = int(np.argmax(excess))
                yield Finding("other_machine", True, "", f"no one set of {name} parameters serves {names[k]} and {names[i]}: together they "
                              f"leave {100 * together[worst]:.0f} % of the torque unexplained in {names[(i, k)[worst]]}, which by itself "
                              f"leaves {100 * (left, others_left)[worst]:.0f} %", "diagnose recordings of one machine, unchanged, at a time")  # fmt: skip
                return


def left_together(recordings, left):
    """What one set of parameters leaves of each recording's torque (RMS share). A row weighs by what its recording leaves by
    itself and by how many rows there are, so that neither a long nor a noisy recording decides alone."""
    weights = [1 / ((own + HARDLY) * np.sqrt(np.sum(rows.measured**2))) for rows, own in zip(recordings, left)]
    x = np.vstack([w * rows.x for w, rows in zip(weights, recordings)])
    size = np.sqrt(np.mean(x**2, axis=0)) + 1e-300
    target = np.concatenate([w * (rows.measured - rows.known) for w, rows in zip(weights, recordings)])
    found = np.linalg.lstsq(x / size, target, rcond=1e-10)[0] / size
    return [float(np.sqrt(np.mean((rows.measured - rows.known - rows.x @ found) ** 2) / np.mean(rows.measured**2)))
            for rows in recordings]  # fmt: skip
