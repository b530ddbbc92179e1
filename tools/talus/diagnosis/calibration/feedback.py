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

from .. import noise

BAND_HZ = (5.0, 15.0)  # beyond a bench's motion, below what a loop leaves out or a slow recording folds
SLOPE_HZ = 1.0  # over which a filter goes from nothing to all: below the band the motion is a thousand times as large
FOLDED = 0.4  # of the rate: beyond it nothing of the band is left
SHORTEST_S, EDGE_S = 5.0, 1.0  # of a piece, and what the filter's beginning and end spoil of it
EXPLAINED, LEAST = 0.85, 0.25  # of the torque's power in the band, noise aside and with it: else the drive does something else
FOLDED_NOISE = 1.5  # times what white noise of the torque's roughness has there: steps that a slow recording folds are not quite white
CHUNK = 20000  # values at once
SMOOTH_HZ, SMOOTH_SHARE = (BAND_HZ[1], 30.0), 0.2  # of the order: as far as the law is known, and of the rate
DELAY_S = 3e-4, 0.006  # of a speed that a position loop can do with
NO_LOOP_S = 0.02  # a delay, or a lead, that no noise makes of one of these


@dataclass
class Law:
    """Of one joint's drive; `explains` is the share of the torque's power in the band that it tells."""

    stiffness: float
    damping: float
    delay_s: float
    explains: float

    def velocity_hz(self, tick_s):
        """Of the low-pass on the speed of a loop that ticks. Its difference and its held torque are late by half a tick each; a share x of
        what is new at a tick by (1 - x) / x ticks."""
        return float(np.log1p(tick_s / self.lag_s(tick_s)) / (2.0 * np.pi * tick_s))

    @property
    def is_sure(self):
        """Has it a delay that a loop can do with, and does it tell most of the torque, folded steps and all?"""
        return self.delay_s not in DELAY_S and self.explains > EXPLAINED

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
    """What the torque is beside the law, smooth and without what the encoder's steps make of it, an array a part: at a loop's ticks, from
    `first_tick_s` after the part's first sample on. Where the motion repeats it is the mean over its periods, and repeats as exactly: a drive's
    answer to its encoder's steps does, too."""
    floor = _folded(torque[processed.inside], processed.step_s)
    position, torque, out = processed.resample(position), processed.resample(torque), []
    spring, damper = law.stiffness, law.damping
    smooth_Hz = 0.0, float(np.clip(SMOOTH_SHARE / processed.step_s, *SMOOTH_HZ))
    for part, piece in zip(processed.parts, _pieces(processed)):
        t = part["begin_s"] + processed.step_s * np.arange(part["n"])
        s, moment = (_filtered(x[piece], processed.step_s, smooth_Hz, 2) for x in (position, torque))
        values = moment[0] + spring * s[0] + damper * (s[1] - law.delay_s * s[2])
        values, slopes = _filtered(values, processed.step_s, smooth_Hz, 1, floor, max(_periods(t, period_s), 1))
        first, last = processed.t_s[part["begin"]], processed.t_s[part["end"] - 1]
        ticks = first + first_tick_s(processed.t_s[part["begin"]:part["end"]], tick_s) + tick_s * np.arange(int((last - first) / tick_s) + 2)
        out.append(_repeating(t, values, slopes, period_s)(np.clip(ticks, t[0], t[-1])))
    return out


def first_tick_s(t_s, tick_s):
    """When a drive ticks first, from the first sample on, not after it: samples lie amid two ticks, as far as their rates allow, for
    then they see the held torque neither early nor late."""
    turned = np.mean(np.exp(2j * np.pi * (t_s - t_s[0]) / tick_s))
    return (np.angle(turned) / (2 * np.pi) + 0.5) % 1.0 * tick_s - tick_s


def _periods(t, period_s):
    """How many whole ones there are between the ends."""
    return max(int((t[-1] - t[0] - 2 * EDGE_S) / period_s), 0) if period_s else 0


def _repeating(t, values, slopes, period_s):
    """Values on an even grid as a smooth function of time, their mean over the periods that are whole if there are several."""
    begin, periods = t[0] + EDGE_S, _periods(t, period_s)
    if periods < 2:
        return lambda at: _between(t, values, slopes, at)
    phase = np.linspace(0.0, period_s, round(period_s / (t[1] - t[0])) + 1)
    starts = [begin + k * period_s + phase[:-1] for k in range(periods)]
    mean = np.mean([_between(t, values, slopes, start) for start in starts], axis=0)
    rise = np.mean([np.interp(start, t, slopes) for start in starts], axis=0)
    return lambda at: _between(phase, np.append(mean, mean[0]), np.append(rise, rise[0]), (at - begin) % period_s)


def _between(t, values, slopes, at):
    """Cubic Hermite interpolation on an even grid."""
    if len(at) > CHUNK:
        return np.concatenate([_between(t, values, slopes, at[k:k + CHUNK]) for k in range(0, len(at), CHUNK)])
    step = t[1] - t[0]
    row = np.clip(((at - t[0]) / step).astype(int), 0, len(t) - 2)
    u = (at - t[row]) / step
    rise = values[row + 1] - values[row]
    bend, twist = step * slopes[row] - rise, step * slopes[row + 1] - rise
    return values[row] + u * rise + u * (1 - u) * (bend * (1 - u) - twist * u)


def _measured(processed, position, torque):
    """A Law by least squares in the band, where it can be that of a loop that answers this encoder."""
    found = _in_band(processed, position, torque)
    if not found:
        return None
    (stiffness, damping, second), told, power = found
    folded = (BAND_HZ[1] - BAND_HZ[0]) * _folded(torque[processed.inside], processed.step_s)
    if not (stiffness > 0 and damping > 0 and abs(second) < NO_LOOP_S * damping):
        return None
    if not told > max(EXPLAINED * (power - folded), LEAST * power):
        return None
    return Law(float(stiffness), float(damping), float(np.clip(second / damping, *DELAY_S)), float(told / power))


def _folded(torque, step_s):
    """Power for each Hz of what a torque has by its roughness: the steps' answers, folded."""
    return FOLDED_NOISE * noise.roughness(torque) ** 2 * 2.0 * step_s


def explained(processed_recordings, positions, torques):
    """Share of the torque's power in the band that its position tells, by whatever law; of the recording where that is most."""
    found = [_in_band(*one) for one in zip(processed_recordings, positions, torques, strict=True)]
    return max((told / power for _, told, power in filter(None, found)), default=0.0)


def _in_band(processed, position, torque):
    """((stiffness, damping, damping times delay), power told, power) of least squares in the band; None where nothing moves there."""
    rate_Hz = 1.0 / processed.step_s
    pieces = [piece for piece in _pieces(processed) if piece.stop - piece.start > SHORTEST_S * rate_Hz]
    edge, position, torque = round(EDGE_S * rate_Hz), processed.resample(position), processed.resample(torque)
    products, n = np.zeros((4, 4)), 0
    for piece in pieces:  # one at a time: large arrays that come and go scatter the memory of all else
        s, y = (_filtered(x[piece], processed.step_s, BAND_HZ, k)[:, edge:-edge] for x, k in ((position, 2), (torque, 0)))
        rows = np.array([-s[0], -s[1], s[2], y[0]])
        products += rows @ rows.T
        n += rows.shape[1]
    scale = np.sqrt(np.diag(products))
    if not np.all(scale > 0):
        return None
    normal, target, own = products[:3, :3], products[:3, 3], scale[:3]
    law = np.linalg.lstsq(normal / np.outer(own, own), target / own, rcond=None)[0] / own
    return law, law @ target / n, products[3, 3] / n


def _filtered(x, step_s, band_Hz, derivatives, floor=0.0, periods=1):
    """What is left of a signal in a band, and so many derivatives of that. It goes on beyond its ends turned about them, less the line
    between these, so that nothing jumps there. Noise, whose power for each Hz is the `floor`, is taken off as leaves the least error in
    the mean of so many periods (Wiener)."""
    line = np.linspace(x[0], x[-1], len(x))
    rest = x - line
    hz = np.fft.rfftfreq(2 * len(x) - 2, step_s)
    passed = np.clip((hz - band_Hz[0]) / SLOPE_HZ + 1.0, 0.0, 1.0) * np.clip((band_Hz[1] - hz) / SLOPE_HZ + 1.0, 0.0, 1.0)
    spectrum = passed * np.fft.rfft(np.concatenate([rest, -rest[-2:0:-1]]))
    if floor > 0:
        band = (hz / SLOPE_HZ).astype(int)
        power = np.bincount(band, np.abs(spectrum) ** 2) / np.bincount(band) * 2.0 * step_s / (2 * len(x) - 2)
        own = np.maximum(power - floor, 0.0)
        spectrum *= (own / (own + floor / periods))[band]
    out = np.array([np.fft.irfft(spectrum * (2j * np.pi * hz) ** k, 2 * len(x) - 2)[: len(x)] for k in range(derivatives + 1)])
    if band_Hz[0] <= 0:
        out[0] += line
        out[1] += (x[-1] - x[0]) / (step_s * (len(x) - 1))
    return out


def _pieces(processed):
    """Ranges of the grid, one a part."""
    ends = np.cumsum([part["n"] for part in processed.parts])
    return [slice(end - part["n"], end) for part, end in zip(processed.parts, ends)]
