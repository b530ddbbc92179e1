"""tools/talus/diagnosis/shapes.py: all values of a shape at once, against SciPy; and lost motion, on a bench that shares no code with the library."""

import json
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from talus.diagnosis.catalogue.candidate import Candidate, Family
from talus.diagnosis.shapes import refined
from hidden_effect import bench_with, diagnosed
from scipy.optimize import curve_fit
from support import run

from talus.blind import cases, effects, running

T_S = np.linspace(0.0, 2.0, 400)


def ringing(t_s, size, fades_s, rate, lag):
    return size * np.exp(-t_s / fades_s) * np.sin(rate * t_s - lag)


def candidate(*values, **options):
    family = Family(partial(candidate, **options), values, (1.5, 1.2, 0.5), (0.05, 2.0, -1.0), (5.0, 40.0, 1.0), **options)
    return Candidate("cogging", "joint", "", (lambda _: ringing(T_S, 1.0, *values),), dict, family=family)


class PlainSearch:
    """One layout without base columns: what shapes.py asks of a search."""

    rough = 1.0

    def __init__(self, reading, start):
        self.reading, self.gram = reading, self
        self.candidates = [start]

    def gathered(self, columns):
        return [np.array([column(None) for column in columns])]

    def products(self, rows):
        every = np.vstack([*rows, self.reading])
        return every @ every.T

    def columns(self, chosen):
        return [column for one in chosen for column in one.columns]

    def make(self, columns):
        """Nothing ahead: a candidate costs nothing here."""

    def forget(self, kept):
        """Nothing is kept here."""

    def fit(self, chosen):
        (rows,) = self.gathered(self.columns(chosen))
        strengths = np.linalg.lstsq(rows.T, self.reading, rcond=None)[0]
        excess = float(np.sum((self.reading - strengths @ rows) ** 2)) - len(T_S)
        found = SimpleNamespace(chosen=chosen, strengths=[strengths], excess=excess, is_physical=lambda looking=False: True)
        found.last_moved = lambda place: found
        return found

    def beside(self, others, shapes, looking):
        return [self.fit([*others, shape]) for shape in shapes]


def test_all_values_of_a_shape_end_where_scipy_ends():
    """Three values that hang together and a strength, from a start a step away in each."""
    true = (300.0, 0.6, 12.0, 0.3)
    reading = ringing(T_S, *true) + np.random.default_rng(3).standard_normal(len(T_S))
    start = candidate(0.9, 10.5, -0.1)
    search = PlainSearch(reading, start)
    found = refined(search, search.fit([start]), 0)
    wanted, _ = curve_fit(ringing, T_S, reading, p0=true)
    assert (float(found.strengths[0][0]), *found.chosen[0].family.values) == pytest.approx(wanted, rel=0.01)


@pytest.mark.parametrize(("elsewhere", "found"), [((), False), (((1.0, 0.1, 1.0),), True)])
def test_where_valleys_are_many_shapes_beside_the_grid_are_starts_too(elsewhere, found):
    """From a rate of 30 no way leads to 3.2; from a tenth of it one does, and leaves less than the noise."""
    true = (300.0, 0.6, 3.2, 0.3)
    reading = ringing(T_S, *true) + np.random.default_rng(5).standard_normal(len(T_S))
    search = PlainSearch(reading, candidate(0.9, 30.0, -0.1, rough=True, elsewhere=elsewhere))
    best = refined(search, search.fit(search.candidates), 0)
    at_truth = search.fit([candidate(*true[1:])]).excess
    assert bool(best.excess < at_truth + 3 * np.sqrt(2 * len(T_S))) is found


FREE = {"gap_half": 0.0006, "stiffness": 11000.0, "damping": 0.0012, "elastic_form": 1, "rotor_share": 0.23, "link_share": 0.04,
        "viscous_share": 0.19, "gap_coulomb": 0.0}  # fmt: skip


@pytest.mark.long
def test_lost_motion_at_the_knee_closes_on_a_motion_that_was_never_given(tmp_path):
    """No encoder sees the gap: the wrong place of friction or rotor makes the link's jolts come at other times."""
    bench = bench_with(tmp_path, "backlash", "knee", effects.of("knee", **FREE))
    gap = diagnosed(bench, "backlash", "knee")
    assert gap["gap_rad"] == pytest.approx(2 * FREE["gap_half"], rel=0.1)
    rms = running.unseen(bench, bench / "fitted.yaml", tmp_path)
    assert rms["extended"]["knee"] ** 2 < 0.25 * rms["identified"]["knee"] ** 2


@pytest.mark.long
@pytest.mark.parametrize("seed, number, gap_rad", [(866, 25, 0.00055), (853, 23, 0.00090)])
def test_lost_motion_of_a_slider_is_no_late_current(seed, number, gap_rad, tmp_path):
    """The motor is half and a third of its mass; on the first carriage stands a constant force, which holds it to one face. The gap's size
    may be a third off: teeth, friction and the motor's share trade against it."""
    truth = cases.make(seed, number, cases.MIX, tmp_path, "wide")
    assert (truth["effect"], truth["joint"]) == ("backlash", "slider")
    bench, found = tmp_path / truth["case"], tmp_path / "gap.json"
    run("talus-gap", "--quiet", "--model", bench / "model.yaml", "--report", found, *sorted(bench.glob("train*")))
    verdict, (first, *_) = (json.loads(found.read_text())[name] for name in ("verdict", "effects"))
    assert (verdict["effect"], verdict["joint"]) == ("backlash", "slider") and verdict["probability"] > 0.9
    assert first["parameters"]["gap_rad"] == pytest.approx(gap_rad, rel=0.4)
