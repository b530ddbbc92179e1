"""What the report says of a proposed experiment, and the trajectory's file."""

import numpy as np

from .path import INSIDE, STEP_S


def listed(names):
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1]


def figure(x):
    """A chi-square for readers."""
    return f"{x:.0f}" if x < 1e4 else f"{x:.1e}".replace("e+0", "e")


def margins(q, torque, limits, joints):
    """The motion's share of what the recordings show."""
    v, words = np.gradient(q, STEP_S, axis=1), []
    for j, name in enumerate(joints):
        reach, speed = np.abs(q[j] - limits.middle[j]).max() / limits.half[j], np.abs(v[j]).max() / limits.speed[j]
        words.append(f"{name} {100 * INSIDE * reach:.0f} % of the range, {100 * INSIDE * speed:.0f} % of the speed, "
                     f"{100 * torque[j]:.0f} % of the torque")  # fmt: skip
    return f"Margins, of the largest in the recordings: {'; '.join(words)}."


def to_text(q, model, words):
    """The trajectory's file."""
    unit = model.coordinate_unit
    lines = [f"# {words}", ",".join(["time_s", *(f"{name}_{unit}" for name in model.joints)])]
    lines += [",".join([f"{STEP_S * k:.2f}", *(f"{x:.6f}" for x in row)]) for k, row in enumerate(q.T)]
    return "\n".join(lines) + "\n"


def told(option, contest, repeats):
    """What an option is predicted to bring, pair by pair."""
    words, needed, reached = [], figure(option.needed(repeats)), option.reached(repeats)
    for k, other in enumerate(contest.others):
        gain = figure(repeats * option.worst(k))
        if k in reached:
            words.append(f"predicted gain in evidence over {other.name} (chi-square) {gain}, where {needed} are needed")
        else:
            words.append(f"predicted gain over {other.name} only {gain} of the {needed} needed")
    return "; ".join(words)
