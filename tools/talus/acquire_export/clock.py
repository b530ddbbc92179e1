"""The instants of an even clock's ticks, from the stamps of frames that left after them.

    line = tick_line(points, period_s, zero_ns, store)   # spools of (number, stamp_ns) and of (number, time_ns), numbers rising

A frame is stamped some time after the tick at which its payload was measured: never before, and most of the
time by little. So the ticks lie on the line that touches the stamps from below. The sender's clock and the host's
drift against each other; the line is therefore drawn in windows that overlap, and passes from one to the next.
They do not drift by more than some parts in ten thousand: where frames were late for seconds on end, that bounds how
far the line may follow them from where they were not.
"""

import numpy as np

from .ranks import median

WINDOW_S = 10.0
MOST_TICKS = 200_000  # of a window
GROUPS = 2000  # stretches of a window, each with its lowest point
FEW = 64  # points of which the hull is made one by one
MOST_DRIFT = 600e-6  # of one clock against the other, from its usual rate; a clock that is being set slews by 500e-6


def support_line(x, y):
    """(a, b): a + b x lies on no point of (x, y) from above, and is as near to all of them as such a line can be."""
    middle, hull = x.mean(), []
    for point in zip(*(column.tolist() for column in without_inner(x, y)), strict=True):
        while len(hull) > 1 and turns_up(hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    if len(hull) == 1:
        return hull[0][1], 0.0
    right = min(max(int(np.searchsorted([p[0] for p in hull], middle)), 1), len(hull) - 1)
    (x0, y0), (x1, y1) = hull[right - 1], hull[right]
    slope = (y1 - y0) / (x1 - x0)
    return y0 - slope * x0, slope


def without_inner(x, y):
    """Without points that lie on or above the line between their neighbours: no hull from below has them."""
    while len(x) > FEW:
        outer = np.ones(len(x), bool)
        outer[1:-1] = (y[1:-1] - y[:-2]) * (x[2:] - x[:-2]) < (y[2:] - y[:-2]) * (x[1:-1] - x[:-2])
        if outer.all():
            break
        x, y = x[outer], y[outer]
    return x, y


def turns_up(a, b, c):
    """Does b lie on or above the line from a to c?"""
    return (b[1] - a[1]) * (c[0] - a[0]) >= (c[1] - a[1]) * (b[0] - a[0])


def lowest_per_group(x, y, groups):
    """The first point of lowest y in each of so many even stretches of x: what the hull needs of them."""
    group = np.minimum(((x - x[0]) * groups // (x[-1] - x[0] + 1)).astype(np.int64), groups - 1)
    starts = np.flatnonzero(np.append(True, np.diff(group) > 0))
    least = np.repeat(np.minimum.reduceat(y, starts), np.diff(np.append(starts, len(y))))
    chosen = np.flatnonzero(y == least)
    chosen = chosen[np.append(True, np.diff(group[chosen]) > 0)]
    return x[chosen], y[chosen]


class Points:
    """(x, y) of ticks, chunk by chunk: the tick from the first one on, and its stamp less a straight line."""

    def __init__(self, spool, zero_ns):
        self.spool, self.zero_ns = spool, zero_ns
        first, last = (int(spool.read(k, k + 1)["number"][0]) for k in (0, len(spool) - 1))
        self.first, self.span = first, float(last - first)

    def chunks(self, slope):
        for rows in self.spool.chunks():
            x = (rows["number"] - self.first).astype(float)
            yield x, (rows["stamp_ns"] - self.zero_ns).astype(float) - slope * x


def envelope(chunks, slope):
    """The highest function below the points of chunks() that is nowhere steeper than `slope`, chunk by chunk."""
    behind = np.array([np.min(y + slope * x) for x, y in chunks()])
    behind = np.append(np.minimum.accumulate(behind[::-1])[::-1][1:], np.inf)  # the least of all later chunks
    before = np.inf
    for (x, y), least in zip(chunks(), behind, strict=True):
        lowest = np.minimum.accumulate(np.append(before, y - slope * x))[1:]
        falling = np.minimum.accumulate(np.append(least, (y + slope * x)[::-1]))[1:][::-1] - slope * x
        before = lowest[-1]
        yield x, np.minimum(lowest + slope * x, falling)


def windows(chunks, width, span):
    """(centre, number of its first point, x, y) of windows that overlap by half; only those that may hold points, however far
    those lie apart."""
    half, last = width / 2, max(int(np.ceil(max(span - width / 2, 0.0) / (width / 2))), 0)
    x, y, first, waiting, newest = np.empty(0), np.empty(0), 0, [], -1

    def window(number):
        inside = slice(*np.searchsorted(x, ((number - 1) * half, (number + 1) * half + 0.5)))
        return number * half, first + inside.start, x[inside], y[inside]

    for more_x, more_y in chunks:
        cells = np.unique(np.floor(more_x / half))
        numbers = np.unique(np.concatenate([cells, cells + 1]))
        waiting += numbers[(numbers <= last) & (numbers > newest)].tolist()
        newest = max(newest, numbers[-1])
        x, y = np.append(x, more_x), np.append(y, more_y)
        while waiting and x[-1] >= (waiting[0] + 1) * half + 0.5:
            yield window(waiting.pop(0))
        done = int(np.searchsorted(x, (waiting[0] - 1) * half)) if waiting else max(len(x) - 1, 0)
        x, y, first = x[done:], y[done:], first + done
    for number in waiting:
        yield window(number)


def usual_slope(points, width, slope, store):
    """The slope of the line below the points in those windows in which they lie nearest to it."""
    found, least = store.spool([("slope", "f8"), ("height", "f8")]), np.inf
    for _, _, x, y in windows(points.chunks(slope), width, points.span):
        if len(x) > 1:
            level, rise = support_line(*lowest_per_group(x, y, GROUPS))
            height = np.median(y - level - rise * x)
            found.append_columns([rise], [height])
            least = min(least, height)
    if not len(found):
        return 0.0
    return median(lambda: (rows["slope"][rows["height"] <= 2 * least + 1.0] for rows in found.chunks()))


def tick_line(spool, period_s, zero_ns, store):
    """Instants [ns, float from zero_ns on] of rising ticks: a spool of (number, time_ns) in `store`."""
    points, out = Points(spool, zero_ns), store.spool([("number", "i8"), ("time_ns", "f8")])
    width = max(min(WINDOW_S / period_s, MOST_TICKS), 2.0)
    nominal = period_s * 1e9 + usual_slope(points, width, period_s * 1e9, store)
    low = store.spool([("x", "f8"), ("y", "f8")])
    for x, y in envelope(lambda: points.chunks(nominal), MOST_DRIFT * nominal):  # drift, and some delay, are left
        low.append_columns(x, y)
    total, weight, done = np.empty(0), np.empty(0), 0

    def finish(count):
        rows = low.read(done, done + count)
        share = np.where(weight[:count] == 0, 1.0, weight[:count])
        level = np.where(weight[:count] == 0, rows["y"], total[:count])
        out.append_columns(rows["x"].astype(np.int64) + points.first, level / share + nominal * rows["x"])

    def grown(column, count):
        return np.append(column, np.zeros(max(count - len(column), 0)))

    for centre, first, x, y in windows(((rows["x"], rows["y"]) for rows in low.chunks()), width, points.span):
        if len(x) < 2:
            continue
        total, weight = grown(total, first + len(x) - done), grown(weight, first + len(x) - done)
        finish(first - done)
        total, weight, done = total[first - done:], weight[first - done:], first
        level, slope = support_line(*lowest_per_group(x, y, GROUPS))
        share = 1.0 - np.abs(x - centre) / (width / 2 + 1.0)
        total[:len(x)] += share * (level + slope * x)
        weight[:len(x)] += share
    while done < len(low):
        count = min(max(len(total), 1 << 14), len(low) - done)
        total, weight = grown(total, count), grown(weight, count)
        finish(count)
        total, weight, done = total[count:], weight[count:], done + count
    return out
