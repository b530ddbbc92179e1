"""The instants of an even clock's ticks, from the stamps of frames that left after them.

    t_ns = tick_times(tick, stamp_ns, period_s)      # for every tick in `tick`

A frame is stamped some time after the tick at which its payload was measured: never before, and most of the
time by little. So the ticks lie on the line that touches the stamps from below. The sender's clock and the host's
drift against each other; the line is therefore drawn in windows that overlap, and passes from one to the next.
They do not drift by more than some parts in ten thousand: where frames were late for seconds on end, that bounds how
far the line may follow them from where they were not.
"""

import numpy as np

WINDOW_S = 10.0
GROUPS = 2000  # stretches of a window, each with its lowest point
MOST_DRIFT = 600e-6  # of one clock against the other, from its usual rate; a clock that is being set slews by 500e-6


def support_line(x, y):
    """(a, b): a + b x lies on no point of (x, y) from above, and is as near to all of them as such a line can be."""
    hull = []
    for point in zip(x.tolist(), y.tolist(), strict=True):
        while len(hull) > 1 and turns_up(hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    if len(hull) == 1:
        return hull[0][1], 0.0
    middle = x.mean()
    right = min(max(int(np.searchsorted([p[0] for p in hull], middle)), 1), len(hull) - 1)
    (x0, y0), (x1, y1) = hull[right - 1], hull[right]
    slope = (y1 - y0) / (x1 - x0)
    return y0 - slope * x0, slope


def turns_up(a, b, c):
    """Does b lie on or above the line from a to c?"""
    return (b[1] - a[1]) * (c[0] - a[0]) >= (c[1] - a[1]) * (b[0] - a[0])


def envelope(x, y, slope):
    """The highest function below y that is nowhere steeper than `slope`."""
    rising = np.minimum.accumulate(y - slope * x) + slope * x
    falling = np.minimum.accumulate((y + slope * x)[::-1])[::-1] - slope * x
    return np.minimum(rising, falling)


def lowest_per_group(x, y, groups):
    """The point of lowest y in each of so many even stretches of x: what the hull needs of them."""
    group = np.minimum(((x - x[0]) * groups // (x[-1] - x[0] + 1)).astype(np.int64), groups - 1)
    order = np.lexsort((y, group))
    first = np.append(True, np.diff(group[order]) > 0)
    chosen = np.sort(order[first])
    return x[chosen], y[chosen]


def windows(x, width):
    """(centre, which points) of windows that overlap by half; only those that may hold points, however far those lie apart."""
    last = max(int(np.ceil(max(x[-1] - width / 2, 0.0) / (width / 2))), 0)
    near = np.unique(np.floor(x / (width / 2)))
    numbers = np.unique(np.concatenate([near, near + 1]))
    for centre in numbers[numbers <= last] * (width / 2):
        inside = slice(*np.searchsorted(x, (centre - width / 2, centre + width / 2 + 0.5)))
        if inside.stop - inside.start > 1:
            yield centre, inside


def usual_slope(x, y, width):
    """The slope of the line below the points in those windows in which they lie nearest to it."""
    slopes, heights = [], []
    for _, inside in windows(x, width):
        level, slope = support_line(*lowest_per_group(x[inside], y[inside], GROUPS))
        slopes.append(slope)
        heights.append(np.median(y[inside] - level - slope * x[inside]))
    if not slopes:
        return 0.0
    best = np.array(heights) <= 2 * min(heights) + 1.0
    return float(np.median(np.array(slopes)[best]))


def tick_times(tick, stamp_ns, period_s):
    """Instants [ns, float from the first stamp on] for each of the rising ticks, and that first stamp."""
    zero = int(stamp_ns.min())
    x = (tick - tick[0]).astype(float)
    y = (stamp_ns - zero).astype(float) - period_s * 1e9 * x
    width = max(WINDOW_S / period_s, 2.0)
    nominal = period_s * 1e9 + usual_slope(x, y, width)
    y = envelope(x, (stamp_ns - zero) - nominal * x, MOST_DRIFT * nominal)  # drift, and some delay, are left
    total, weight = np.zeros(len(x)), np.zeros(len(x))
    for centre, inside in windows(x, width):
        level, slope = support_line(*lowest_per_group(x[inside], y[inside], GROUPS))
        share = 1.0 - np.abs(x[inside] - centre) / (width / 2 + 1.0)
        total[inside] += share * (level + slope * x[inside])
        weight[inside] += share
    alone = weight == 0
    total[alone], weight[alone] = y[alone], 1.0
    return total / weight + nominal * x, zero
