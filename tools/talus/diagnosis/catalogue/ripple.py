"""Torques that are periodic in the motor's angle: how much of them a recording shows."""

import numpy as np

# A ripple that position control does not hold shakes the motor instead, and the recorded acceleration shows of that what
# the reconstruction's window leaves: half at 1.67 of the low-pass frequency, falling with the fourth power
SHOWN_UP_TO = 1.67
FEWEST_WAVES_RAD = 2 * np.pi  # what has not gone through one period is not known to have any
APART_RAD = 2 * np.pi * 1.5  # of two orders' beat: with less they are one hump of any form, large and opposite


def fades(at):
    """Frequencies at which half of a ripple shows; 0: all of it, whatever its frequency."""
    window = SHOWN_UP_TO * at.dataset.processed_recordings[0].recording.score.lowpass_hz
    return (window,) if at.dataset.at_motor else (0.0, window)


def are_apart(one, other):
    """Are two ripples two, or one hump?"""
    return all(abs(a - b) > APART_RAD for a in one.phases_rad for b in other.phases_rad)
