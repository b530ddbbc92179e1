"""Faults of the time column: its unit, its rate, what is lost, stamps that are not the sampling instants."""

import numpy as np

from .finding import Finding

SLOWEST_STEP_S = 0.4  # no recorder of joints is slower: what looks slower is in another unit
LEAST_RATE_HZ = 40.0  # friction's turn at a stop takes some 20 ms
GAP_STEPS = 5.0  # a longer one parts segments (contract, section 5)
LOST_SHARE, GRAVE_LOST_SHARE = 0.05, 0.4
ROUNDED_SHARE = 0.3  # of a step, that stamps deviate from even ones
UNITS = ((1e9, "nanoseconds"), (1e6, "microseconds"), (1e3, "milliseconds"))
PLAUSIBLE_STEP_S = 1e-4, 0.05


def time_findings(name, recording):
    """Findings of one recording's time column."""
    t, step = recording.t, recording.step_s
    if step > SLOWEST_STEP_S:
        unit = next((word for factor, word in UNITS if PLAUSIBLE_STEP_S[0] <= step / factor <= PLAUSIBLE_STEP_S[1]), None)
        if unit:
            yield Finding("units", True, "time_s", f"{name}: samples {step:g} s apart, a usual step in {unit}",
                          f"give time_s in seconds: these look like {unit}")  # fmt: skip
            return
    if 1 / step < LEAST_RATE_HZ:
        yield Finding("too_slow", True, "time_s", f"{name}: {1 / step:.4g} samples a second",
                      f"record at {LEAST_RATE_HZ:g} Hz at the least, better at 200 Hz")  # fmt: skip
    steps = np.diff(t)
    lost = float(np.sum(steps[steps > 1.5 * step] - step) / (t[-1] - t[0]))
    if lost > LOST_SHARE:
        longest = steps.max()
        yield Finding("dropouts", lost > GRAVE_LOST_SHARE, "time_s",
                      f"{name}: {100 * lost:.0f} % of the time has no samples, the longest gap is {longest:.3g} s",
                      f"find out where samples are lost{'' if lost > GRAVE_LOST_SHARE else '; what remains is used'}")  # fmt: skip
    whole = steps[steps < 1.5 * step]
    spread = float(np.std(whole)) / step if len(whole) else 0.0
    if spread > ROUNDED_SHARE:
        yield Finding("clock", False, "time_s", f"{name}: steps differ by {100 * spread:.0f} % of {1e3 * step:.3g} ms",
                      "stamp samples where they are taken, not where they are written; rounded times can be made even")  # fmt: skip
