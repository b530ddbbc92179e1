"""Where the gap lies: maps of the residual over coordinates, each with its share of the systematic energy.

A map bins the residual on a coordinate and takes the squares of the bins' means, less what noise alone puts there.
Friction's residual changes its sign with direction, so every map but that of velocity has two halves.
"""

import numpy as np

BINS = 24
ORDERS = (*range(1, 33), 36, 40, 42, 48, 54, 60, 72, 84)
ORDER_SPEEDS = 12
BAND_HALF_WIDTH = 0.15  # of the frequency
BANDS_HZ = np.geomspace(0.5, 25, 60)
LOWPASS_HZ = 30.0
LEAST_SHARE = 0.05
LONGEST_S = 1.0  # since a reversal
TINY = 1e-12
LEADS_FROM = 0.5  # of the largest, for a map that suits the named cause
GENERIC = {"frequency": 0.8}  # anything with a rhythm shows over frequency: it leads where it leads clearly


class Map:
    """Bin means of one joint's residual over one coordinate, and what the blocks add to them."""

    def __init__(self, coordinate, centre, mean, number):
        self.coordinate, self.centre, self.mean, self.number = coordinate, centre, mean, number
        self.energy, self.deviations = 0.0, 0.0

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


class Rest:
    """One joint's residual over its noise on the scored rows of all recordings."""

    def __init__(self, residual, block, variance):
        self.residual, self.variance = residual, variance
        self.names, self.block = np.unique(block, return_inverse=True)
        self.excess = self.per_block(residual**2 - variance)

    def per_block(self, values):
        return np.bincount(self.block, values, minlength=len(self.names))

    def without_each(self, sums):
        """Sums over all blocks but one, for each: (blocks, ...)."""
        return sums.sum(0) - sums


def deviation(shares):
    """Standard deviation of a share by the jackknife: `shares` without each block."""
    count = len(shares)
    return float(np.sqrt((count - 1) / count * ((shares - shares.mean()) ** 2).sum())) if count > 1 else 0.0


def bin_map(coordinate, values, direction, rest):
    """The map over `values`; its energy is in units of the noise's variance at the samples."""
    edges = np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1)))
    if len(edges) < 3:
        return None
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    cells = 2 * (len(edges) - 1)
    cell = rest.block * cells + place * 2 + (direction < 0)
    number = np.bincount(cell, minlength=len(rest.names) * cells).reshape(-1, cells).astype(float)
    total = np.bincount(cell, rest.residual, minlength=number.size).reshape(-1, cells)

    def energy(n, s):
        return (s * s / np.maximum(n, 1)).sum(-1) - rest.variance * (n > 0).sum(-1)

    n, mean = number.sum(0).reshape(-1, 2), (total.sum(0) / np.maximum(number.sum(0), 1)).reshape(-1, 2)
    signed = (n * mean * [1, -1]).sum(1) / np.maximum(n.sum(1), 1)
    plain = (n * mean).sum(1) / np.maximum(n.sum(1), 1)
    shown = plain if (plain**2).sum() > (signed**2).sum() else signed
    out = Map(coordinate, 0.5 * (edges[1:] + edges[:-1]), shown, n.sum(1))
    out.energy = float(energy(number.sum(0), total.sum(0)))
    out.deviations = out.energy / (rest.variance * np.sqrt(2 * (n > 0).sum()))
    left = energy(rest.without_each(number), rest.without_each(total))
    out.spread = deviation(left / np.maximum(rest.without_each(rest.excess), TINY))
    return out


def since_reversal(t_s, values):
    """Time since the last change of sign, up to LONGEST_S."""
    turned = np.flatnonzero(np.diff(np.sign(values)) != 0)
    last = turned[np.maximum(np.searchsorted(turned, np.arange(len(t_s)), side="right") - 1, 0)] if len(turned) else 0
    return np.clip(t_s - t_s[last], 0, LONGEST_S)


def coordinates(search, record, joint):
    """Coordinates of one joint on the grid."""
    terms, processed = search.all_terms[record], search.dataset.processed_recordings[record]
    slip = processed.resample(terms.slip[joint])
    t = processed.grid_t_s
    return {
        "direction": slip,
        "position": terms.grid("q", joint),
        "velocity": terms.grid("v", joint),
        "acceleration": processed.resample(processed.bridge(terms.a[joint], joint)),
        "load": terms.grid("link_Nm", joint),
        "current": terms.grid("motor_Nm", joint),
        "time": t,
        "reversal": since_reversal(t, processed.resample(terms.v[joint])),
        "load reversal": since_reversal(t, terms.grid("link_Nm", joint)),
        "motor_angle": terms.grid("motor_rad", joint),
    }


def order_map(angle, speed, rest):
    """The strongest order of the motor's angle. A ripple's size and phase in the current change with its frequency, so
    each range of speeds has its own."""
    edges = np.unique(np.quantile(speed, np.linspace(0, 1, ORDER_SPEEDS + 1)))
    cells = max(len(edges) - 1, 1)
    cell = rest.block * cells + np.clip(np.searchsorted(edges, speed, side="right") - 1, 0, cells - 1)

    def sums(values):
        return np.bincount(cell, values, minlength=len(rest.names) * cells).reshape(-1, cells)

    def energy(wave, n):
        return (2 * np.abs(wave) ** 2 / np.maximum(n, 1) - 2 * rest.variance * (n > 0)).sum(-1)

    def waves(order):
        wave = np.exp(1j * order * angle) * rest.residual
        return sums(wave.real) + 1j * sums(wave.imag)

    number = sums(np.ones(len(angle)))
    best = max(ORDERS, key=lambda order: energy(waves(order).sum(0), number.sum(0)))
    left = energy(rest.without_each(waves(best)), rest.without_each(number))
    noise = 2 * rest.variance * np.sqrt(cells)
    return Entry("motor_angle", [best, best], energy(waves(best).sum(0), number.sum(0)), noise,
                 deviation(left / np.maximum(rest.without_each(rest.excess), TINY)))  # fmt: skip


def band_map(pieces, steps_s, rest):
    """The strongest band of the residual, whose recordings are `pieces`."""
    transforms = [(np.fft.rfft(x), np.fft.rfftfreq(len(x), h), len(x)) for x, h in zip(pieces, steps_s)]

    def inside(frequency, hz):
        return (frequency > (1 - BAND_HALF_WIDTH) * hz) & (frequency < (1 + BAND_HALF_WIDTH) * hz)

    def power(hz):
        return sum(2 * (np.abs(x[inside(f, hz)]) ** 2).sum() / n for x, f, n in transforms)

    best = max(BANDS_HZ, key=power)
    kept = np.concatenate([np.fft.irfft(np.where(inside(f, best), x, 0), n) for x, f, n in transforms])
    # white noise puts the band's own width of it there
    noise = rest.variance * 2 * BAND_HALF_WIDTH * best / LOWPASS_HZ
    sums = rest.per_block(kept**2 - noise)
    left = rest.without_each(sums) / np.maximum(rest.without_each(rest.excess), TINY)
    return Entry("frequency", [(1 - BAND_HALF_WIDTH) * best, (1 + BAND_HALF_WIDTH) * best], sums.sum(),
                 np.sqrt(2 * len(kept) * noise * rest.variance), deviation(left))  # fmt: skip


class Entry:
    """A place of the gap: its energy, the deviation of that in noise alone, and of its share by the blocks."""

    def __init__(self, coordinate, span, energy, noise, spread):
        self.coordinate, self.span, self.energy = coordinate, span, float(energy)
        self.deviations, self.spread = float(energy / noise), spread


def joint_maps(search, residuals, joint):
    """(excess energy over noise, maps, entries) of one joint over all recordings, energies over the noise."""
    dataset, gathered = search.dataset, {}
    channels = [c for c in dataset.channels if c.kind == f"T{joint}" and len(c.rows)]
    if not channels:
        return 0.0, [], []
    pieces = [residuals.of[c.record, c.kind][c.rows] / dataset.sigma[c.kind] for c in channels]
    for channel in channels:
        for name, values in coordinates(search, channel.record, joint).items():
            gathered.setdefault(name, []).append(values[channel.rows])
    gathered = {name: np.concatenate(values) for name, values in gathered.items()}
    block = np.concatenate([dataset.block_of[c.record][c.rows] for c in channels])
    rest = Rest(np.concatenate(pieces), block, float(np.mean([dataset.bandwidth[c.record] for c in channels])))
    direction, angle = gathered.pop("direction"), gathered.pop("motor_angle")
    halves = {"velocity": np.ones_like(direction), "load reversal": np.sign(gathered["load"])}
    maps = [bin_map(n, v, halves.get(n, direction), rest) for n, v in gathered.items()]
    maps = plainest([m for m in maps if m is not None])
    entries = [Entry(m.coordinate, m.range(), m.energy, m.energy / m.deviations, m.spread) for m in maps if m.energy > 0]
    steps_s = [dataset.processed_recordings[c.record].step_s for c in channels]
    entries += [order_map(angle, gathered["velocity"], rest), band_map(pieces, steps_s, rest)]
    return float(rest.excess.sum()), maps, entries


def plainest(maps):
    """Both reversals bear one name: that of the motion or that of the load, whichever shows more."""
    both = [m for m in maps if m.coordinate.endswith("reversal")]
    kept = max(both, key=lambda m: m.energy, default=None)
    out = [m for m in maps if m is kept or m not in both]
    if kept:
        kept.coordinate = "reversal"
    return out


def encoder_excess(search, residuals):
    """Excess of the disagreement between the ankle's encoders, by block."""
    dataset, out = search.dataset, np.zeros(search.dataset.blocks)
    for channel in dataset.channels:
        if channel.kind == "E":
            residual = residuals.of[channel.record, "E"][channel.rows] / dataset.sigma["E"]
            over = residual**2 - dataset.bandwidth[channel.record]
            out += np.bincount(dataset.block_of[channel.record][channel.rows], over, minlength=len(out))
    return out


def where(search, residuals, cause=None):
    """(`where` of the report, maps by joint). Shares are of the excess energy of all channels over their noise.

    Maps overlap (a constant shows over anything): of each joint the first explains what it explains, and the others at
    most what that one leaves. First is the largest; or, if it holds half as much, one that suits the named `cause`, an
    (effect, joint)."""
    dataset, found, maps = search.dataset, [], {}
    suits = dataset.effects[cause[0]].coordinates if cause else ()
    total = encoders = max(float(encoder_excess(search, residuals).sum()), 0.0)
    for joint, name in enumerate(dataset.model.joints):
        own, maps[name], entries = joint_maps(search, residuals, joint)
        total += max(own, 0.0)
        found += shared(own, name, entries, cause, suits) if own > 0 else []
    if encoders > 0:
        q = search.all_terms[0].q[1]
        freedom = sum(dataset.bandwidth[c.record] * len(c.rows) for c in dataset.channels if c.kind == "E")
        entry = Entry("encoder", [float(q.min()), float(q.max())], encoders, np.sqrt(2 * freedom), 0.0)
        found.append((encoders, encoders, "ankle", entry))
    found = [f for f in found if total > 0 and f[0] > LEAST_SHARE * total]
    found.sort(key=lambda f: -f[0])
    return [written(*f, total) for f in found], maps


def shared(own, joint, entries, cause, suits):
    """[(energy, energy of the joint, joint, entry)] of one joint, the leading one first; `suits` are the cause's coordinates."""
    energy = {e: min(e.energy, own) for e in entries}
    ranked = sorted(entries, key=lambda e: -energy[e] * GENERIC.get(e.coordinate, 1.0))
    if cause and cause[1] in (joint, "base"):
        enough = LEADS_FROM * energy[ranked[0]]
        suited = [e for e in ranked if e.coordinate in suits and energy[e] >= enough]
        ranked.sort(key=lambda e: e not in suited[:1])
    lead = energy[ranked[0]]
    return [(lead if e is ranked[0] else min(energy[e], lead, own - lead), own, joint, e) for e in ranked]


def written(energy, own, joint, entry, total):
    """One entry of the report."""
    share, half = energy / total, 1.96 * entry.spread * own / total
    return {"joint": joint, "coordinate": entry.coordinate, "share": float(share), "range": entry.span,
            "interval": [float(max(share - half, 0.0)), float(min(share + half, 1.0))],
            "deviations": entry.deviations}  # fmt: skip
