"""The export's clock model against clocks that are made here: what the true instants are is known."""

import json
from dataclasses import replace

import numpy as np
import pytest
from bus_record import BEGIN_NS, frames_of, twin, write
from talus.acquire_export import clock_model
from talus.acquire_export.adapter_clock import Pair, to_monotonic
from talus.acquire_export.clock_model import Clock, ClockModel
from test_export import export, exported

S = 10**9
EPOCH_NS = 1_700_000_000 * S


def made(generator, seconds, sizes_ns, told, drift=30e-6):
    """(true monotonic instants of frames, two each millisecond and late by up to 0.2 ms; their realtime stamps, readings): steps of these sizes at random times."""
    instants = np.sort(np.repeat(np.arange(0, seconds * S, S // 1000), 2) + generator.integers(0, 200_000, seconds * 2000)) + 5 * S
    at = np.sort(generator.choice(np.arange(1, seconds - 1), len(sizes_ns), replace=False)) * S + 5 * S
    at = at + generator.integers(0, S, len(sizes_ns))

    def offset(t):
        return EPOCH_NS + np.rint((t - 5 * S) * drift).astype(np.int64) + sum(size * (t >= a) for size, a in zip(sizes_ns, at, strict=True))

    read = np.arange(5 * S, (seconds + 5) * S + 1, S)
    late = at + generator.integers(50_000, 3_000_000, len(at)) if told else np.array([], np.int64)
    times = sorted([(int(t), False) for t in read] + [(int(t), True) for t in late])
    clocks = [Clock(t, int(t + offset(np.array(t))), 500, is_set) for t, is_set in times]
    return instants, instants + offset(instants), clocks, at


@pytest.mark.parametrize("told", [True, False], ids=["told", "found"])
@pytest.mark.parametrize("seed", range(10))
def test_instants_on_either_side_of_each_step(seed, told):
    """Forward and back, from 5 ms to an hour; the bar is 100 us."""
    generator = np.random.default_rng(seed)
    sizes = [int(sign * size) for sign, size in zip(generator.choice((-1, 1), 4), generator.choice((5e6, 2e7, 8e8, 5e9, 3.6e12), 4), strict=True)]
    true_ns, stamps, clocks, _ = made(generator, 20, sizes, told)
    model = ClockModel(clocks)
    assert np.abs(model.convert(stamps) - true_ns).max() < 100_000
    assert [step.size_ns for step in model.steps] == pytest.approx(sizes, abs=100_000)
    assert all(step.uncertain_ns == 0 for step in model.steps)


def test_steps_that_nobody_looks_for(monkeypatch):
    """The same without the cure: every instant is off, and no word of it. So the test above can fail."""
    true_ns, stamps, clocks, _ = made(np.random.default_rng(0), 20, [5 * S], True)
    monkeypatch.setattr(clock_model, "is_step", lambda a, b: False)
    model = ClockModel(clocks)
    assert np.abs(model.convert(stamps) - true_ns).max() > 100_000 and model.steps == []
    monkeypatch.undo()
    model = ClockModel(clocks)
    assert np.abs(model.convert(stamps) - true_ns).max() < 100_000 and len(model.steps) == 1


def test_a_clock_that_is_slewed_has_no_steps():
    """By as much as NTP does."""
    t = np.arange(0, 60 * S, S)
    clocks = [Clock(int(x), int(EPOCH_NS + x + x * 500e-6), 300) for x in t]
    model = ClockModel(clocks)
    frames = np.arange(0, 59 * S, S // 1000)
    assert model.steps == []
    assert np.abs(model.convert(EPOCH_NS + frames + np.rint(frames * 500e-6).astype(np.int64)) - frames).max() < 2_000


def read_at(generator, mono_ns, width_ns, drift):
    """A reading that lasted `width_ns`: realtime was looked at somewhere within."""
    off = generator.uniform(-0.5, 0.5, len(mono_ns)) * width_ns
    return [Clock(int(t), int(t) + EPOCH_NS + round((t - 5 * S) * drift + error), int(width)) for t, error, width in zip(mono_ns, off, width_ns, strict=True)]


def off_of(clocks, true_ns, drift):
    """By how much instants of a clock that nobody sets come out wrong."""
    model = ClockModel(clocks)
    assert not model.steps
    return np.abs(model.convert(true_ns + EPOCH_NS + np.rint((true_ns - 5 * S) * drift).astype(np.int64)) - true_ns)


def blind(clocks):
    """The same readings, and nothing that says how exact they are."""
    return [replace(clock, width_ns=0) for clock in clocks]


@pytest.mark.parametrize("place", [0, 9, 19], ids=["first", "among", "last"])
def test_a_reading_that_took_long_among_quick_ones_moves_nothing(place):
    """A busy machine held the recorder up in the middle of one: it is off by half a millisecond, and says that it may be."""
    t = np.arange(5 * S, 25 * S, S)
    clocks = read_at(np.random.default_rng(1), t, np.full(20, 600), 30e-6)
    clocks[place] = replace(clocks[place], real_ns=clocks[place].real_ns + 500_000, width_ns=1_100_000)
    true_ns = np.arange(5 * S, 24 * S, S // 100)
    assert off_of(clocks, true_ns, 30e-6).max() < 2_000
    assert off_of(blind(clocks), true_ns, 30e-6).max() > 100_000  # so this can fail


def test_no_reading_is_off_by_more_than_it_says():
    """Readings of all widths: where they were taken, what comes out lies within what each of them allows."""
    worst = 0.0
    for seed in range(50):
        generator = np.random.default_rng(seed)
        t, width = np.arange(5 * S, 65 * S, S), 10 ** generator.uniform(2, 6, 60)
        drift = generator.uniform(-300e-6, 300e-6)
        clocks = read_at(generator, t, width, drift)
        off = off_of(clocks, t, drift)
        assert (off <= width + 10).all() and off.max() < 150_000, seed
        worst = max(worst, *(abs(clock.offset_ns - EPOCH_NS - (x - 5 * S) * drift) for clock, x in zip(clocks, t.tolist(), strict=True)))
    assert worst > 400_000  # the readings themselves


def test_where_every_reading_took_long_instants_are_said_to_be_uncertain():
    """Between two steps stands one reading, off by 0.3 ms."""
    t = np.array([5, 6, 7, 8]) * S
    clocks = [Clock(int(x), EPOCH_NS + int(x) + 5 * S * (6 * S <= x < 7 * S), 500) for x in t]
    assert ClockModel(clocks).uncertain_ns == 250
    clocks[1] = replace(clocks[1], real_ns=clocks[1].real_ns + 300_000, width_ns=700_000)
    frames = np.arange(5 * S, 8 * S, S // 100)
    model = ClockModel(clocks)
    off = np.abs(model.convert(EPOCH_NS + frames + 5 * S * ((frames >= 6 * S) & (frames < 7 * S))) - frames)
    assert len(model.steps) == 2 and 100_000 < off.max() <= model.uncertain_ns == 350_000


@pytest.mark.parametrize("apart_ns", [300_000, 3_000_000, 30_000_000])
def test_two_readings_soon_after_each_other_make_no_drift(apart_ns):
    """As after a clock was set: the kernel tells of it, and the reading of each second follows soon. What a slow call puts between the two
    is no drift that goes on for a second."""
    true_ns = np.arange(5 * S, 6 * S, S // 1000)
    clocks = [Clock(5 * S, EPOCH_NS + 5 * S - 4_000, 9_000, True), Clock(5 * S + apart_ns, EPOCH_NS + 5 * S + apart_ns + 4_000, 9_000)]
    assert off_of(clocks, true_ns, 0.0).max() < 10_000
    assert off_of(blind(clocks), true_ns, 0.0).max() > (100_000 if apart_ns < 30_000_000 else 10_000)


def test_what_cannot_be_known_is_said():
    """A step smaller than the time between frames, and nobody who told when: uncertain by its size, and no more."""
    generator = np.random.default_rng(4)
    frames = np.sort(generator.integers(0, 10 * S, 200)) + 5 * S
    stamps = frames + EPOCH_NS + 2_000_000 * (frames >= 8 * S + 5)
    clocks = [Clock(t, EPOCH_NS + t + 2_000_000 * (t > 8 * S), 300) for t in range(5 * S, 16 * S, S)]
    model = ClockModel(clocks)
    off = np.abs(model.convert(stamps) - frames)
    (step,) = model.steps
    assert step.uncertain_ns == 2_000_000 and off.max() <= 2_000_000 + 100
    assert (off[(frames < 7 * S) | (frames > 10 * S)] < 1000).all()


def test_two_records_joined_across_a_step_have_one_base():
    generator = np.random.default_rng(5)
    true_ns, stamps, clocks, at = made(generator, 20, [-7 * S], True)
    cut = int(np.searchsorted(true_ns, 13 * S))
    parts = [ClockModel([c for c in clocks if (c.mono_ns <= 13 * S) == first]).convert(part)
             for first, part in ((True, stamps[:cut]), (False, stamps[cut:]))]  # fmt: skip
    joined = np.concatenate(parts)
    assert np.abs(joined - true_ns).max() < 100_000 and (np.diff(joined) >= 0).all()


def test_without_a_reading_nothing_is_converted():
    assert ClockModel([]).convert(np.array([1])) is None


@pytest.mark.parametrize("seed", range(5))
def test_no_step_depends_on_where_chunks_end(seed):
    """The frames' stamps as the export reads them: some at a time, from any of them on."""
    generator = np.random.default_rng(seed)
    sizes = [int(sign * size) for sign, size in zip(generator.choice((-1, 1), 4), generator.choice((5e6, 2e7, 8e8, 5e9, 3.6e12), 4), strict=True)]
    _, stamps, clocks, _ = made(generator, 20, sizes, seed % 2 == 0)
    found = []
    for chunk in (len(stamps), 1000, 7):
        model = ClockModel(clocks)
        edges = model.edges(lambda first, chunk=chunk: (stamps[k:k + chunk] for k in range(first, len(stamps), chunk)), len(stamps))
        found.append((edges, [step.uncertain_ns for step in model.steps]))
    assert found[0] == found[1] == found[2] and len(found[0][0]) == 4


# ---- stamps that stand wide apart, and steps of any size ---------------------------------------------

SIZES_NS = [sign * int(size) for size in (5e6, 2e7, 8e7, 8e8, 5e9, 3.6e12) for sign in (1, -1)]
SEEDS = range(10)


class Machine:
    """20 s from 5 s on, in which realtime is set: its readings, and what it stamps."""

    def __init__(self, seed, size_ns, told=True, again=()):
        self.generator = np.random.default_rng(seed)
        self.at, self.size_ns = int(self.generator.integers(7 * S, 23 * S)), size_ns
        self.steps = [(self.at, size_ns), *((self.at + later, size) for later, size in again)]
        self.readings = [(t, False) for t in range(5 * S, 25 * S + 1, S)]
        if told:
            self.readings += [(at + int(self.generator.integers(50_000, 3_000_000)), True) for at, _ in self.steps]
        self.clocks = [Clock(t, int(self.realtime(np.int64(t))), 500, is_set) for t, is_set in sorted(self.readings)]

    def realtime(self, t):
        return t + EPOCH_NS + np.rint((t - 5 * S) * 30e-6).astype(np.int64) + sum(size * (t >= at) for at, size in self.steps)

    def even(self, gap_ns):
        """Instants of frames, late by up to 0.2 ms."""
        t = np.arange(5 * S + int(self.generator.integers(gap_ns)), 25 * S, gap_ns)
        return t + self.generator.integers(0, 200_000, len(t))

    def random(self, gap_ns):
        return np.sort(self.generator.integers(5 * S, 25 * S, 20 * S // gap_ns))


def is_uncertain(machine, true_ns, got_ns, steps):
    """Each instant is right to 100 us, or lies where the step says how far it may be off; does the step say so?"""
    off, (step,) = np.abs(got_ns - true_ns), steps
    assert step.size_ns == pytest.approx(machine.size_ns, abs=100_000)
    told = (true_ns >= step.uncertain_from_ns - 1_000_000) & (true_ns <= step.uncertain_to_ns + 1_000_000)
    assert (off <= 100_000 + step.uncertain_ns * told).all()
    return step.uncertain_ns > 0


@pytest.mark.parametrize("told", [True, False], ids=["told", "found"])
@pytest.mark.parametrize("gap_ns", [S, S // 10, S // 100, S // 1000], ids=["1s", "100ms", "10ms", "1ms"])
def test_a_step_among_even_stamps_however_wide_apart(gap_ns, told):
    for size_ns in SIZES_NS:
        for seed in SEEDS:
            machine = Machine(seed, size_ns, told)
            true_ns, model = machine.even(gap_ns), ClockModel(machine.clocks)
            assert not is_uncertain(machine, true_ns, model.convert(machine.realtime(true_ns)), model.steps), (size_ns, seed)


@pytest.mark.parametrize("gap_ns", [S, S // 10, S // 100, S // 1000], ids=["1s", "100ms", "10ms", "1ms"])
def test_a_step_among_random_stamps(gap_ns):
    """No gap is usual here: where a step is not far larger than they are, some instants remain uncertain, and that is told."""
    for size_ns in SIZES_NS:
        uncertain = 0
        for seed in SEEDS:
            machine = Machine(seed, size_ns)
            true_ns, model = machine.random(gap_ns), ClockModel(machine.clocks)
            uncertain += is_uncertain(machine, true_ns, model.convert(machine.realtime(true_ns)), model.steps)
        assert uncertain == 0 or abs(size_ns) < 10 * gap_ns, size_ns


def test_frames_as_late_as_the_step_is_large():
    """A sender that pauses by 5 ms now and then, and a step of 5 ms: which of them was the step nobody knows."""
    uncertain = 0
    for seed in SEEDS:
        machine = Machine(seed, 5_000_000, told=False)
        t = np.cumsum(S // 1000 + 5_000_000 * (machine.generator.random(16_000) < 0.02)) + 5 * S
        true_ns, model = t[t < 25 * S], ClockModel(machine.clocks)
        uncertain += is_uncertain(machine, true_ns, model.convert(machine.realtime(true_ns)), model.steps)
    assert uncertain >= 9


SIZES_TWICE_NS = [(5 * S, -5 * S), (-5 * S, 5 * S), (5 * S, 3 * S), (-5 * S, -3 * S), (80_000_000, -20_000_000), (5_000_000, -5_000_000)]


@pytest.mark.parametrize("gap_ns", [S, S // 10, S // 100, S // 1000], ids=["1s", "100ms", "10ms", "1ms"])
@pytest.mark.parametrize("later_ns", [10_000_000, 300_000_000, S], ids=["10ms", "300ms", "1s"])
def test_a_clock_that_is_set_twice_soon(gap_ns, later_ns):
    """Often no frame came between the two steps."""
    for first_ns, second_ns in SIZES_TWICE_NS:
        for seed in SEEDS:
            machine = Machine(seed, first_ns, again=[(later_ns, second_ns)])
            true_ns, model = machine.even(gap_ns), ClockModel(machine.clocks)
            off = np.abs(model.convert(machine.realtime(true_ns)) - true_ns)
            told = sum(step.uncertain_ns * ((true_ns >= step.uncertain_from_ns - 1_000_000) & (true_ns <= step.uncertain_to_ns + 1_000_000)) for step in model.steps)
            assert (off <= 100_000 + told).all() and len(model.steps) == 2, (first_ns, second_ns, seed)
            assert gap_ns > S // 100 or not any(step.uncertain_ns for step in model.steps), (first_ns, second_ns, seed)


@pytest.mark.parametrize("size_ns", [5 * S, -5 * S])
def test_no_frame_came_before_the_step_or_behind_it(size_ns):
    machine = Machine(1, size_ns)
    for some in (lambda t: t[t < machine.at], lambda t: t[t >= machine.at]):
        true_ns, model = some(machine.even(S // 1000)), ClockModel(machine.clocks)
        assert not is_uncertain(machine, true_ns, model.convert(machine.realtime(true_ns)), model.steps)


def test_frames_that_contradict_the_readings_are_uncertain():
    """Their stamps know nothing of a step of 5 s."""
    machine = Machine(2, 5 * S)
    model = ClockModel(machine.clocks)
    model.convert(machine.even(S // 1000) + EPOCH_NS)
    assert model.steps[0].uncertain_ns == pytest.approx(5 * S, abs=100_000)


# ---- an adapter's own clock ------------------------------------------------------------------------


def adapter_ns(t):
    return 1000 + np.rint((t - 5 * S) * (1 + 80e-6)).astype(np.int64)


def pairs_of(machine, frames):
    """What the recorder notes: each second the newest frame that it has read by then."""
    out = []
    for look in range(5 * S + 300_000, 25 * S, S):
        read = frames[frames <= look - int(machine.generator.integers(0, 2_000_000))][-1:]
        for t in read.tolist():
            place = sum(reading < look for reading, _ in machine.readings)
            out.append(Pair(int(adapter_ns(np.int64(t))), int(machine.realtime(np.int64(t + t % 40_000))), place))
    return out


@pytest.mark.parametrize("told", [True, False], ids=["told", "found"])
@pytest.mark.parametrize("gap_ns", [3 * S, S, S // 10, S // 1000], ids=["3s", "1s", "100ms", "1ms"])
def test_a_step_among_the_pairs_of_an_adapter(gap_ns, told):
    for size_ns in SIZES_NS:
        for seed in SEEDS:
            machine = Machine(seed, size_ns, told)
            frames, model = machine.even(gap_ns), ClockModel(machine.clocks)
            convert = to_monotonic(model, pairs_of(machine, frames))
            assert not is_uncertain(machine, frames, convert(adapter_ns(frames)), model.steps), (size_ns, seed)


def test_a_single_pair_near_a_step_is_uncertain():
    """Nothing tells on which side of it the pair lies."""
    machine = Machine(3, 20_000_000, told=False)
    model = ClockModel(machine.clocks)
    t = np.array([machine.at + 1_000_000])
    place = sum(reading < t[0] for reading, _ in machine.readings)
    convert = to_monotonic(model, [Pair(int(adapter_ns(t)[0]), int(machine.realtime(t)[0]), place)])
    frames = machine.even(S // 10)
    assert abs(convert(adapter_ns(t)) - t)[0] <= model.steps[0].uncertain_ns + 100_000
    assert model.steps[0].uncertain_ns == pytest.approx(20_000_000, abs=100_000)
    assert model.steps[0].uncertain_from_ns <= frames[0] and model.steps[0].uncertain_to_ns >= frames[-1]


# ---- through the program ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    recording = twin(tmp_path_factory.mktemp("bench"), duration=20)
    return recording, frames_of(recording)


STEP_AT_NS = 11_300_200_000


def realtime(t, size_ns):
    return BEGIN_NS + t + size_ns * (t >= STEP_AT_NS)


def events_of(size_ns, pairs):
    """The events file of a recorder that began with the bench, at 5 s on the monotonic clock."""
    times = sorted([*((k * S, False) for k in range(22)), (STEP_AT_NS + 1_500_000, True)])
    lines = [{"type": "header", "sources": [{"name": "can0", "kind": "can", "stamps": "hardware" if pairs else "software"}]}]
    for t, is_set in times:
        lines.append({"type": "clock", "mono_ns": 5 * S + t, "real_ns": realtime(t, size_ns), "width_ns": 500} | ({"set": True} if is_set else {}))
        if pairs and not is_set and t:
            newest = t - 300_000
            lines.append({"type": "hardware_clock", "source": "can0", "hw_ns": newest + 1000, "real_ns": realtime(newest, size_ns)})
    return "".join(json.dumps(line) + "\n" for line in lines)


def check(bench, folder, size_ns, hardware):
    recording, frames = bench
    stamped = [replace(f, t_ns=f.t_ns - BEGIN_NS + 1000 if hardware else realtime(f.t_ns - BEGIN_NS, size_ns)) for f in frames]
    path = write(folder / "rec.log", stamped)
    (folder / "rec.jsonl").write_text(events_of(size_ns, hardware))
    words = export(path, folder)
    got, told = exported(folder)
    assert told["clock"] == "CLOCK_MONOTONIC" and told["complete"] and told["faults"] == []
    assert len(got) == len(recording) and np.ptp(got["time_s"] - recording["time_s"]) < 100e-6
    (step,) = told["clock_steps"]
    assert step["size_s"] == pytest.approx(size_ns / 1e9, abs=100e-6) and step["uncertain_s"] == 0
    assert f"the clock was set {('forward', 'back')[size_ns < 0]} by {abs(size_ns) / 1e9:.6f} s" in words


@pytest.mark.parametrize("size_ns", [5 * S, -5 * S, -20_000_000, 5_000_000])
def test_a_record_across_a_step(bench, tmp_path, size_ns):
    check(bench, tmp_path, size_ns, hardware=False)


@pytest.mark.parametrize("size_ns", [800_000_000, -5 * S])
def test_a_record_of_an_adapters_stamps_across_a_step(bench, tmp_path, size_ns):
    check(bench, tmp_path, size_ns, hardware=True)


def test_uncertain_instants_and_unrelated_stamps_are_told(bench, tmp_path):
    """A step that the stamps contradict; and an adapter whose clock nothing relates to any other."""
    path = write(tmp_path / "rec.log", bench[1])
    (tmp_path / "rec.jsonl").write_text(events_of(5 * S, False))
    words = export(path, tmp_path)
    assert exported(tmp_path)[1]["clock_uncertain_s"] == 250e-9 and "not read quickly" not in words
    (tmp_path / "rec.jsonl").write_text(events_of(5 * S, False).replace('"width_ns": 500', '"width_ns": 300000'))
    assert "the clocks were not read quickly between two steps: instants are uncertain by 0.000150 s there" in export(path, tmp_path)
    (tmp_path / "rec.jsonl").write_text(events_of(5 * S, False))
    words = export(path, tmp_path)
    (step,) = exported(tmp_path)[1]["clock_steps"]
    first, last = step["uncertain_time_s"]
    assert step["uncertain_s"] == 5 and f"instants from {first:.3f} s to {last:.3f} s are uncertain by 5.000000 s" in words
    lines = events_of(5 * S, True).splitlines(keepends=True)
    (tmp_path / "rec.jsonl").write_text("".join(line for line in lines if "hardware_clock" not in line))
    assert "can0: nothing relates the adapter's clock to the monotonic one" in export(path, tmp_path)
