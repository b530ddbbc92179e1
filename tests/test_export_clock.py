"""The export's clock model against clocks that are made here: what the true instants are is known."""

import numpy as np
import pytest
from talus.acquire_export import clock_model
from talus.acquire_export.clock_model import Clock, ClockModel

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
