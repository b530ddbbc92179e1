"""tools/talus/diagnosis/calibration/halves.py: has an effect the same size in both halves of the motion?"""

from types import SimpleNamespace

import numpy as np
import pytest

from talus.diagnosis.calibration import halves, thresholds
from talus.diagnosis.gram import Gram

SAMPLES, LEFT = 4000, 1e-3
LAW, OTHER = SimpleNamespace(columns=["law"]), SimpleNamespace(columns=["other"])


class Motion:
    """One joint along a known motion, by the names that a processed recording has."""

    def __init__(self, random):
        self.grid_t_s = np.arange(SAMPLES) * 0.01
        self.q, self.v = (random.permutation(np.linspace(-1.0, 1.0, SAMPLES))[None] for _ in range(2))
        self.target = [np.zeros(SAMPLES)]

    def resample(self, values):
        return values


def search_of(random, size_at, motion, kind="T0"):
    """(search, fit) of a reading that holds a law whose size is `size_at(motion)`, beside a base column and another effect."""
    base, other, law = random.standard_normal((3, SAMPLES))
    law += 2.0 * base - other  # most of it other columns do as well
    reading = 1.5 * base + 0.7 * other + size_at(motion) * law + LEFT * random.standard_normal(SAMPLES)
    motion.target[0] = random.permutation(reading)  # halves by torque have nothing to do with the law
    layout = SimpleNamespace(kind=kind, on_rows=lambda values: values[0])
    every = np.array([base, other, law])
    found = np.linalg.lstsq(every.T, reading, rcond=None)[0]
    gram = SimpleNamespace(plain=[np.array([base, reading])], layouts=[layout], gathered=lambda columns: [every[1:]],
                           fold_strengths=lambda columns: found[None])  # fmt: skip
    gram.left = lambda strengths, own: Gram.left(gram, strengths, own)
    search = SimpleNamespace(gram=gram, dataset=SimpleNamespace(processed_recordings=[motion]),
                             columns=lambda chosen: [c for one in chosen for c in one.columns])  # fmt: skip
    return search, SimpleNamespace(chosen=[OTHER, LAW], strengths=[[found[1]], [found[2]]])


def larger_by(part, where):
    """A law's size, 1 in the mean over two halves that show as much of it, and larger by so much of that in one of them."""
    return lambda motion: np.where(where(motion), 1.0 + part, 1.0 - part)


WHERE = [lambda m: m.v[0] > 0, lambda m: np.abs(m.v[0]) > 0.5, lambda m: m.q[0] > 0, lambda m: m.grid_t_s > 20.0]


@pytest.mark.parametrize("where", WHERE, ids=["direction", "speed", "angle", "time"])
@pytest.mark.parametrize("part", [0.0, 0.2, 0.6])
def test_it_is_off_by_as_much_as_it_is_larger_in_one_half(where, part):
    random = np.random.default_rng(5)
    search, fit = search_of(random, larger_by(part, where), Motion(random))
    by_chance = 2.0 * np.sqrt(6.0 / (SAMPLES / 2))  # the wrong size leaves all of the law, of which a sixth of the squares is its own
    assert max(halves.by_half(search, fit)) == pytest.approx(part * (1.0 - by_chance), abs=0.03)  # halves of rows drawn at random differ so
    assert halves.is_uneven(search, fit) is (part > thresholds.HALF)


def test_what_other_columns_do_as_well_tells_nothing():
    """Squares of what is left of a column beside the others, by the closed form of a regression on them."""
    random = np.random.default_rng(6)
    base, reading, other, law = random.standard_normal((4, SAMPLES))
    (found,) = halves.alone([np.array([base, reading])], [np.array([other, law + 3.0 * base])], 1)
    q = np.linalg.qr(np.array([base, other]).T)[0]
    assert found[0] == pytest.approx(law - q @ (q.T @ law))


def test_noise_alone_is_taken_off(monkeypatch):
    """A weak law in white noise: its halves differ by more than half, by chance."""
    random = np.random.default_rng(7)
    search, fit = search_of(random, larger_by(0.0, WHERE[0]), Motion(random))
    noisy = search.gram.plain[0]
    noisy[-1] += 25.0 * random.standard_normal(SAMPLES)
    every = np.concatenate([noisy[:1], search.gram.gathered([])[0]])
    found = np.linalg.lstsq(every.T, noisy[-1], rcond=None)[0]
    search.gram.fold_strengths = lambda columns: found[None]
    fit.strengths = [[found[1]], [found[2]]]
    assert not halves.is_uneven(search, fit)
    monkeypatch.setattr(halves, "DEVIATIONS", 0.0)
    assert halves.is_uneven(search, fit)


@pytest.mark.parametrize(("share", "counts"), [(0.1, False), (0.3, True)])
def test_a_joint_that_shows_little_of_it_says_nothing(share, counts):
    """At the other joint of a leg, which shows this share of its squares, its size is all wrong."""
    random = np.random.default_rng(9)
    search, fit = search_of(random, larger_by(0.0, WHERE[0]), Motion(random))
    other, _ = search_of(random, larger_by(0.9, WHERE[1]), Motion(random))
    times = np.sqrt(share / (1.0 - share))
    mine, theirs = search.gram, other.gram
    mine.plain, mine.layouts = [mine.plain[0], times * theirs.plain[0]], [mine.layouts[0], SimpleNamespace(kind="T1", on_rows=lambda values: values[0])]
    motion, too = (one.dataset.processed_recordings[0] for one in (search, other))
    motion.q, motion.v, motion.target = (np.concatenate([getattr(one, name) for one in (motion, too)]) for name in ("q", "v", "target"))
    own, further = mine.gathered([])[0], times * theirs.gathered([])[0]
    mine.gathered = lambda columns: [own, further]
    assert halves.is_uneven(search, fit) is counts


def test_where_nothing_can_be_halved_nothing_is_uneven():
    random = np.random.default_rng(8)
    motion = Motion(random)
    search, fit = search_of(random, larger_by(0.8, WHERE[0]), motion)
    for values in (motion.q, motion.v, motion.target[0], motion.grid_t_s):
        values[...] = 0.0
    assert list(halves.by_half(search, fit)) == [] and not halves.is_uneven(search, fit)
    search, fit = search_of(random, larger_by(0.8, WHERE[0]), Motion(random), kind="E")
    assert list(halves.by_half(search, fit)) == []
