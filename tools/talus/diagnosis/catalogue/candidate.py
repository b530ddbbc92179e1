"""A candidate: one effect at one joint with one shape, as columns that are linear in its strengths."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

COLUMN_PENALTY = 0.35  # of the logarithm, for each further column
AT_LIMIT = 0.01  # of a step: nearer to a limit than this, a value stands there
UNUSUAL_WIDTH = 0.5  # of the logarithm of a size beyond what is usual
BESIDE_A_SENSOR = 0.3  # prior of what a wrong constant, or the sensor's zero, is likelier to be


def usual(size, low, high):
    """Likelihood of an effect's size that usually lies between `low` and `high`."""
    size = max(size, 1e-12)
    beyond = max(math.log(low / size) if low > 0 else 0.0, math.log(size / high), 0.0)
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
    rough: bool = False  # many local minima: looked for from several of the grid's shapes
    elsewhere: tuple = ()  # ((factor of each value, ...), ...): looked for from the grid's values times these, too

    @property
    def directions(self):
        """What can be moved: each value by its step, and those that go together."""
        return [((number, 1.0),) for number in range(len(self.values))] + list(self.together)

    def beside(self, number, share, side):
        """The candidate moved by a share of the steps in one direction; None beyond the limits."""
        values = list(self.values)
        for k, part in self.directions[number]:
            values[k] = self._moved(k, side * share * part)
            if not self.low[k] <= values[k] <= self.high[k]:
                return None
        return self.make(*map(float, values))

    def moved(self, shares):
        """The candidate with each value moved by a share of its step, at the most to its limit, and there from close by: a
        spring that hardens by next to nothing is a straight one."""
        by = np.array([self._moved(k, share) for k, share in enumerate(shares)])
        near = np.array([0.0 if step > 1 else AT_LIMIT * step for step in self.steps])
        at_low, at_high = by - near < self.low, by + near > self.high
        return self.make(*map(float, np.where(at_low, self.low, np.where(at_high, self.high, by))))

    def _moved(self, k, share):
        """A value moved by a share of its step."""
        x, step = self.values[k], self.steps[k]
        return x * step**share if step > 1 else x + share * step


@dataclass(frozen=True, eq=False)
class Candidate:
    """`columns` are functions of a recording's torque terms that return {channel kind: column on the grid}; `low` and `high` the
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
    begin_low: tuple | None = None  # lower limits of a shape from which a better one is looked for
    prior: Callable | None = None  # how likely these strengths are before the data, to others; 1 where it is None
    phases_rad: tuple = ()  # of a ripple's orders: what each goes through over the recordings' range

    def weight(self, strengths):
        """How likely the form is before the data, relative to others: a simpler one is a little likelier."""
        own = self.prior(strengths) if self.prior else 1.0
        return own * math.exp(-COLUMN_PENALTY * (len(self.columns) - 1))

    def within_range(self, strengths, looking=False):
        lowest = self.begin_low if looking and self.begin_low else self.low
        low = lowest is None or all(x >= limit for x, limit in zip(strengths, lowest))
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
                      parameters, limits("low", -math.inf), limits("high", math.inf), family=_both(first.family, second.family),
                      parts=(*(first.parts or (first,)), second))  # fmt: skip
    return whole


def _both(one, other):
    """The shapes of two candidates that act together, moved between the grid's points; None where one cannot be."""
    if not (one and other):
        return None
    count = len(one.values)
    make = lambda *values: joined(one.make(*values[:count]), other.make(*values[count:]))
    return Family(make, one.values + other.values, one.steps + other.steps, one.low + other.low, one.high + other.high)


def named(*names, **constants):
    """Parameters by name: the strengths under `names`, then constants (shapes)."""
    return lambda strengths: {**dict(zip(names, map(float, strengths))), **constants}
