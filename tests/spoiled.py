"""Recordings spoiled as users' are: each kind takes the columns of a sound one and gives them back with one fault, the finding
that must name it, and the column."""

import numpy as np


def scaled(columns, name, factor):
    return {**columns, name: factor * columns[name]}


def changed(columns, name, rows, values):
    x = columns[name].copy()
    x[rows] = values(x[rows])
    return {**columns, name: x}


def every(columns, step):
    return {name: x[::step] for name, x in columns.items()}


def doubled(columns):
    """Each second row repeats the one before, with its own time."""
    return {n: x if n == "time_s" else np.repeat(x[::2], 2)[:len(x)] for n, x in columns.items()}


def copied(columns):
    """Ten seconds stand a second time behind the end."""
    n = int(10 / np.median(np.diff(columns["time_s"])))
    step, begin = np.median(np.diff(columns["time_s"])), len(columns["time_s"]) // 4
    again = {name: np.concatenate([x, x[begin:begin + n]]) for name, x in columns.items()}
    again["time_s"] = np.concatenate([columns["time_s"], columns["time_s"][-1] + step * np.arange(1, n + 1)])
    return again


def limited(columns, name):
    most = np.quantile(np.abs(columns[name]), 0.6)
    return {**columns, name: np.clip(columns[name], -most, most)}


def held(columns, name):
    return {**columns, name: np.repeat(columns[name][::4], 4)[:len(columns[name])]}


def middle(columns, share):
    n = len(columns["time_s"])
    return slice(n // 2, n // 2 + int(share * n))


def spoilings(plant, gear):
    """name -> (what it does, finding, column or None)."""
    angle = {"leg": "knee_motor_rad", "pendulum": "joint_rad", "slider": "slider_m"}[plant]
    effort = {"leg": "knee_current_A", "pendulum": "joint_current_A", "slider": "slider_force_N"}[plant]
    turn = 2 * np.pi if plant != "slider" else 0.05
    kinds = {
        "time in milliseconds": (lambda c: scaled(c, "time_s", 1e3), "units", "time_s"),
        "time in microseconds": (lambda c: scaled(c, "time_s", 1e6), "units", "time_s"),
        "five samples a second": (lambda c: every(c, 50), "too_slow", "time_s"),
        "half of it lost": (lambda c: {n: x[np.arange(len(x)) % 500 < 250] for n, x in c.items()}, "dropouts", "time_s"),
        "one spike": (lambda c: changed(c, angle, len(c[angle]) // 2, lambda x: x + 30 * (np.ptp(c[angle]))), "spike", angle),
        "spikes of the current": (lambda c: changed(c, effort, slice(700, None, 900), lambda x: x + 20 * np.std(c[effort])), "spike", effort),
        "an encoder that stands": (lambda c: changed(c, angle, moving(c, angle), lambda x: x[0]), "stuck", angle),
        "a current that stands": (lambda c: changed(c, effort, middle(c, 0.2), lambda x: x[0]), "stuck", effort),
        "a current that is always the same": (lambda c: {**c, effort: np.full_like(c[effort], 1.25)}, "stuck", effort),
        "a current held for four rows": (lambda c: held(c, effort), "stuck", effort),
        "a current at its limit": (lambda c: limited(c, effort), "saturated", effort),
        "rows twice": (doubled, "repeated_rows", None),
        "ten seconds copied": (copied, "repeated_rows", None),
    }
    if plant == "slider":
        return kinds
    kinds |= {
        "degrees": (lambda c: scaled(c, angle, 180 / np.pi), "units", angle),
        "turns": (lambda c: scaled(c, angle, 1 / (2 * np.pi)), "units", angle),
        "milliamperes": (lambda c: scaled(c, effort, 1e3), "units", effort),
        "the other sign": (lambda c: scaled(c, effort, -1.0), "sign", effort),
        "unsigned current": (lambda c: {**c, effort: np.abs(c[effort])}, "unsigned", effort),
        "wrapped": (lambda c: {**c, angle: np.mod(wide(c[angle], turn), turn)}, "wrapped", angle),
        "the gear's other side": (lambda c: scaled(c, angle, 1 / gear if plant == "leg" else gear), "ratio", angle),
    }
    if plant == "leg":
        kinds |= {
            "the joint's encoder in degrees": (lambda c: scaled(c, "ankle_joint_rad", 180 / np.pi), "units", "ankle_joint_rad"),
            "the joint's encoder the other way": (lambda c: scaled(c, "ankle_joint_rad", -1.0), "sign", "ankle_joint_rad"),
            "the joint's angle as the motor's": (lambda c: {**c, "ankle_motor_rad": c["ankle_joint_rad"].copy()}, "ratio", "ankle_motor_rad"),
            "ankle current in milliamperes": (lambda c: scaled(c, "ankle_current_A", 1e3), "units", "ankle_current_A"),
        }
    return kinds


def moving(columns, name):
    """Rows of half a second in which the angle moves."""
    n = int(0.5 / np.median(np.diff(columns["time_s"])))
    x = columns[name]
    begin = max(range(n, len(x) - 2 * n, n // 2), key=lambda k: abs(x[k + n] - x[k]))
    return slice(begin, begin + n)


def wide(x, turn):
    """The motion, turned so that it crosses the end of a turn."""
    return x - np.median(x) if np.ptp(x) < turn else x
