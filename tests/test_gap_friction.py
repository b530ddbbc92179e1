"""Frictions that grow out of all bounds, or hide in others: presliding on a bench that shares no code with the library, and friction that drifts."""

import math

import pytest
from gap_in_process import recorded
from hidden_effect import bench_with, diagnosed
from support import REPOSITORY

import talus
from talus.blind import effects
from talus.diagnosis.search import Search

TRAVEL_RAD = 0.02
PENDULUM = REPOSITORY / "models/pendulum.yaml"


@pytest.mark.long
def test_presliding_that_is_most_of_the_friction_is_named(tmp_path):
    """An ankle that hardly ever slides leaves the plain model next to no Coulomb friction to tell the effect's size by.
    Iwan's friction, of which the library knows Dahl's: all of it like a spring over 20 mrad."""
    shape = {"pre_form": 3.0, "pre_share": 1.0, "pre_travel": TRAVEL_RAD, "pre_power": 0.5, "pre_rise": 0.0077, "pre_speed": 0.18}
    found = diagnosed(bench_with(tmp_path, "presliding", "ankle", effects.of("ankle", **shape)), "presliding", "ankle")
    assert TRAVEL_RAD / 2 < found["travel_rad"] < 2 * TRAVEL_RAD  # another form's: the same size


def drifts(tmp_path, coulomb_Nm):
    """{shape: candidate} of friction that drifts over 20 s, at parameters with such a Coulomb friction, and the search."""
    talus.simulate(talus.read(PENDULUM), duration_s=20, seed=1, encoder_bits=20).write(tmp_path / "run.csv")
    dataset, identified = recorded(PENDULUM, tmp_path, tmp_path / "run.csv")
    base = dict(identified.base) | {"coulomb": coulomb_Nm}
    search = Search(dataset, list(base.values()), lambda every: [c for c in every if c.effect == "friction_drift"])
    return {c.shape: c for c in search.gram.candidates}, search


@pytest.mark.parametrize("constant_s", [5, 40, 200])
def test_friction_that_drifts_stays_friction(constant_s, tmp_path):
    """In 20 s it goes from twice its mean to nothing at the most, or to four times of it, whatever its time constant."""
    found, _ = drifts(tmp_path, 0.25)
    one = found[f"Coulomb, {constant_s} s"]
    by_end = 1 - math.exp(-20 / constant_s)
    for share, is_one in ((-2.1, False), (-1.9, True), (0.4, True), (2.9, True), (3.1, False)):
        assert one.within_range([share / by_end]) is is_one


def test_a_coulomb_friction_that_is_fitted_below_0_does_not_drift(tmp_path):
    """Beside another effect it may be; a share of it would be a motor."""
    found, search = drifts(tmp_path, -2.0)
    (column,) = found["all, 40 s"].columns
    (terms,) = search.all_terms
    values, speed = column(terms)["T0"], terms.grid("v", 0)
    assert (values * speed).min() > -1e-4 * (values * speed).max()  # the low-pass rings
    assert found["all, 40 s"].entry([0.1])["coulomb_Nm"] == 0.0
