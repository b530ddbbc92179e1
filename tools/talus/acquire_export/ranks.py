"""Exact order statistics of more numbers than memory holds.

    ranked(chunks, [5, 6])          # chunks(): an iterator of arrays, called anew for each pass
    median(chunks), quantiles(chunks, (0.5, 0.999, 1.0))   # as NumPy's
"""

import numpy as np

MOST_HELD = 200_000
BINS = 4096


def within(chunks, low, high):
    for chunk in chunks():
        yield chunk if low is None else chunk[(chunk >= low) & (chunk <= high)]


def held(chunks, low, high):
    """All in order, or None when there are too many."""
    parts, count = [], 0
    for chunk in within(chunks, low, high):
        count += len(chunk)
        if count > MOST_HELD:
            return None
        parts.append(chunk)
    return np.sort(np.concatenate(parts)) if parts else np.empty(0)


def limits(chunks, low, high, inside=lambda chunk: chunk):
    """(least, greatest, how many)."""
    found = [(part.min(), part.max(), len(part)) for chunk in within(chunks, low, high) if len(part := inside(chunk))]
    least, most, count = zip(*found, strict=True)
    return min(least), max(most), sum(count)


def ranked(chunks, rank):
    """The number that stands at this place among all, from 0 on."""
    low = high = None
    while (values := held(chunks, low, high)) is None:
        low, high, _ = limits(chunks, low, high)
        if low == high:
            return float(low)
        scale = BINS / (float(high) - float(low))

        def bins(chunk, low=low, scale=scale):
            return np.minimum(((chunk - low) * scale).astype(np.int64), BINS - 1)

        count = sum(np.bincount(bins(chunk), minlength=BINS) for chunk in within(chunks, low, high))
        chosen = int(np.searchsorted(np.cumsum(count), rank, "right"))
        rank -= int(count[:chosen].sum())
        low, high, _ = limits(chunks, low, high, lambda chunk, bins=bins, chosen=chosen: chunk[bins(chunk) == chosen])
    return float(values[rank])


def median(chunks):
    """None of no numbers."""
    found = quantiles(chunks, (0.5,))
    return found[0] if found else None


def quantiles(chunks, shares):
    """Straight between neighbours, as np.quantile; [] of no numbers."""
    count = sum(len(chunk) for chunk in chunks())
    if not count:
        return []
    out = []
    for share in shares:
        place = share * (count - 1)
        below = int(place)
        a = ranked(chunks, below)
        b = ranked(chunks, min(below + 1, count - 1)) if place > below else a
        t = place - below
        out.append(a + (b - a) * t if t < 0.5 else b - (b - a) * (1 - t))
    return out
