"""Recordings spoiled as users' are. A kind takes a sound `Bench` and a generator of numbers and gives a `Spoiled`: the recordings with
one fault, the finding that must name it, and the column. It gives None where this bench cannot have the fault, or where nothing
could tell it: that is decided here, by the sound recordings and the model file, and never by asking the gate."""

from dataclasses import dataclass, field, replace

import numpy as np
import talus

LEAST_FACTOR = 5.0  # of an angle or a torque: what is less off may be a drawing that is wrong
AMBIGUOUS = 1.5  # two mistakes whose factors are nearer than that look alike beside a drawing's errors
LEAST_SHARE = 0.2  # of rows and size of a current, that both of its signs must have
LARGEST_STEP = 0.2  # of the range, from row to row: what leaps by itself hides a fault that leaps
TOGETHER = 0.9  # correlation of two columns that show one thing
LEAST_STEPS = 60  # of an encoder over the motion: a coarse one shows nothing of what is asked here
DEGREES, TURNS = 180 / np.pi, 1 / (2 * np.pi)


@dataclass(frozen=True)
class Joint:
    """One joint's columns: of the angle (None where only its speed was recorded), of current, torque or force, of a speed and of a
    second encoder behind the drive. `gear` is the drive's ratio in the middle of the motion."""

    name: str
    angle: str | None
    effort: str
    velocity: str | None
    behind: str | None
    gear: float


@dataclass
class Bench:
    """Sound recordings, as columns, with a model as a user would have it. `files` are the recordings' files: stretches of one share it."""

    name: str
    plant: str
    model: object
    recordings: list
    files: list = field(default_factory=list)

    def __post_init__(self):
        self.files = self.files or [f"{k}.csv" for k in range(len(self.recordings))]

    @property
    def joints(self):
        return [joint_of(self.model, name, self.recordings[0]) for name in self.model.joints]

    @property
    def load_sensor(self):
        return any("joint_load_Nm" in columns for columns in self.recordings)

    def objects(self):
        """(names, talus.Recordings)."""
        out = [talus.Recording(columns) for columns in self.recordings]
        for recording, file in zip(out, self.files, strict=True):
            recording.origin = talus.recording.Origin(file, recording.t[0], recording.t[-1] - recording.t[0])
        return [f"{file}, {r.t[0]:.0f} to {r.t[-1]:.0f} s" for file, r in zip(self.files, out)], out


@dataclass
class Spoiled:
    """`column` "" where the finding is about no single one."""

    bench: Bench
    finding: str
    column: str


def joint_of(model, name, columns):
    """A joint with those of its columns that were recorded."""
    first = lambda *names: next((n for n in names if n in columns), None)  # noqa: E731
    angle = first(f"{name}_motor_rad", f"{name}_rad", f"{name}_m")
    return Joint(name, angle, first(f"{name}_torque_Nm", f"{name}_current_A", f"{name}_force_N"), first(f"{name}_velocity_rad_s"),
                 first(f"{name}_joint_rad"), gear_of(model, model.joints.index(name)))  # fmt: skip


def gear_of(model, joint):
    """Motor angle over joint angle at rest."""
    ratio, slope = talus.ffi.new("double *"), talus.ffi.new("double *")
    talus.lib.tl_transmission_ratio(talus.ffi.addressof(model.struct.drive[joint], "transmission"), 0.0, ratio, slope)
    return abs(ratio[0])


# ---- what several kinds do ------------------------------------------------------------


def of(rng, some):
    """One of some, or None of none."""
    return some[int(rng.integers(len(some)))] if some else None


def everywhere(bench, column, change, finding, shown=None):
    """A column changed in all recordings that have it, `change(values)`."""
    changed = [{**c, column: change(c[column])} if column in c else c for c in bench.recordings]
    return Spoiled(replace(bench, recordings=changed), finding, shown or column)


def scaled(bench, column, factor, finding):
    return everywhere(bench, column, lambda x: factor * x, finding)


def once(bench, rng, column, change, finding):
    """A column changed in one recording, `change(columns)` gives its values; None where it gives none."""
    k = int(rng.integers(len(bench.recordings)))
    values = change(bench.recordings[k])
    if values is None:
        return None
    changed = list(bench.recordings)
    changed[k] = {**changed[k], column: values}
    return Spoiled(replace(bench, recordings=changed), finding, column)


def rows_of(bench, choose, finding, column="time_s"):
    """Every column of all recordings at the rows that `choose(columns)` gives."""
    taken = [{name: x[choose(c)] for name, x in c.items()} for c in bench.recordings]
    return Spoiled(replace(bench, recordings=taken), finding, column)


def step_s(columns):
    return float(np.median(np.diff(columns["time_s"])))


def length_s(columns):
    return float(columns["time_s"][-1] - columns["time_s"][0])


def span(x):
    """The range of most of a column."""
    return float(np.ptp(np.quantile(x, (0.005, 0.995))))


def encoder_step(x):
    """The smallest change that is seen; 0 of a column that never changes."""
    steps = np.abs(np.diff(x))
    return float(np.min(steps[steps > 1e-9 * np.ptp(x)], initial=np.inf)) if np.ptp(x) > 0 else 0.0


def fine(x):
    """Does a column have steps enough to show its motion?"""
    return span(x) > LEAST_STEPS * encoder_step(x) > 0


def smooth(x):
    """Does a column go its way in steps much smaller than that?"""
    return np.abs(np.diff(x)).max() < LARGEST_STEP * span(x)


def moving(bench, joint):
    """Does this joint's angle move in every recording, by what its encoder shows well, and not by leaps?"""
    return joint.angle and all(fine(c[joint.angle]) and smooth(c[joint.angle]) for c in bench.recordings)


def stretch(columns, rng, shortest_s, longest_s):
    """Rows of a stretch within a recording's middle, of so many seconds or a third of the recording."""
    n = len(columns["time_s"])
    rows = int(min(rng.uniform(shortest_s, longest_s) / step_s(columns), n // 3))
    begin = int(rng.integers(n // 10, max(n - n // 10 - rows, n // 10 + 1)))
    return slice(begin, begin + rows)


def inner_row(columns, rng):
    """A row away from the ends and from what is not valid, which no figure uses."""
    n, rows = len(columns["time_s"]), np.arange(len(columns["time_s"]))
    used = np.convolve(columns.get("valid", np.ones(n)), np.ones(5), "same") > 4.5
    return int(rng.choice(rows[used & (rows >= n // 8) & (rows < n - n // 8)]))


# ---- the time --------------------------------------------------------------------------


def milliseconds(bench, rng):
    return scaled(bench, "time_s", 1e3, "units")


def microseconds(bench, rng):
    return scaled(bench, "time_s", 1e6, "units")


def slow(bench, rng):
    """Each so many-th row, so that 4 to 30 Hz are left."""
    rate = np.exp(rng.uniform(np.log(4.0), np.log(30.0)))
    return rows_of(bench, lambda c: slice(None, None, int(np.ceil(1 / step_s(c) / rate))), "too_slow")


def lost(bench, rng):
    """Half of it and more is lost, in gaps of 0.2 to 2 s."""
    period_s, share = rng.uniform(0.4, 4.0), rng.uniform(0.5, 0.7)
    return rows_of(bench, lambda c: (c["time_s"] - c["time_s"][0]) % period_s > share * period_s, "dropouts")


def short(bench, rng):
    """One recording of 2 to 6 s."""
    columns, wanted = of(rng, bench.recordings), rng.uniform(2.0, 6.0)
    begin = columns["time_s"][inner_row(columns, rng)] - wanted / 2
    rows = (columns["time_s"] >= begin) & (columns["time_s"] < begin + wanted)
    taken = {n: x[rows] for n, x in columns.items()}
    return Spoiled(replace(bench, recordings=[taken], files=bench.files[:1]), "too_short", "time_s") if rows.sum() > 40 else None


def still(bench, rng):
    """The machine stands: angles show one value, sometimes the next one; currents their noise about what friction holds. Beside a
    sensor at the output a joint that stands says something, too."""
    if bench.load_sensor or not all(joint.angle for joint in bench.joints):
        return None
    return Spoiled(replace(bench, recordings=[stood(c, bench, rng) for c in bench.recordings]), "too_little_motion", "")


def stood(columns, bench, rng):
    out, n, seldom = dict(columns), len(columns["time_s"]), rng.uniform() < 0.5
    for name, x in columns.items():
        if name.endswith(("_rad", "_m")):
            flips = np.cumsum(rng.uniform(size=n) < step_s(columns)) % 2 if seldom else np.zeros(n)
            out[name] = x[n // 2] + min(encoder_step(x), 1e-3 * span(x)) * flips
        elif name.endswith("_rad_s"):
            out[name] = np.zeros(n)
    for joint in bench.joints:
        x = columns[joint.effort]
        out[joint.effort] = x[n // 2] + (x - np.convolve(x, np.full(5, 0.2), "same"))
    return out


def wandering_stamps(bench, rng):
    """Stamped when written, up to a step late."""
    size = rng.uniform(0.9, 1.0)
    return everywhere(bench, "time_s", lambda t: np.sort(t + size * np.median(np.diff(t)) * rng.uniform(0, 1, len(t))), "clock")


# ---- the angle ---------------------------------------------------------------------------


def is_alike(gear, factor):
    return 1 / AMBIGUOUS < gear / factor < AMBIGUOUS


def told_by_speed(bench, joint):
    """Does a speed's mean over a tenth of a second go with the angle's rate?"""
    return joint.velocity and joint.angle and all(speeds_agree(c, joint) for c in bench.recordings)


def speeds_agree(columns, joint):
    t, rows = columns["time_s"], max(1, round(0.1 / step_s(columns)))
    speed = np.convolve(columns[joint.velocity], np.full(rows, 1 / rows), "valid")[:len(t) - rows]
    rate = (columns[joint.angle][rows:] - columns[joint.angle][:-rows]) / (t[rows:] - t[:-rows])
    return np.corrcoef(speed, rate)[0, 1] > TOGETHER if span(speed) * span(rate) > 0 else False


def turning(bench, rng):
    """A joint that turns, whose angle shows its motion. Beside a sensor at the output only a speed tells in what unit."""
    return of(rng, [j for j in bench.joints if moving(bench, j) and j.angle.endswith("_rad")
                    and (not bench.load_sensor or told_by_speed(bench, j))])  # fmt: skip


def degrees(bench, rng):
    """Alike the motor's angle where the gear's ratio is near 57."""
    joint = turning(bench, rng)
    if joint is None or not (joint.angle.endswith("_motor_rad") or not is_alike(joint.gear, DEGREES)):
        return None
    return scaled(bench, joint.angle, DEGREES, "units")


def turns(bench, rng):
    joint = turning(bench, rng)
    return scaled(bench, joint.angle, TURNS, "units") if joint else None


def millimetres(bench, rng):
    joint = of(rng, [j for j in bench.joints if moving(bench, j) and j.angle.endswith("_m")])
    return scaled(bench, joint.angle, 1e3, "units") if joint else None


def other_side(bench, rng):
    """The joint's angle in the motor's column, or the motor's in the joint's, which is alike degrees where the ratio is near 57."""
    joint = turning(bench, rng)
    if joint is None or joint.gear < LEAST_FACTOR:
        return None
    if joint.angle.endswith("_motor_rad"):
        return scaled(bench, joint.angle, 1 / joint.gear, "ratio")
    alike = is_alike(joint.gear, DEGREES) or is_alike(joint.gear, 1 / TURNS)
    return None if alike else scaled(bench, joint.angle, joint.gear, "ratio")


def behind(bench, rng):
    return of(rng, [j for j in bench.joints if j.behind and moving(bench, j)])


def scaled_of(choose, column, factor, finding):
    """A kind that scales one column of a joint that `choose` finds."""

    def spoiled(bench, rng):
        joint = choose(bench, rng)
        return scaled(bench, getattr(joint, column), factor, finding) if joint else None

    return spoiled


def second_as_motor(bench, rng):
    """One angle in both columns."""
    joint = behind(bench, rng)
    if joint is None:
        return None
    return Spoiled(replace(bench, recordings=[{**c, joint.angle: c[joint.behind].copy()} for c in bench.recordings]), "ratio", joint.angle)


def another_ratio(bench, rng):
    """The drive between two encoders has another ratio than the model file's."""
    joint, factor = behind(bench, rng), float(rng.choice([0.4, 0.5, 0.7, 1.4, 2.0, 2.5]))
    return everywhere(bench, joint.behind, lambda x: factor * x, "ratio") if joint else None


def speedy(bench, rng):
    """A joint with a speed beside an angle that goes with it."""
    return of(rng, [j for j in bench.joints if moving(bench, j) and told_by_speed(bench, j)])


def wrapped(bench, rng):
    """Counted within a turn. Cannot be told where it moves by half a turn from row to row."""
    joint = of(rng, [j for j in bench.joints if moving(bench, j)])
    if joint is None:
        return None
    turn = 2 * np.pi if joint.angle.endswith("_rad") else float(rng.choice([0.005, 0.01, 0.02]))
    if any(np.abs(np.diff(c[joint.angle])).max() > 0.5 * turn for c in bench.recordings):
        return None
    at = np.quantile(bench.recordings[0][joint.angle], rng.uniform(0.2, 0.8))  # a motion that crosses the end of a turn
    return everywhere(bench, joint.angle, lambda x: np.mod(x - at, turn), "wrapped")


def spiked(bench, rng, where):
    """One row, or some, of one recording far outside of the motion; or at 0, where the motion is not."""
    joint = of(rng, [j for j in bench.joints if moving(bench, j)])
    if joint is None:
        return None

    def values(columns):
        x = columns[joint.angle].copy()
        rows = [inner_row(columns, rng) for _ in range(where)]
        x[rows] += rng.choice([-1, 1]) * rng.uniform(2.0, 100.0) * span(x)
        return x

    return once(bench, rng, joint.angle, values, "spike")


def one_spike(bench, rng):
    return spiked(bench, rng, 1)


def some_spikes(bench, rng):
    return spiked(bench, rng, int(rng.integers(3, 9)))


def stuck_angle(bench, rng):
    """Half a second to two in which the angle moves by a fifth of its range, and shows one value."""
    joint = of(rng, [j for j in bench.joints if moving(bench, j)])
    return once(bench, rng, joint.angle, lambda c: standing(c, joint.angle, rng), "stuck") if joint else None


def standing(columns, name, rng):
    x, rows = columns[name].copy(), int(rng.uniform(0.5, 2.0) / step_s(columns))
    n = len(x)
    begins = [k for k in range(n // 10, n - n // 10 - rows, max(1, rows // 4)) if abs(x[k + rows] - x[k]) > 0.2 * span(x)]
    begin = of(rng, begins)
    if begin is None:
        return None
    x[begin:begin + rows] = x[begin]
    return x


def few_steps(bench, rng):
    """An encoder of 8 to 25 steps over the whole motion."""
    joint = turning(bench, rng)
    if joint is None:
        return None
    step = max(np.ptp(c[joint.angle]) for c in bench.recordings) / rng.uniform(8, 25)
    return everywhere(bench, joint.angle, lambda x: np.round(x / step) * step, "coarse")


# ---- the current ------------------------------------------------------------------------


def effort(bench, rng):
    """A joint whose current, torque or force is not always the same."""
    return of(rng, [j for j in bench.joints if j.effort and all(span(c[j.effort]) > 0 for c in bench.recordings)])


def known_effort(bench, rng):
    """A joint of whose torque is known what it should be: by the model, or by the sensor at the output where the two go together."""
    joint = effort(bench, rng)
    if joint is None or not bench.load_sensor:
        return joint
    together = [np.corrcoef(c["joint_load_Nm"], c[joint.effort])[0, 1] > TOGETHER for c in bench.recordings]
    return joint if all(together) else None


def milliamperes(bench, rng):
    """Or mNm, or mN."""
    joint = known_effort(bench, rng)
    return scaled(bench, joint.effort, 1e3, "units") if joint else None


def other_sign(bench, rng):
    joint = known_effort(bench, rng)
    return scaled(bench, joint.effort, -1.0, "sign") if joint else None


def torque_other_side(bench, rng):
    """A torque column with the motor's torque in it."""
    joint = of(rng, [j for j in bench.joints if j.effort.endswith("_torque_Nm") and j.gear > LEAST_FACTOR])
    return scaled(bench, joint.effort, 1 / joint.gear, "ratio") if joint else None


def unsigned(bench, rng):
    """Cannot be told of a current that hardly changes its sign."""
    joint = known_effort(bench, rng)
    if joint is None or not all(two_signed(c[joint.effort]) for c in bench.recordings):
        return None
    return everywhere(bench, joint.effort, np.abs, "unsigned")


def two_signed(x):
    low = np.convolve(x, np.full(9, 1 / 9), "same")
    return min(np.mean(low > 0), np.mean(low < 0)) > LEAST_SHARE and min(low.max(), -low.min()) > LEAST_SHARE * np.abs(low).max()


def current_spikes(bench, rng):
    joint = effort(bench, rng)
    if joint is None:
        return None

    def values(columns):
        x = columns[joint.effort].copy()
        rows = [inner_row(columns, rng) for _ in range(int(rng.integers(2, 12)))]
        x[rows] += rng.choice([-1, 1]) * rng.uniform(2.0, 20.0) * span(x)
        return x

    return once(bench, rng, joint.effort, values, "spike")


def noisy(x):
    """Does a column hardly ever repeat a value? Of one that does nothing tells whether it was held."""
    return np.mean(np.diff(x) == 0) < 0.2


def stuck_current(bench, rng):
    """One value for 0.7 to 4 s, of a current that else changes from row to row."""
    joint = effort(bench, rng)

    def values(columns):
        x = columns[joint.effort].copy()
        rows = stretch(columns, rng, 0.7, 4.0)
        x[rows] = x[rows.start]
        return x if noisy(columns[joint.effort]) and x[rows.start] != 0.0 else None

    return once(bench, rng, joint.effort, values, "stuck") if joint else None


def constant_current(bench, rng):
    """Always one value; of a machine that is turned from outside, beside a sensor, it may be 0."""
    joint = effort(bench, rng)
    return everywhere(bench, joint.effort, lambda x: np.full_like(x, rng.choice([0.0, 1.25]) if not bench.load_sensor else 1.25), "stuck") if joint else None


def held_current(bench, rng):
    """Sampled three to six times more slowly than it is written."""
    joint, times = effort(bench, rng), int(rng.integers(3, 7))
    if joint is None or not all(noisy(c[joint.effort]) for c in bench.recordings):
        return None
    return everywhere(bench, joint.effort, lambda x: np.repeat(x[::times], times)[:len(x)], "stuck")


def limited(bench, rng):
    """A current at its limit for a third to two thirds of the rows, unless it is asked to be constant."""
    joint, share = effort(bench, rng), rng.uniform(0.35, 0.65)
    if joint is None:
        return None
    most = np.quantile(np.abs(np.concatenate([c[joint.effort] for c in bench.recordings])), share)
    cut = everywhere(bench, joint.effort, lambda x: np.clip(x, -most, most), "saturated")
    return cut if all(np.ptp(c[joint.effort]) > most for c in cut.bench.recordings) else None


# ---- rows and files --------------------------------------------------------------------


def twice(bench, rng):
    """Each second row repeats the one before, with its own time."""
    doubled = [{n: x if n == "time_s" else np.repeat(x[::2], 2)[:len(x)] for n, x in c.items()} for c in bench.recordings]
    return Spoiled(replace(bench, recordings=doubled), "repeated_rows", "")


def copied(bench, rng):
    """Some seconds stand a second time behind the end."""
    k = int(rng.integers(len(bench.recordings)))
    columns = bench.recordings[k]
    rows, step = stretch(columns, rng, 3.0, 15.0), step_s(columns)
    again = {name: np.concatenate([x, x[rows]]) for name, x in columns.items()}
    t = columns["time_s"]
    again["time_s"] = np.concatenate([t, t[-1] + step + t[rows] - t[rows.start]])
    changed = list(bench.recordings)
    changed[k] = again
    return Spoiled(replace(bench, recordings=changed), "repeated_rows", "")


def overlapping(bench, rng):
    """One recording given as two files that share a fifth of it."""
    k = int(rng.integers(len(bench.recordings)))
    columns = bench.recordings[k]
    n = len(columns["time_s"])
    begin = int(n * rng.uniform(0.3, 0.5))
    first, second = slice(None, begin + n // 5), slice(begin, None)
    parts = [{name: x[rows] for name, x in columns.items()} for rows in (first, second)]
    return Spoiled(replace(bench, recordings=parts, files=["1.csv", "2.csv"]), "overlap", "")


def two_machines(bench, rng):
    """A second file of a machine that is so many times as heavy, has as much more friction: for the same motion its drive gives
    exactly so many times the torque. Beside a sensor at the output its torque would be another one, too."""
    if bench.load_sensor or not all(moving(bench, joint) for joint in bench.joints):
        return None
    two = bench if len(set(bench.files)) > 1 else halves(bench)
    factor = rng.uniform(3.0, 6.0) ** rng.choice([-1, 1])
    efforts = [joint.effort for joint in bench.joints]
    other = [{n: factor * x if n in efforts else x for n, x in c.items()} if file == two.files[-1] else c
             for file, c in zip(two.files, two.recordings)]  # fmt: skip
    return Spoiled(replace(two, recordings=other), "other_machine", "")


def halves(bench):
    """The longest recording as two files."""
    columns = max(bench.recordings, key=lambda c: len(c["time_s"]))
    middle = len(columns["time_s"]) // 2
    parts = [{name: x[rows] for name, x in columns.items()} for rows in (slice(None, middle), slice(middle, None))]
    return replace(bench, recordings=parts, files=["1.csv", "2.csv"])


KINDS = {
    "time in milliseconds": milliseconds,
    "time in microseconds": microseconds,
    "too slow": slow,
    "half of it lost": lost,
    "too short": short,
    "it stands": still,
    "stamps that wander": wandering_stamps,
    "angle in degrees": degrees,
    "angle in turns": turns,
    "position in millimetres": millimetres,
    "angle of the gear's other side": other_side,
    "second encoder in degrees": scaled_of(behind, "behind", DEGREES, "units"),
    "second encoder the other way": scaled_of(behind, "behind", -1.0, "sign"),
    "one angle for both encoders": second_as_motor,
    "another ratio between encoders": another_ratio,
    "speed in degrees": scaled_of(speedy, "velocity", DEGREES, "units"),
    "speed in turns": scaled_of(speedy, "velocity", TURNS, "units"),
    "speed the other way": scaled_of(speedy, "velocity", -1.0, "sign"),
    "wrapped angle": wrapped,
    "one spike of the angle": one_spike,
    "spikes of the angle": some_spikes,
    "angle that hangs": stuck_angle,
    "few steps of the encoder": few_steps,
    "current in milliamperes": milliamperes,
    "current of the other sign": other_sign,
    "torque of the gear's other side": torque_other_side,
    "unsigned current": unsigned,
    "spikes of the current": current_spikes,
    "current that hangs": stuck_current,
    "current always the same": constant_current,
    "current held for some rows": held_current,
    "current at its limit": limited,
    "rows twice": twice,
    "some seconds copied": copied,
    "files that overlap": overlapping,
    "files of two machines": two_machines,
}


def spoil(bench, kind, seed):
    """A kind's fault on a bench, the same for the same seed; None where there is none to be told."""
    return KINDS[kind](bench, np.random.default_rng([seed, *bench.name.encode(), *kind.encode()]))
