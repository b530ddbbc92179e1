"""The page's maps of the error, before and after the effects, and the measured torque against the predicted."""

from pathlib import Path

import numpy as np

from ..where import ORDERS
from ..words import Scale, linear

COORDINATES = {  # in words, and the unit
    "position": ("position", "rad"), "velocity": ("velocity", "rad/s"), "acceleration": ("acceleration", "rad/s²"),
    "load": ("load at the joint", "Nm"), "current": ("motor torque", "Nm"), "time": ("time", "s"),
    "reversal": ("time since the motion or the load turned", "s"), "motor_angle": ("order", "per turn"),
    "frequency": ("frequency", "Hz"), "encoder": ("position", "rad"),
}  # fmt: skip
SPECTRA = ("motor_angle", "frequency")
MOST_MAPS = 3  # for each joint
CLEAR = 1.1  # identified error over noise from which more than one map is shown
BAND_HZ, TOP_HZ = 0.5, 30.0
MOST_POINTS = 3000  # of a line: more than a screen shows
SHOWN_S = 12.0  # of the measured torque
ENCODER_BINS = 24


class Shown:
    """What a map is drawn from, for one joint."""

    def __init__(self, found, number, joint):
        self.found, self.number, self.joint = found, number, joint
        self.dataset, self.kind = found.search.dataset, f"T{number}"
        self.straight = self.dataset.model.coordinate_unit == "m"
        self.fits = [("identified", "identified", found.before)]
        if found.fit.chosen:
            self.fits.append(("with effects", "extended", found.after))

    def channels(self, kind=None):
        return [c for c in self.dataset.channels if c.kind == (kind or self.kind) and len(c.rows)]

    def chart(self, out, title, x_label, y_label, lines):
        """A chart of lines in Nm or N, in a unit of readable size."""
        scale = Scale(self.dataset.model.torque_unit, [np.abs(y).max() for *_, y in lines])
        out.chart(f"{self.joint}: {title}", x_label, f"{y_label} [{scale.unit}]", [(*of, scale(y)) for *of, y in lines])

    def label(self, coordinate):
        return coordinate_label(coordinate, self.straight)


def coordinate_unit(coordinate, straight):
    unit = COORDINATES[coordinate][1]
    return linear(unit) if straight else unit


def coordinate_label(coordinate, straight):
    """A coordinate of `where` in words, with its unit."""
    label = f"{COORDINATES[coordinate][0]} [{coordinate_unit(coordinate, False)}]"
    return linear(label) if straight else label


def maps(out, found):
    """Each joint's largest maps."""
    out.heading("Maps of the error")
    for number, joint in enumerate(found.search.dataset.model.joints):
        shown = Shown(found, number, joint)
        with out.side_by_side():
            for coordinate in chosen(found, joint):
                drawers = {"motor_angle": orders, "frequency": spectrum, "encoder": encoders}
                drawers.get(coordinate, binned)(out, shown, coordinate)


def chosen(found, joint):
    """The coordinates whose maps are shown: as `where` ranks them, then by energy."""
    gap = found.report["gap"][joint]
    most = MOST_MAPS if gap["identified_rms"] > CLEAR * gap["noise_floor_rms"] else 1
    binned_ones = [m.coordinate for m in sorted(found.maps.get(joint, []), key=lambda m: -m.energy)]
    ranked = [w["coordinate"] for w in found.report["where"] if w["joint"] == joint]
    known = [c for c in ranked if c in binned_ones or c in SPECTRA or c == "encoder"]
    return list(dict.fromkeys([*known, *binned_ones]))[:most]


def binned(out, shown, coordinate):
    """Means over a coordinate."""
    sigma, lines = shown.dataset.sigma[shown.kind], []
    for (name, role, _), every in zip(shown.fits, (shown.found.maps, shown.found.maps_after)):
        own = [m for m in every.get(shown.joint, []) if m.coordinate == coordinate]
        lines += [(name, role, m.centre, m.mean * sigma) for m in own]
    shown.chart(out, f"mean error over {coordinate}", shown.label(coordinate), "error", lines)


def orders(out, shown, _):
    """Amplitude at each order of the motor's angle."""
    waves = [np.exp(1j * np.outer(ORDERS, shown.found.search.all_terms[c.record].grid("motor_rad", shown.number)[c.rows]))
             for c in shown.channels()]  # fmt: skip
    total, lines = sum(w.shape[1] for w in waves), []
    for name, role, residuals in shown.fits:
        sums = sum(w @ residuals.of[c.record, c.kind][c.rows] for w, c in zip(waves, shown.channels()))
        lines.append((name, role, ORDERS, 2 * np.abs(sums) / total))
    shown.chart(out, "error by order of the motor's turn", shown.label("motor_angle"), "amplitude", lines)


def spectrum(out, shown, _):
    """RMS in bands of BAND_HZ."""
    edges, lines = np.arange(0, TOP_HZ + BAND_HZ, BAND_HZ), []
    for name, role, residuals in shown.fits:
        power, total = np.zeros(len(edges) - 1), 0
        for c in shown.channels():
            x = residuals.of[c.record, c.kind][c.rows]
            frequency = np.fft.rfftfreq(len(x), shown.dataset.processed_recordings[c.record].step_s)
            power += np.histogram(frequency, edges, weights=2 * np.abs(np.fft.rfft(x)) ** 2 / len(x))[0]
            total += len(x)
        lines.append((name, role, 0.5 * (edges[1:] + edges[:-1]), np.sqrt(power / max(total, 1))))
    shown.chart(out, "error by frequency", shown.label("frequency"), f"RMS in {BAND_HZ:g} Hz", lines)


def encoders(out, shown, _):
    """The disagreement between the joint's encoders over its position."""
    channels, lines = shown.channels("E"), []
    q = np.concatenate([shown.found.search.all_terms[c.record].grid("q", shown.number)[c.rows] for c in channels])
    edges = np.unique(np.quantile(q, np.linspace(0, 1, ENCODER_BINS + 1)))
    place = np.clip(np.searchsorted(edges, q, side="right") - 1, 0, len(edges) - 2)
    for name, role, residuals in shown.fits:
        left = np.concatenate([residuals.of[c.record, "E"][c.rows] for c in channels])
        mean = np.bincount(place, left, len(edges) - 1) / np.maximum(np.bincount(place, minlength=len(edges) - 1), 1)
        lines.append((name, role, 0.5 * (edges[1:] + edges[:-1]), 1e3 * mean))
    out.chart(f"{shown.joint}: encoders' disagreement over position", shown.label("encoder"), "difference [mrad]", lines)


def envelope(t, *lines):
    """A time axis and lines with the extremes of each stretch: what a screen can show of a long recording."""
    every = -(-2 * len(t) // MOST_POINTS)
    if every <= 2:
        return t, lines
    cut = len(t) // every * every
    stretch = t[:cut].reshape(-1, every)
    out = []
    for y in lines:
        rows = y[:cut].reshape(-1, every)
        hidden = np.isnan(rows).all(1)
        low, high = (np.where(hidden, np.nan, f(np.where(np.isnan(rows), -s * np.inf, rows), 1))
                     for f, s in ((np.min, -1), (np.max, 1)))  # fmt: skip
        out.append(np.column_stack([low, high]).ravel())
    return np.column_stack([stretch[:, 0], stretch[:, every // 2]]).ravel(), out


def worst_stretch(found, number):
    """(record, slice) of the SHOWN_S in which the identified model's scored error is largest."""
    best = None
    for record, processed in enumerate(found.search.dataset.processed_recordings):
        if (record, f"T{number}") not in found.before.of:
            continue
        error = np.where(processed.kind[number] == 1, found.before.of[record, f"T{number}"], 0.0)
        length = min(round(SHOWN_S / processed.step_s), len(error))
        total = np.concatenate([[0.0], np.cumsum(error**2)])
        power = total[length:] - total[:-length]
        begin = int(np.argmax(power))
        if best is None or power[begin] > best[0]:
            best = power[begin], record, slice(begin, begin + length)
    return best[1:] if best else (None, None)


def over_time(out, found):
    out.heading("Measured against predicted")
    for number, joint in enumerate(found.search.dataset.model.joints):
        record, part = worst_stretch(found, number)
        if record is not None:
            over_stretch(out, found, number, joint, record, part)


def over_stretch(out, found, number, joint, record, part):
    """Measured, predicted and errors of one joint in a stretch of a recording."""
    processed, unit = found.search.dataset.processed_recordings[record], found.report["gap"][joint]["unit"]
    before, after = (r.of[record, f"T{number}"][part] for r in (found.before, found.after))
    kept, scored = (np.where(kind, 0.0, np.nan) for kind in (processed.kind[number][part] != 0, processed.kind[number][part] == 1))
    measured = processed.measured[number][part] + kept
    t, (measured, predicted, before, after) = envelope(processed.grid_t_s[part], measured, measured - after, before + scored,
                                                       after + scored)  # fmt: skip
    last = ("with effects", "extended") if found.fit.chosen else ("identified", "identified")
    beneath = [("identified", "identified", t, before), *([(*last, t, after)] if found.fit.chosen else [])]
    out.chart(f"{joint}: the {t[-1] - t[0]:.0f} s of {Path(processed.name).name} with the largest error", "time [s]",
              f"{'torque' if unit == 'Nm' else 'force'} [{unit}]",
              [("measured", "measured", t, measured), (*last, t, predicted)], below=(f"error [{unit}]", beneath))  # fmt: skip
