"""Columns that do not belong to the model's machine as they stand: units, signs, the motor's angle for the joint's, unsigned
currents, recordings of different machines.

What the plain model needs of each recording (its regressor's rows, joint by joint) is fitted by least squares, and its torque
terms are compared with those of the model file: inertia, gravity and friction that are a hundred times too small do not
come from a wrong drawing. An explanation is named only if it makes all terms plausible that were not so. What the motion does
not tell apart, as a constant torque and gravity over a small angle, stays where the model file has it.
"""

import copy
from dataclasses import dataclass, replace

import numpy as np

import talus
from talus import ffi, lib
from talus.recording import score_of

from .finding import Finding
from .samples import shows

FAR, NEAR = np.log(3.5), np.log(2.2)  # of a torque term, from the model file's: out of the question, and plausible
ANY = 1.0  # of the measured torque: so large may be what the model file has as 0, which is no drawing's
FAR_OF_ALL = np.log(10)  # the same of the whole torque: nearer to a thousand than to anything else that is mistaken
HARDLY = 0.05  # of the measured torque: smaller terms tell nothing
SLOW_HZ = 8.0  # low-pass: below it lies most of any motion, and a unit shows as well as in all of it
FEWEST_ROWS = 200
MOST_SAMPLES = 60_000  # of a recording: a wrong unit shows in a minute as in an hour
BEARS = 0.2  # of the measured torque: so large a term of the model file's tells a unit
DOUBTFUL = np.log(2.0)  # off by so much, a term is named only where an explanation takes as much away
UNEXPLAINED = 0.4  # of the torque: what leaves more is no explanation, but an effect that no unit makes good
WORSE_FIT, WORSE_BY = 1.5, 0.1  # of the residual and of the torque, that an explanation may leave more: other rows stand still
OTHER_RESIDUAL, OTHER_SHARE = 2.0, 0.15  # times what each leaves by itself, and of the torque beside it: one machine, changed by an effect
NEVER_NEGATIVE, NOISE_AT_0, NEGATIVE_SHARE = 1e-3, 0.05, 0.15
ALIKE = 0.1  # of the residual's power, by which a fit nearer to the model file may be worse: rows near each other leave the same
BRAKES = 0.1  # correlation of torque and speed, by which a drive takes more power out of a motion than the other joints put into it
SIGN_ROUNDS = 6
STILL, BOUNDED = ("coulomb", "offset"), ("moment", "gravity_sin", "gravity_cos")  # torques that do not grow with the motion, or not for long
DEGREES, TURNS, MILLI = np.pi / 180, 2 * np.pi, 1e-3


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
    names: tuple  # of the columns

    @property
    def speed(self):
        return self.x[:, self.ending("viscous")[0]]

    @property
    def power_W(self):
        """What the drive puts into the motion, on the average."""
        return float(np.mean(self.measured * self.speed))

    def friction(self, found):
        """The torque of friction, by these base parameters."""
        own = self.ending("coulomb", "viscous")
        return self.x[:, own] @ found[own]

    def ending(self, *words, without=False):
        """The columns whose names end with some words, or with none of them."""
        return [k for k, name in enumerate(self.names) if name.endswith(words) != without]


@dataclass(frozen=True)
class Columns:
    """The names of a joint's columns, as they were recorded: of its angle (or its speed), its torque, and of all that tell its motion."""

    angle: str
    torque: str
    motion: tuple

    @property
    def angle_is_told_twice(self):
        """By a speed as well: it is of another unit than its name says only if the speed is, too."""
        return len(self.motion) > 1

    @staticmethod
    def of(joint, recordings):
        every = {column for recording in recordings for column in recording.columns}
        motion = [name for name in (f"{joint}_motor_rad", f"{joint}_rad", f"{joint}_m", f"{joint}_velocity_rad_s") if name in every]
        torque = [name for name in (f"{joint}_torque_Nm", f"{joint}_current_A", f"{joint}_force_N") if name in every]
        return Columns((motion or [""])[0], (torque or [""])[0], tuple(motion))


def explanations(gear, columns):
    """What columns are mistaken for."""
    if columns.angle.endswith("_m"):
        yield Explanation("units", "its position were in mm", "convert the position to m", MILLI)
    else:
        yield Explanation("units", "its angle were in degrees", "convert the angle to rad", DEGREES)
        yield Explanation("units", "its angle were in turns", "convert the angle to rad", TURNS)
    what, unit = ("current", "A") if columns.torque.endswith("_A") else ("torque", "Nm") if columns.torque.endswith("_Nm") else ("force", "N")
    yield Explanation("units", f"its {what} were in m{unit}", f"convert the {what} to {unit}", 1.0, MILLI)
    yield Explanation("sign", f"its {what} or its motion counted the other way", f"turn the sign of the {what} or of the motion", 1.0, -1.0)
    if gear > 1.5:
        if columns.angle.endswith("_motor_rad"):
            yield Explanation("ratio", "its angle were on the other side of the gear: the joint's where the motor's belongs",
                              "multiply the angle by the ratio", gear)  # fmt: skip
        else:
            yield Explanation("ratio", "its angle were on the other side of the gear: the motor's where the joint's belongs",
                              "divide the angle by the ratio", 1 / gear)  # fmt: skip
        yield Explanation("ratio", "its torque were on the other side of the gear", "give the torque on the side that the column names",
                          1.0, gear)  # fmt: skip


def joint_rows(model, recordings, joint):
    """Rows of a joint in each recording; None where there are too few."""
    out, prior, names = [], np.array(list(model.base.values())), list(model.base)
    for recording in recordings:
        angle = recording.columns.get(Columns.of(model.joints[joint], [recording]).angle)
        if angle is None or not shows(angle):
            out.append(None)
            continue
        parts = _slowly(model, recording.head(MOST_SAMPLES)).rows()[joint]
        kept = [part for part in parts if np.any(part.kind == lib.TL_ROW_SCORED)]
        if sum(int(np.sum(part.kind == lib.TL_ROW_SCORED)) for part in kept) < FEWEST_ROWS:
            out.append(None)
            continue
        rows = [part.kind == lib.TL_ROW_SCORED for part in kept]
        x, measured, target = (np.concatenate([getattr(part, name)[r] for part, r in zip(kept, rows)])
                               for name in ("x", "measured", "target"))  # fmt: skip
        out.append(Rows(x, measured, measured - target, prior[kept[0].index], tuple(names[k] for k in kept[0].index)))
    return out


def _slowly(model, recording):
    """A recording's regression through a low-pass so slow that a coarse encoder leaves its inertia, too."""
    slow = copy.copy(recording)
    slow.score = ffi.new("tl_score_settings *", score_of(model, recording)[0])
    own_hz = slow.score.lowpass_hz
    slow.score.lowpass_hz = min(own_hz, SLOW_HZ)
    return talus.Regression(model, slow)


def stacked(rows):
    """Rows of several recordings as one; None where there are none."""
    rows = [r for r in rows if r is not None]
    if not rows:
        return None
    out = Rows(*(np.concatenate([getattr(r, n) for r in rows]) for n in ("x", "measured", "known")), rows[0].prior, rows[0].names)
    return out if np.isfinite(out.x).all() and np.isfinite(out.known).all() else None  # no linkage stands there


def fitted(rows, torque=1.0):
    """Least squares: base parameters, and the residual over the measured torque (RMS)."""
    size = np.sqrt(np.mean(rows.x**2, axis=0)) + 1e-300
    found = np.linalg.lstsq(rows.x / size, torque * rows.measured - rows.known, rcond=1e-10)[0] / size
    return found, leaves(rows, found, torque)


def leaves(rows, found, torque=1.0):
    """What these base parameters leave of the measured torque (RMS)."""
    scale = np.sqrt(np.mean(rows.measured**2)) * abs(torque) + 1e-300
    return float(np.sqrt(np.mean((torque * rows.measured - rows.known - rows.x @ found) ** 2)) / scale)


def near_prior(rows, torque=1.0):
    """Base parameters that fit about as well as the best, and are as near to the model file's as that allows. Each term counts
    by its torque, and how far it is off by the model file's or by its own, whichever is larger."""
    size = np.sqrt(np.mean(rows.x**2, axis=0)) + 1e-300
    scale = np.sqrt(np.mean(rows.measured**2)) * abs(torque) + 1e-300
    left = fitted(rows, torque)[1] + HARDLY
    given = rows.prior * size / scale
    target = (torque * rows.measured - rows.known) / scale
    gram, moment = (rows.x / size).T @ (rows.x / size) / len(target), (rows.x / size).T @ target / len(target)
    own = np.linalg.solve(gram + ALIKE * left**2 * np.eye(len(given)), moment)
    pull = np.sqrt(ALIKE) * left / np.where(given != 0, np.maximum(np.abs(given), np.abs(own)) + HARDLY, ANY)
    return np.linalg.solve(gram + np.diag(pull**2), moment + pull**2 * given) * scale / size


def distance(rows, found, torque=1.0):
    """The largest logarithm by which a torque term differs from the model file's; a term that works the other way counts as
    far. Terms that hardly bear on the torque do not count."""
    size = np.sqrt(np.mean(rows.x**2, axis=0))
    scale = np.sqrt(np.mean(rows.measured**2)) * abs(torque)
    own, given = found * size, rows.prior * size
    logs = np.abs(np.log((np.abs(own) + HARDLY * scale) / (np.abs(given) + HARDLY * scale)))
    against = (own * np.sign(given) < -BEARS * scale) & (given != 0)
    beyond = np.log(np.maximum(np.abs(own) / (ANY * scale), 1.0))
    return float(np.max(np.where(against, 2 * FAR, np.where(given == 0, beyond, logs))))


def joint_findings(model, names, recordings, joint):
    """What is wrong with a joint's angle or torque."""
    name, every = model.joints[joint], joint_rows(model, recordings, joint)
    rows = stacked(every)
    if rows is None:
        return
    columns, files = Columns.of(name, recordings), [recording.origin.path for recording in recordings]
    other = list(_other_machine(name, names, every, files))
    unsigned = all(never_negative(r.columns[columns.torque]) for r in recordings if columns.torque in r.columns)
    found = (_unsigned(name, columns, rows) if unsigned else None) or _mistaken(model, names, recordings, joint, columns, every, bool(other))
    yield from [found] if found else other


def _mistaken(model, names, recordings, joint, columns, every, several):
    """The finding that an explanation gives; of recordings that are of `several` machines as they stand, one that makes them one."""
    rows = stacked(every)
    far, left = distance(rows, near_prior(rows)), fitted(rows)[1]
    if far <= DOUBTFUL:
        return None
    tried = [one for one in _tried(model, recordings, joint, columns, every) if one.left < WORSE_FIT * left + WORSE_BY and _can_be(rows, one)]
    best = _best([one for one in tried if one.left < UNEXPLAINED])
    if best is None and far > FAR:
        fed_W = _fed_W(model, recordings, joint)
        best = next((one for one in tried if _impossible(rows, left, one.explanation, fed_W)), None)
    if best is None or (far <= FAR and (best.distance > far - DOUBTFUL or (best.explanation.angle != 1.0 and columns.angle_is_told_twice))):
        return None
    name, why = model.joints[joint], best.explanation
    if several and list(_other_machine(name, names, best.every, [recording.origin.path for recording in recordings])):
        return None
    return Finding(why.id, True, columns.angle if why.angle != 1.0 else columns.torque, f"the {name}'s torque terms are up to "
                   f"{np.exp(far):.0f} times off those of the model file, as if {why.words}", why.remedy)  # fmt: skip


def _can_be(rows, one):
    """Could it be, whatever the model file's terms? A sign that were wrong would have friction drive the joint as it stands. Where
    another unit of the angle makes all that grows with the motion small, any terms are plausible: then these must be out of the
    question as they stand."""
    if one.explanation.torque < 0:
        return np.mean(rows.friction(fitted(rows)[0]) * rows.speed) < HARDLY * rms(rows.measured) * rms(rows.speed)
    if one.explanation.angle >= 1.0:
        return True
    return grown(stacked(one.every), *STILL) > BEARS or grown(rows, *STILL, *BOUNDED) > np.exp(FAR)


def grown(rows, *but):
    """The largest of the model file's torques that grow with the motion (all but these), over the measured one."""
    grows = rows.ending(*but, without=True)
    return np.max(np.sqrt(np.mean(rows.x[:, grows] ** 2, axis=0)) * np.abs(rows.prior[grows])) / rms(rows.measured)


def rms(x):
    return np.sqrt(np.mean(x**2))


def _best(tried):
    """Of explanations that make all terms plausible the nearest one, of those that leave about the least."""
    near = [one for one in tried if one.distance < NEAR]
    least = min((one.left for one in near), default=0.0)
    return min((one for one in near if one.left < WORSE_FIT * least + HARDLY), key=lambda one: one.distance, default=None)


def _fed_W(model, recordings, joint):
    """What the other joints' drives put into the motion, on the average: this one may brake that."""
    others = (stacked(joint_rows(model, recordings, k)) for k in range(len(model.joints)) if k != joint)
    return sum(rows.power_W for rows in others if rows is not None)


def _impossible(rows, left, why, fed_W):
    """Is it out of the question without this explanation, whatever the model file's terms: a drive that brakes on the whole, or a
    torque that only another unit makes?"""
    if why.id == "sign":
        return left < UNEXPLAINED and rows.power_W < -BRAKES * rms(rows.measured) * rms(rows.speed) - max(fed_W, 0.0)
    expected, measured = (np.sqrt(np.mean(x**2)) for x in (rows.known + rows.x @ rows.prior, rows.measured))
    return why.torque == MILLI and abs(np.log(MILLI * measured / (expected + 1e-300))) < FAR_OF_ALL


@dataclass
class Tried:
    """An explanation with the rows of each recording that it makes, how far their terms are off, and what they leave."""

    explanation: Explanation
    every: list
    distance: float
    left: float


def _tried(model, recordings, joint, columns, every):
    """What each explanation makes of the rows of each recording."""
    for why in explanations(_gear(model, joint), columns):
        changed = every if why.angle == 1.0 else _at_angle(model, recordings, joint, columns, why.angle)
        rows = stacked(changed)
        if rows is not None:
            found = near_prior(rows, why.torque)
            yield Tried(why, changed, distance(rows, found, why.torque), leaves(rows, found, why.torque))


def _at_angle(model, recordings, joint, columns, factor):
    """Rows of a joint in each recording whose angle columns are multiplied."""
    changed = [talus.Recording({n: factor * x if n in columns.motion else x for n, x in r.head(MOST_SAMPLES).columns.items()})
               for r in recordings]  # fmt: skip
    try:
        return joint_rows(model, changed, joint)
    except talus.TalusError:  # the drive cannot stand there
        return []


def _gear(model, joint):
    """The drive's ratio at angle 0."""
    ratio, slope = ffi.new("double *"), ffi.new("double *")
    lib.tl_transmission_ratio(ffi.addressof(model.struct.drive[joint], "transmission"), 0.0, ratio, slope)
    return abs(ratio[0])


def never_negative(x):
    """Is a column never below 0, by more than its noise about 0?"""
    return np.mean(x < -NOISE_AT_0 * np.sqrt(np.mean(x**2))) <= NEVER_NEGATIVE


def _unsigned(name, columns, rows):
    """A torque that is never negative, where the model's must be: with the model's sign it fits twice as well."""
    left = fitted(rows)[1]
    # friction's sign is known where gravity's is not
    signed_left = min(_signed_left(rows, expected) for expected in (rows.known + rows.x @ rows.prior, rows.speed))
    if signed_left < 0.5 * left:
        return Finding("unsigned", True, columns.torque, f"the {name}'s torque is never negative, and with the model's sign "
                       f"{100 * signed_left:.0f} % instead of {100 * left:.0f} % of it remain unexplained",
                       "record the current with its sign")  # fmt: skip
    return None


def _signed_left(rows, expected):
    """What is left of the torque with the sign of what is expected, and then of what was so found."""
    left = np.inf
    for _ in range(SIGN_ROUNDS):
        if min(np.mean(expected < 0), np.mean(expected > 0)) < NEGATIVE_SHARE:
            return np.inf
        found, left = fitted(replace(rows, measured=rows.measured * np.sign(expected)))
        expected = rows.known + rows.x @ found
    return left


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
