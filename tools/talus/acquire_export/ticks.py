"""The ticks that the counters of one sender number, and their instants; a sender that begins anew has a line of ticks for each of its
lives."""

import numpy as np

from .clock import MOST_DRIFT, tick_line
from .lives import shared
from .spool import interpolate

DELAY_S = 0.02  # by which a frame may come late and still be known by its stamp


class Life:
    """One life of a group's sender, {stream: lives of it}, and its ticks."""

    def __init__(self, members, store):
        self.points = store.spool([("number", "i8"), ("stamp_ns", "i8")])
        self.zero_ns = min(self.earliest(rows) for rows in merge([trusted_in(*member) for member in members.items()]))

    def earliest(self, rows):
        """Appends each number's earliest stamp; the earliest of all."""
        rows = rows[np.lexsort((rows["stamp_ns"], rows["number"]))]
        rows = rows[np.append(True, np.diff(rows["number"]) > 0)]
        self.points.append_columns(rows["number"], rows["stamp_ns"])
        return int(rows["stamp_ns"].min())

    def draw(self, period_s, zero_ns, store):
        self.period_ns = period_s * 1e9
        self.ticks = tick_line(self.points, period_s, zero_ns, store)
        (self.first, self.last) = (self.ticks.read(k, k + 1)[0] for k in (0, len(self.ticks) - 1))

    def time_of(self, number):
        """Instants of any rising ticks, from those whose frames came in order."""
        inside = interpolate(self.ticks, "number", "time_ns", number)
        beyond = np.minimum(number - self.first["number"], 0) + np.maximum(number - self.last["number"], 0)
        return inside + beyond * self.period_ns


class TickGroup:
    """Messages of one sender whose counters number the same ticks."""

    def __init__(self, streams, store):
        self.streams, self.period_s = streams, streams[0].message.cycle_s
        self.lives, self.begins, end = [], [], None  # begins: their first numbers
        for members in lives_of(streams):
            first, end = put_behind(members, end)
            self.begins.append(first)
            self.lives.append(Life(members, store))
        self.zero_ns = min(life.zero_ns for life in self.lives)
        for life in self.lives:
            life.draw(self.period_s, self.zero_ns, store)

    def time_of(self, number):
        """Instants of any rising ticks [ns from zero_ns on]."""
        out, edges = np.empty(len(number)), np.append(np.searchsorted(number, self.begins), len(number))
        edges[0] = 0
        for life, first, end in zip(self.lives, edges[:-1], edges[1:], strict=True):
            if end > first:
                out[first:end] = life.time_of(number[first:end])
        return out


def lives_of(streams):
    """{stream: lives of it} of each life of the sender; what is in none is used no longer."""
    spans = [[(life, *span_ns(stream, life)) for life in range(len(stream.lives)) if next(trusted(stream, life), None) is not None]
             for stream in streams]  # fmt: skip
    found = [placed({streams[k]: lives for k, lives in members.items()}) for members in shared(spans)]
    for stream in streams:
        stream.used[:] = False
    for members in found:
        for stream, lives in members.items():
            stream.used[lives] = True
    return found


def placed(members):
    """Shifts the numbers of one life of the sender: all count the same ticks, by whole turns of their counters. Of several lives
    of a message the longest counts, and those that count the same ticks as it does."""
    of_all = [(length, stream, life) for stream, lives in members.items() for life, length in lives]
    _, stream, life = max(of_all, key=lambda one: one[0])
    reference = stream.span_of(life)[0]
    return {stream: in_step(stream, lives, reference) for stream, lives in members.items()}


def in_step(stream, lives, reference):
    longest, kept, end = max(lives, key=lambda one: one[1])[0], [], None
    for life, _ in lives:
        first, last = stream.span_of(life)
        stream.shift[life], fits = shift_of(stream, first, reference)
        behind = end is None or first["number"] + stream.shift[life] > end
        if life == longest and not behind:
            kept.clear()
        if life == longest or fits and behind:
            kept.append(life)
            end = last["number"] + stream.shift[life]
    return kept


def shift_of(stream, at, reference):
    """(what the number of a frame lacks, is it then where its stamp says)."""
    period_s, turn = stream.message.cycle_s, 1 << stream.message.counter_bits
    time_s = (int(at["stamp_ns"]) - int(reference["stamp_ns"])) / 1e9
    apart = time_s / period_s - (int(at["number"]) - int(reference["number"]))
    shift = turn * round(apart / turn)
    tolerance_s = DELAY_S + MOST_DRIFT * abs(time_s)
    return shift, abs(apart - shift) * period_s < min(tolerance_s, turn * period_s / 16)


def span_ns(stream, life):
    """The first stamp of a life, and the last and a period."""
    first, last = stream.span_of(life)
    return int(first["stamp_ns"]), int(last["stamp_ns"] + 1e9 * stream.message.cycle_s)


def put_behind(members, end):
    """Numbers of a life stand behind those of the life before, which ended at `end`. Answers its first number, and the number behind
    its last."""
    spans = [[int(row["number"] + stream.shift[life]) for row in stream.span_of(life)] for stream, lives in members.items() for life in lives]
    least, most = min(first for first, _ in spans), max(last for _, last in spans)
    more = 0 if end is None else end - least
    for stream, lives in members.items():
        stream.shift[lives] += more
    return least + more, most + more + 1


def trusted_in(stream, lives):
    for life in lives:
        yield from trusted(stream, life)


def trusted(stream, life=None):
    """Chunks of the frames whose stamps can be trusted to lie behind their ticks."""
    for rows in stream.rows(life):
        rows = rows[rows["trusted"]][["number", "stamp_ns"]]
        if len(rows):
            yield rows


def merge(inputs):
    """Chunks in which the rows of all inputs, each rising by `number`, stand whole: no number is in two of them."""
    heads = [[next(rows, None), rows] for rows in inputs]
    while any(head is not None for head, _ in heads):
        limit = min(head["number"][-1] for head, _ in heads if head is not None)
        out = []
        for entry in heads:
            while entry[0] is not None:
                count = int(np.searchsorted(entry[0]["number"], limit, "right"))
                out.append(entry[0][:count])
                if count < len(entry[0]):
                    entry[0] = entry[0][count:]
                    break
                entry[0] = next(entry[1], None)
        yield np.concatenate(out)


def tick_groups(streams, store):
    """The groups of those streams that have ticks, the others each with instants of its own where it is cyclic."""
    groups = {}
    for stream in streams:
        if stream.message.counter and stream.message.cycle_s and next(trusted(stream), None) is not None:
            shared_by = stream.message.sender if stream.message.sample_tick else stream.message.name
            key = (stream.source, stream.message.sample_tick, shared_by, stream.message.cycle_s)
            groups.setdefault(key, []).append(stream)
    return [TickGroup(members, store) for members in groups.values()]
