"""A torque that is periodic in time whatever the motion does: a fan, a pump, a neighbour."""

from dataclasses import dataclass

import numpy as np

from ..catalogue.candidate import Candidate, Family, named
from .law import entry

STRONGEST = 4  # lines of what the plain model leaves, that are tried
LEAST_PERIODS = 4.0  # in the longest recording: what is slower may be a drift
APART = 2.0  # lines of a spectrum, at least, between two that are tried
PADDED = 4  # times a spectrum's lines


@dataclass(frozen=True)
class Oscillation:
    """One column: a cosine or sine in one recording, for a phase of its own in each."""

    joint: int
    frequency_Hz: float
    record: int
    quarter: int

    def __call__(self, terms):
        """{channel: column on the grid} of one recording."""
        if terms.record != self.record:
            return {}
        angle = 2 * np.pi * self.frequency_Hz * (terms.t_s - terms.t_s[0]) - 0.5 * np.pi * self.quarter
        return {f"T{self.joint}": terms.operated(np.cos(angle)[None], self.joint)[0]}


def left_by_plain(dataset, channel):
    """Residual of one channel's own least squares on the base columns, on the grid; 0 where it is not scored."""
    base = dataset.base_columns(channel)
    scale = np.sqrt((base**2).sum(0)) + 1e-12
    out = np.zeros(len(channel.values))
    reading = channel.values[channel.rows]
    out[channel.rows] = reading - base @ (np.linalg.lstsq(base / scale, reading, rcond=None)[0] / scale)
    return out


def lines_Hz(dataset, joint):
    """Frequencies of the strongest lines of what the plain model leaves of a joint's torque, over all recordings."""
    found = []
    for channel in (c for c in dataset.channels if c.kind == f"T{joint}" and len(c.rows) > dataset.bases):
        left, step_s = left_by_plain(dataset, channel), dataset.processed_recordings[channel.record].step_s
        count = PADDED * len(left)
        power = np.abs(np.fft.rfft(left * np.hanning(len(left)), count)) ** 2
        hertz = np.fft.rfftfreq(count, step_s)
        wide = APART / (len(left) * step_s)
        power[hertz < LEAST_PERIODS / (len(left) * step_s)] = 0.0
        for _ in range(STRONGEST):
            peak = hertz[np.argmax(power)]
            found.append((power.max() / len(left), peak, wide))
            power[np.abs(hertz - peak) < wide] = 0.0
    kept = []
    for strength, peak, wide in sorted(found, reverse=True):
        if strength > 0 and all(abs(peak - other) > wide for other in kept):
            kept.append(float(peak))
    return kept[:STRONGEST]


def candidates(at):
    records = sorted({c.record for c in at.dataset.channels if c.kind == f"T{at.number}"})
    longest_s = max(terms.t_s[-1] - terms.t_s[0] for terms in at.all_terms)

    def one(hertz):
        columns = tuple(Oscillation(at.number, hertz, record, quarter) for record in records for quarter in (0, 1))
        names = [f"{name}_{record + 1}_Nm" for record in records for name in ("cosine", "sine")]
        family = Family(one, (hertz,), (0.25 / longest_s,), (0.5 * hertz,), (2.0 * hertz,))
        return Candidate("vibration", at.name, f"{hertz:g} Hz", columns, named(*names, frequency_Hz=hertz), family=family)

    yield from (one(hertz) for hertz in lines_Hz(at.dataset, at.number))


def size(p):
    squares = [value**2 for name, value in p.items() if name.endswith("_Nm")]
    return f"{np.sqrt(2 * np.mean(squares)):.3g} Nm at {p['frequency_Hz']:.3g} Hz"


ENTRIES = [entry("vibration", "a torque that is periodic in time, whatever the motion does", candidates, size)]
