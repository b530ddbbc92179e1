"""A candidate: one effect at one joint with one shape, as columns that are linear in its strengths."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from talus import ffi, lib, pointer


LEAST_HALF_RANGE_RAD = 0.05
TWIST_BELOW_RAD = math.pi  # half the range: beyond, a joint has turned, whatever its torque
LEFT_BY_TWIST = 0.2  # of the angle's variance, that a held joint's torque does not explain
TWIST_POWERS = 3
LEAST_WAY = 0.05  # of the squared load, that must be driven, and as much that must drive
COLUMN_PENALTY = 0.35  # of the logarithm, for each further column
UNUSUAL_WIDTH = 0.5  # of the logarithm of a size beyond what is usual


def usual(size, low, high):
    """Likelihood of an effect's size that usually lies between `low` and `high`."""
    beyond = max(math.log(low / max(size, 1e-12)), math.log(max(size, 1e-12) / high), 0.0)
    return math.exp(-0.5 * (beyond / UNUSUAL_WIDTH) ** 2)


@dataclass(frozen=True)
class Family:
    """Candidates of one form, `make(*values)`: the grid's values can be moved between its points. A step above 1 is a
    factor, one below 1 a difference. Shapes of another `start` are so far away that no way leads to them."""

    make: Callable
    values: tuple
    steps: tuple
    low: tuple
    high: tuple
    together: tuple = ()  # ((value, part of its step), ...) of values that are moved together, too
    start: str = ""

    @property
    def directions(self):
        """What can be moved: each value by its step, and those that go together."""
        return [((number, 1.0),) for number in range(len(self.values))] + list(self.together)

    def beside(self, number, share, side):
        """The candidate moved by a share of the steps in one direction; None beyond the limits."""
        values = list(self.values)
        for k, part in self.directions[number]:
            by, step = side * share * part, self.steps[k]
            values[k] = values[k] * step**by if step > 1 else values[k] + by * step
            if not self.low[k] <= values[k] <= self.high[k]:
                return None
        return self.make(*map(float, values))


@dataclass(frozen=True, eq=False)
class Candidate:
    """`columns` are functions of a scene that return {channel kind: column on the grid}; `low` and `high` the
    physical range of each strength; `parameters(strengths)` the figures that a reader understands, and
    `saved(strengths)` the parameters of the model file's effect of that name, whose law the columns are."""

    effect: str
    joint: str
    shape: str
    columns: tuple
    parameters: Callable
    low: tuple | None = None
    high: tuple | None = None
    saved: Callable | None = None  # where they differ from `parameters`
    family: Family | None = None
    parts: tuple = ()
    prior: Callable | None = None  # how likely these strengths are before the data, to others; 1 where it is None

    def weight(self, strengths):
        """How likely the form is before the data, relative to others: a simpler one is a little likelier."""
        own = self.prior(strengths) if self.prior else 1.0
        return own * math.exp(-COLUMN_PENALTY * (len(self.columns) - 1))

    def within_range(self, strengths):
        low = self.low is None or all(x >= limit for x, limit in zip(strengths, self.low))
        return low and (self.high is None or all(x <= limit for x, limit in zip(strengths, self.high)))

    def pieces(self, strengths):
        """(candidate, its strengths) of each that this one is made of."""
        if not self.parts:
            return [(self, list(strengths))]
        out, begin = [], 0
        for part in self.parts:
            out.append((part, list(strengths[begin:begin + len(part.columns)])))
            begin += len(part.columns)
        return out

    def entry(self, strengths):
        """Parameters of the model file's effect; what is not named there is 0 or left out."""
        return {name: float(x) for name, x in (self.saved or self.parameters)(strengths).items()}

    @property
    def key(self):
        return self.effect, self.joint


def joined(first, second):
    """Two shapes of one effect at one joint that act together: two orders, two modes."""

    def parameters(strengths):
        out = {}
        for number, (part, own) in enumerate(whole.pieces(strengths)):
            out |= {name + (f"_{number + 1}" if number else ""): x for name, x in part.parameters(own).items()}
        return out

    def limits(name, default):
        return sum((getattr(c, name) or (default,) * len(c.columns) for c in (first, second)), ())

    whole = Candidate(first.effect, first.joint, f"{first.shape} and {second.shape}", first.columns + second.columns,
                      parameters, limits("low", -math.inf), limits("high", math.inf),
                      parts=(*(first.parts or (first,)), second))  # fmt: skip
    return whole


def drive_excess(chosen, every):
    """What the drive gives beyond current times constant, by the strengths of the chosen effects."""
    return sum(float(own[0]) for c, own in zip(chosen, every) if c.effect == "torque_constant")


@dataclass(frozen=True)
class Place:
    """A joint that effects are tried at."""

    number: int
    name: str
    evidence: object
    extent: object
    scenes: list

    @property
    def kinds(self):
        return self.evidence.kinds

    @property
    def coulomb_Nm(self):
        return max(abs(self.scenes[0].coulomb_Nm[self.number]), 1e-12)

    @property
    def sign(self):
        """With a sensor at the output, what a joint takes is missing from the reading."""
        return -1.0 if self.evidence.load_sensor else 1.0

    @property
    def gear(self):
        """Motor turns for one of the joint where torques and angles are the joint's; else 1."""
        if self.evidence.model.plant != "pendulum":
            return 1.0
        return float(self.evidence.tree["joint"].get("transmission", {}).get("ratio", 1.0))

    @cached_property
    def motor_range(self):
        """Range of the motor's angle over all recordings but for its extremes [rad]; 0 where only its torque twists it."""
        if self.is_held:
            return 0.0
        ends = [np.quantile(scene.motor_rad[self.number][scene.track.inside], (0.02, 0.98)) for scene in self.scenes]
        return abs(self.gear) * (max(high for _, high in ends) - min(low for low, _ in ends))

    @property
    def travels(self):
        """Does the joint turn far enough for position to be told from load?"""
        if self.evidence.model.plant == "slider":
            return True
        return self.extent.half_range[self.number] > LEAST_HALF_RANGE_RAD and not self.is_held

    @cached_property
    def carries_both_ways(self):
        """Does the drive both drive its load and hold it back? Where it only drives, friction that grows with the load is
        a share of the drive's torque, that a constant or a droop beside a sensor could be as well."""
        if not self.evidence.load_sensor:
            return True
        j, shares = self.number, np.zeros(2)
        for scene in self.scenes:
            power = (scene.drive_Nm[j] * scene.slip[j])[scene.track.inside]
            shares += [np.sum(power[power > 0] ** 2), np.sum(power[power < 0] ** 2)]
        return bool(shares.min() >= LEAST_WAY * shares.sum())

    @cached_property
    def is_held(self):
        """Is the output held, beside its torque sensor, so that its angle is the twist under the torque?"""
        j = self.number
        if not self.evidence.load_sensor or self.extent.half_range[j] > TWIST_BELOW_RAD:
            return False
        left = whole = 0.0
        for scene in self.scenes:
            q, drive = scene.q[j][scene.track.inside], scene.drive_Nm[j][scene.track.inside]
            powers = (drive / (np.abs(drive).max() + 1e-12))[:, None] ** np.arange(TWIST_POWERS + 1)
            twist = powers @ np.linalg.lstsq(powers, q, rcond=None)[0]
            left, whole = left + np.sum((q - twist) ** 2), whole + np.sum((q - q.mean()) ** 2)
        return left < LEFT_BY_TWIST * whole

    def joint_column(self, function):
        """A column from a torque at the joint."""
        j, sign = self.number, self.sign
        return lambda scene: {f"T{j}": scene.track.operate(sign * function(scene) / scene.ratio[j], j)}

    def motor_column(self, function):
        """A column from a torque at the motor."""
        j, sign = self.number, self.sign
        return lambda scene: {f"T{j}": scene.track.operate(sign * function(scene), j)}

    def reading_column(self, function):
        """A column of the reading itself."""
        j = self.number
        return lambda scene: {f"T{j}": scene.track.operate(function(scene), j)}


def named(*names, **constants):
    """Parameters by name: the strengths under `names`, then constants (shapes)."""
    return lambda strengths: {**dict(zip(names, map(float, strengths))), **constants}


def library_column(effect, joint, number, shapes):
    """A column of the library's own law along each scene; `shapes` by name, in the order of the table."""
    kind, shape = lib.tl_effect_find(effect.encode()), np.array(list(shapes.values()))

    def column(scene):
        found = scene.latest((effect, joint, *shapes.values()), lambda: _along(scene, kind, joint, shape))
        return {kind: values[number] for kind, values in found.items()}

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
