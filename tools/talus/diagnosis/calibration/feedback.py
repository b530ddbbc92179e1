"""How a drive answers its own encoder: the law of its position loop, measured from the recording.

A drive that holds a position turns the steps of its encoder into torque. The recorded torque then is not independent of
the error of the recorded angle, as a sensor's noise would be, and a replicate must have that, too. Beyond the motion's
frequencies a drive orders nothing, and what is left there of torque and position is the loop's law,

    torque = order - stiffness s - damping ds/dt + damping delay d2s/dt2,

s the position that the encoder shows and `delay` that of the loop's speed (a first-order low-pass). A plant in its place
would have the opposite sign of damping. With the law known, the order is what the torque is beside it.
"""

from dataclasses import dataclass

import numpy as np
from scipy import fft, interpolate, signal

BAND_HZ = (5.0, 15.0)  # beyond a bench's motion, below what a loop leaves out or a slow recording folds
STEEPNESS = 8  # order of the band's filter: below the band the motion is a thousand times as large
FOLDED = 0.4  # of the rate: beyond it nothing of the band is left
SHORTEST_S, EDGE_S = 4.0, 0.5  # of a piece, and what the filter's beginning and end spoil of it
EXPLAINED, LEAST = 0.85, 0.25  # of the torque's power in the band, white noise aside and with it: else the drive does something else
SMOOTH_HZ = 15.0
DELAY_S = 3e-4, 0.02


@dataclass
class Law:
    """Of one joint's drive; `explains` is the share of the torque's power in the band that it tells."""

    stiffness: float
    damping: float
    delay_s: float
    explains: float

    def velocity_hz(self, tick_s):
        """Of the low-pass on the speed of a loop that ticks: its difference and its held torque are late by half a tick each."""
        return 1.0 / (2.0 * np.pi * self.lag_s(tick_s))

    def lag_s(self, tick_s):
        return max(self.delay_s - tick_s, DELAY_S[0])


def law_of(processed_recordings, positions, torques):
    """The Law of a joint's drive, from the recording that shows it best (in another the motion may have what looks like one); None
    where none does. Its encoder's column and its torque at the samples, of each recording."""
    if any(BAND_HZ[1] > FOLDED / one.step_s for one in processed_recordings):
        return None
    found = [_measured(*one) for one in zip(processed_recordings, positions, torques, strict=True)]
    return max((law for law in found if law), key=lambda law: law.explains, default=None)


def order(processed, law, position, torque, tick_s, period_s=None):
    """What the torque is beside the law, smooth, at a loop's ticks from `first_tick_s` after each part's first sample on, an array a
    part. Where the motion repeats it is the mean over its periods, and repeats as exactly: a drive's answer to its encoder's steps does, too."""
    position, torque = processed.resample(position), processed.resample(torque)
    low, out = signal.butter(4, SMOOTH_HZ, fs=1.0 / processed.step_s, output="sos"), []
    for part, piece in zip(processed.parts, _pieces(processed)):
        t = part["begin_s"] + processed.step_s * np.arange(part["n"])
        s = interpolate.CubicSpline(t, _smooth(low, position[piece]))
        smooth = _smooth(low, torque[piece]) + law.stiffness * s(t) + law.damping * (s(t, 1) - law.delay_s * s(t, 2))
        first, last = processed.t_s[part["begin"]], processed.t_s[part["end"] - 1]
        ticks = first + first_tick_s(processed.t_s[part["begin"]:part["end"]], tick_s) + tick_s * np.arange(int((last - first) / tick_s) + 2)
        out.append(_repeating(t, smooth, period_s)(np.clip(ticks, t[0], t[-1])))
    return out


def _smooth(low, x):
    """Through a low-pass, forth and back; a short piece has as much put on at its ends as it has."""
    return signal.sosfiltfilt(low, x, padlen=min(3 * (2 * len(low) + 1), len(x) - 1))


def first_tick_s(t_s, tick_s):
    """When a drive ticks first, from the first sample on, not after it: samples lie amid two ticks, as far as their rates allow, for
    then they see the held torque neither early nor late."""
    turned = np.mean(np.exp(2j * np.pi * (t_s - t_s[0]) / tick_s))
    return (np.angle(turned) / (2 * np.pi) + 0.5) % 1.0 * tick_s - tick_s


def _repeating(t, values, period_s):
    """Values on an even grid as a smooth function of time, their mean over the periods that are whole if there are several."""
    every, begin = interpolate.CubicSpline(t, values), t[0] + EDGE_S
    periods = int((t[-1] - EDGE_S - begin) / period_s) if period_s else 0
    if periods < 2:
        return every
    phase = np.linspace(0.0, period_s, round(period_s / (t[1] - t[0])) + 1)
    mean = np.mean([every(begin + k * period_s + phase[:-1]) for k in range(periods)], axis=0)
    repeated = interpolate.CubicSpline(phase, [*mean, mean[0]], bc_type="periodic")
    return lambda at: repeated((at - begin) % period_s)


def roughness(values):
    """Standard deviation of white noise that has the third differences of a signal; 0 of fewer than four values."""
    return float(np.sqrt(np.mean(np.diff(values, 3) ** 2) / 20.0)) if len(values) > 3 else 0.0


def _measured(processed, position, torque):
    """A Law by least squares in the band, where it can be that of a loop that answers this encoder."""
    rate_Hz = 1.0 / processed.step_s
    pieces = [piece for piece in _pieces(processed) if piece.stop - piece.start > SHORTEST_S * rate_Hz]
    if not pieces:
        return None
    white = roughness(torque[processed.inside]) ** 2 * 2.0 * (BAND_HZ[1] - BAND_HZ[0]) / rate_Hz
    band = signal.butter(STEEPNESS, BAND_HZ, "bandpass", fs=rate_Hz, output="sos")
    s, t = (np.hstack([_filtered(band, x[piece], processed.step_s) for piece in pieces])
            for x in (processed.resample(position), processed.resample(torque)))  # fmt: skip
    a, y = np.array([-s[0], -s[1], s[2]]).T, t[0]
    scale = np.linalg.norm(a, axis=0)
    if not np.all(scale > 0):
        return None
    stiffness, damping, second = found = np.linalg.lstsq(a / scale, y, rcond=None)[0] / scale
    power, told = np.mean(y**2), np.mean(y**2) - np.mean((y - a @ found) ** 2)
    if not (stiffness > 0 and damping > 0 and told > EXPLAINED * (power - white) and told > LEAST * power):
        return None
    return Law(float(stiffness), float(damping), float(np.clip(second / damping, *DELAY_S)), float(told / power))


def _filtered(band, x, step_s):
    """What a filter leaves of a signal, and the first two derivatives of that."""
    x = signal.sosfiltfilt(band, x - np.mean(x))
    n = fft.next_fast_len(2 * len(x), real=True)
    omega, spectrum = 2j * np.pi * fft.rfftfreq(n, step_s), fft.rfft(x, n)
    edge = round(EDGE_S / step_s)
    return np.array([x, *(fft.irfft(spectrum * omega**k, n)[: len(x)] for k in (1, 2))])[:, edge:-edge]


def _pieces(processed):
    """Ranges of the grid, one a part."""
    ends = np.cumsum([part["n"] for part in processed.parts])
    return [slice(end - part["n"], end) for part, end in zip(processed.parts, ends)]
