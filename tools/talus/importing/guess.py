"""Units, wraps and signs from the values themselves; whatever is guessed comes with the words that say so."""

import numpy as np

from . import clock, headers

# (step below which a median time step is taken for so many seconds a unit)
STEPS = ((0.09, "s"), (90.0, "ms"), (9e4, "us"), (np.inf, "ns"))
UNIX = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"), (1e8, "s"))
TURN = {"radian": 2 * np.pi, "degree": 360.0, "turn": 1.0}
MOST_WRAPPED = 0.05  # of the steps
POWERS = [2.0**k for k in (8, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 24, 32)]


def span(values):
    return f"{np.nanmin(values):.4g} .. {np.nanmax(values):.4g}"


def time_unit(column):
    """(unit, doubt or None) of a time without one in its header."""
    if clock.is_calendar(column) or isinstance(column.raw, np.ndarray) and column.raw.dtype.kind == "M":
        return "s", None
    values = column.numbers("")
    values = values[np.isfinite(values)]
    if not len(values):
        return "s", None
    unix = next((unit for least, unit in UNIX if values[0] >= least), None)
    if unix:
        return unix, f"{column.name}: its header has no unit; {unix} since 1970 by its size"
    steps = np.abs(np.diff(values))
    step = np.median(steps[steps > 0]) if (steps > 0).any() else 0.0
    unit = next(unit for most, unit in STEPS if step < most)
    return unit, f"{column.name}: its header has no unit; {unit} by its step of {step:.4g}"


def value_unit(column, values, target):
    """(unit, doubt) of a column without one in its header."""
    largest, low = float(np.nanmax(np.abs(values))), float(np.nanmin(values))
    kind = headers.target_of(target)
    whole = bool(np.all(values[np.isfinite(values)] == np.round(values[np.isfinite(values)])))
    if kind == "radian":
        ends = (low, float(np.nanmax(values)))
        power = next((p for p in POWERS if whole and any(_fills(ends, begin, begin + p) for begin in (0, -p / 2))), None)
        if power:
            return f"turn/{power:.0f}", _says(column, f"turn/{power:.0f} because it holds whole numbers up to that", values)
        unit = "deg" if largest > 12.6 and not target.endswith("_motor_rad") else "rad"
    elif kind == "radian/second":
        unit = "deg/s" if largest > 60 else "rad/s"
    elif kind == "ampere":
        unit = "mA" if largest > 150 else "A"
    elif kind == "newton*meter":
        unit = "mNm" if largest > 1000 else "Nm"
    elif kind == "degC":
        unit = "K" if low > 200 else "degC"
    elif kind == "volt":
        unit = "mV" if largest > 1000 else "V"
    elif kind == "meter":
        unit = "mm" if largest > 3 else "m"
    else:
        unit = "N"
    return unit, _says(column, unit, values)


def _fills(ends, begin, end):
    """Do values between these two use nearly all numbers from begin to end, as a counter's do that turns on and on?"""
    return begin <= ends[0] and ends[1] < end and (ends[1] > begin + 0.9 * (end - begin)) and (begin == 0 or ends[0] < begin + 0.1 * (end - begin))


def _says(column, unit, values):
    return f"{column.name}: its header has no unit; taken for {unit}, by its range {span(values)}"


def wrap(values, unit, is_angle):
    """The period at which a sensor starts again, in its own unit, or None: steps of nearly that size, of both ends."""
    good = values[np.isfinite(values)]
    if len(good) < 3:
        return None
    steps, low, high = np.abs(np.diff(good)), good.min(), good.max()
    quantity = headers.parse(unit)
    turn = 1 / float(quantity.to("turn").magnitude) if is_angle and headers.fits(unit, "joint_rad") else None
    whole = (good == np.round(good)).all()
    for period in ([turn, turn / 2] if turn else []) + (POWERS if whole and not turn else []):
        jumps = steps > 0.6 * period
        inside = high - low <= period * (1 + 1e-6) and high - low > 0.8 * period
        if jumps.any() and inside and jumps.mean() <= MOST_WRAPPED + 0.25 * (not is_angle):
            return period
    return None


def unwrap(values, period, is_angle):
    """The values without the sensor's beginnings: an angle goes on, another count is taken from -period/2 on."""
    if not is_angle:
        return (values + period / 2) % period - period / 2
    good = np.isfinite(values)
    out = values.copy()
    steps = np.diff(values[good])
    out[good] = values[good] - period * np.concatenate([[0], np.cumsum(np.round(steps / period))])
    return out


def unsigned(values):
    """Is this a quantity without a sign: never below zero, and touching it often?"""
    good = values[np.isfinite(values)]
    return len(good) > 0 and good.min() >= 0 and good.max() > 0 and np.mean(good < 0.1 * good.max()) > 0.02


def agreement(angle, speed, time_s):
    """(slope of the speed over the angle's derivative, correlation)."""
    good = np.isfinite(angle) & np.isfinite(speed)
    if good.sum() < 20:
        return 0.0, 0.0
    t, q, v = time_s[good], angle[good], speed[good]
    rate = (q[2:] - q[:-2]) / (t[2:] - t[:-2])
    v = v[1:-1]
    norm = np.sqrt((rate @ rate) * (v @ v))
    return (float(rate @ v / (rate @ rate)), float(rate @ v / norm)) if norm > 0 else (0.0, 0.0)


def power_sign(angle, drive, time_s):
    """Mean of drive x speed over their sizes: clearly below zero where a driven joint's sign is turned."""
    good = np.isfinite(angle) & np.isfinite(drive)
    if good.sum() < 20:
        return 0.0
    rate, i = np.gradient(angle[good], time_s[good]), drive[good]
    norm = np.sqrt((rate @ rate) * (i @ i))
    return float(rate @ i / norm) if norm > 0 else 0.0
