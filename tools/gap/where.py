"""Where the gap lies: maps of the residual over coordinates, each with its share of the systematic energy.

A map bins the residual on a coordinate and takes the squares of the bins' means, less what noise alone puts there.
Friction's residual changes its sign with direction, so every map but that of velocity has two halves.
"""

import numpy as np

BINS = 24
ORDERS = (*range(1, 33), 36, 40, 42, 48, 54, 60, 72, 84)
BAND_HALF_WIDTH = 0.15  # of the frequency
LEAST_SHARE = 0.02


class Map:
    """Bin means of one joint's residual over one coordinate."""

    def __init__(self, coordinate, centre, mean, energy, number):
        self.coordinate, self.centre, self.mean, self.energy, self.number = coordinate, centre, mean, energy, number

    def range(self):
        """Where the energy concentrates: the shortest run of bins with half of it."""
        power = self.number * self.mean**2
        total = np.concatenate([[0.0], np.cumsum(power)])
        runs = [(b - a, a, b) for a in range(len(power)) for b in range(a + 1, len(power) + 1)
                if total[b] - total[a] >= 0.5 * total[-1]]  # fmt: skip
        if not runs:
            return [0.0, 0.0]
        _, a, b = min(runs)
        return [float(self.centre[a]), float(self.centre[b - 1])]


def bin_map(coordinate, values, direction, residual, variance):
    """The map over `values`; its energy is in units of the residual's variance."""
    edges = np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1)))
    if len(edges) < 3:
        return None
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    half = (direction < 0).astype(int)
    cell = place * 2 + half
    number = np.bincount(cell, minlength=2 * (len(edges) - 1)).astype(float)
    mean = np.bincount(cell, residual, minlength=len(number)) / np.maximum(number, 1)
    energy = float((number * mean**2).sum()) - variance * (number > 0).sum()
    number, mean = number.reshape(-1, 2), mean.reshape(-1, 2)
    signed = (number * mean * [1, -1]).sum(1) / np.maximum(number.sum(1), 1)
    plain = (number * mean).sum(1) / np.maximum(number.sum(1), 1)
    shown = plain if (plain**2).sum() > (signed**2).sum() else signed
    return Map(coordinate, 0.5 * (edges[1:] + edges[:-1]), shown, energy, number.sum(1))


def coordinates(search, record, joint):
    """Coordinates of one joint on the grid."""
    scene, track = search.scenes[record], search.evidence.tracks[record]
    slip = track.resample(scene.slip[joint])
    stopped = np.flatnonzero(np.diff(np.sign(track.resample(scene.v[joint]))) != 0)
    t = track.grid_t_s
    since = t - t[np.maximum(stopped[np.searchsorted(stopped, np.arange(len(t)), side="right") - 1], 0)] if len(
        stopped) else t - t[0]
    return {
        "direction": slip,
        "position": scene.grid("q", joint),
        "velocity": scene.grid("v", joint),
        "acceleration": track.resample(track.bridge(scene.a[joint], joint)),
        "load": scene.grid("link_Nm", joint),
        "current": scene.grid("motor_Nm", joint),
        "time": t,
        "reversal": np.clip(since, 0, 1.0),
        "motor_angle": scene.grid("motor_rad", joint),
    }


def order_map(angle, residual):
    """Energy of the strongest order of the motor's angle, and the order."""
    best = (0.0, 0)
    for order in ORDERS:
        wave = np.exp(1j * order * angle)
        best = max(best, (2 * abs(np.mean(residual * wave)) ** 2 * len(residual), order))
    return best


def band_map(residual, step_s):
    """Energy of the strongest band, and the band [Hz]."""
    power = np.abs(np.fft.rfft(residual * np.hanning(len(residual)))) ** 2
    frequency = np.fft.rfftfreq(len(residual), step_s)
    total, best = power.sum() + 1e-300, (0.0, 0.0)
    for hz in np.geomspace(0.5, 25, 60):
        inside = (frequency > (1 - BAND_HALF_WIDTH) * hz) & (frequency < (1 + BAND_HALF_WIDTH) * hz)
        best = max(best, (float(power[inside].sum() / total), float(hz)))
    return best[0] * float(residual @ residual), [(1 - BAND_HALF_WIDTH) * best[1], (1 + BAND_HALF_WIDTH) * best[1]]


def joint_maps(search, residuals, joint):
    """(excess energy over noise, maps, order, band) of one joint over all recordings, energies over the noise."""
    evidence, gathered = search.evidence, {}
    channels = [c for c in evidence.channels if c.kind == f"T{joint}"]
    left, bands = [], []
    for channel in channels:
        residual = residuals.of[channel.record, channel.kind][channel.rows] / evidence.sigma[channel.kind]
        left.append(residual)
        bands.append(band_map(residual, evidence.tracks[channel.record].step_s))
        for name, values in coordinates(search, channel.record, joint).items():
            gathered.setdefault(name, []).append(values[channel.rows])
    gathered = {name: np.concatenate(values) for name, values in gathered.items()}
    residual, direction = np.concatenate(left), gathered.pop("direction")
    variance = float(np.mean([evidence.bandwidth[c.record] for c in channels]))
    excess = float(residual @ residual) - variance * len(residual)
    one_sided = np.ones_like(direction)
    order = order_map(gathered.pop("motor_angle"), residual)
    maps = [bin_map(n, v, one_sided if n == "velocity" else direction, residual, variance) for n, v in gathered.items()]
    strongest = max(bands, key=lambda band: band[0])
    # white noise puts the band's own width of it there
    band_energy = sum(b[0] for b in bands) - variance * len(residual) * 2 * BAND_HALF_WIDTH * strongest[1][0] / 30
    return excess, [m for m in maps if m is not None], order, (band_energy, strongest[1])


def where(search, residuals):
    """(`where` of the report, maps by joint). Shares are of the excess energy of all channels over their noise."""
    evidence, found, maps = search.evidence, [], {}
    excess, encoders = {}, 0.0
    for joint, name in enumerate(evidence.model.joints):
        own, maps[name], order, band = joint_maps(search, residuals, joint)
        excess[name] = max(own, 0.0)
        if own <= 0:
            continue
        entries = [(m.energy, m.coordinate, m.range()) for m in maps[name]]
        entries += [(order[0], "motor_angle", [order[1], order[1]]), (band[0], "frequency", band[1])]
        found += [(min(energy, own), name, coordinate, span) for energy, coordinate, span in entries]
    for channel in evidence.channels:
        if channel.kind == "E":
            residual = residuals.of[channel.record, "E"][channel.rows] / evidence.sigma["E"]
            encoders += max(float(residual @ residual) - evidence.bandwidth[channel.record] * len(residual), 0.0)
    total = sum(excess.values()) + encoders
    if encoders > 0:
        q = search.scenes[0].q[1]
        found.append((encoders, "ankle", "encoder", [float(q.min()), float(q.max())]))
    found.sort(key=lambda entry: -entry[0])
    entries = [{"joint": joint, "coordinate": coordinate, "share": float(energy / total), "range": span}
               for energy, joint, coordinate, span in found if total > 0 and energy > LEAST_SHARE * total]  # fmt: skip
    return entries, maps
