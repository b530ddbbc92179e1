"""tools/talus/diagnosis/calibration/stability.py: does what is named show through another low-pass as well, and of the same size?"""

from types import SimpleNamespace

import numpy as np
import pytest

from talus.diagnosis.calibration import stability

LAW, FILTER = SimpleNamespace(key=("law", "joint"), columns=[1]), SimpleNamespace(key=("filter", "joint"), columns=[2, 3])
FIT = SimpleNamespace(chosen=[LAW, FILTER], strengths=[[1.0], [2.0, 3.0]])
ERRORS = [[0.1], [0.1, 0.1]]


class Columns:
    """Stands in for Gram: columns that are as large as the noise and have nothing to do with each other; the model's own parameters,
    whose rows are `plain` but for the last one, do nothing."""

    plain = (np.zeros((1, 3)),)

    def __init__(self, dataset, all_terms, chosen):
        self.dataset, self.chosen = dataset, chosen

    def held_out(self, columns):
        return self.dataset.left[len(self.chosen)], self.dataset.strengths

    def gathered(self, columns):
        return [np.eye(len(columns))]

    def off_drawing(self, columns, temperature):
        return 0.0


def through(strengths, left=(0.0, 0.0, 0.0)):
    """A dataset through another low-pass: strengths, and chi-square that none, one, both and more effects leave there."""
    return SimpleNamespace(processed_recordings=[], strengths=np.array(strengths), left=left, freedom=lambda: 0.0, sigma={})


@pytest.fixture
def search(monkeypatch):
    monkeypatch.setattr(stability, "Gram", Columns)
    monkeypatch.setattr(stability, "standard_errors", lambda search, fit: ERRORS)
    terms = SimpleNamespace(base=None, torque_constant_error=0.0)
    return SimpleNamespace(dataset=SimpleNamespace(sigma={"T0": 1.0}), all_terms=[terms], columns=lambda chosen: [c for one in chosen for c in one.columns],
                           temperature_of=lambda fit: 1.0, detection_threshold=10.0, tolerated=0.0)  # fmt: skip


SAME = [1.0, 2.0, 3.0]
SIZES = [  # (strengths there, whose differ, whose differ but for a fifth of what they do)
    (SAME, set(), set()), ([1.1, 2.1, 3.0], set(), set()),  # within two deviations
    ([1.0, 2.25, 3.0], set(), set()),  # beyond them, by less than a fiftieth of |(2, 3)|: so far off a form may be
    ([1.5, 2.0, 3.0], {"law"}, {"law"}), ([0.4, 2.0, 3.0], {"law"}, {"law"}),
    ([1.0, 2.5, 3.0], {"filter"}, set()),  # by more than its errors, and less than a fifth: no form is exact
    ([1.0, 3.0, 2.0], {"filter"}, {"filter"}),  # as large, of another phase
    ([1.0, 0.0, 0.0], {"filter"}, {"filter"}), ([-1.0, 2.0, 3.0], {"law"}, {"law"})]  # fmt: skip


@pytest.mark.parametrize(("strengths", "differ", "far"), SIZES)
def test_what_changes_its_size_with_the_low_pass_is_not_kept(search, strengths, differ, far):
    every = {LAW.key, FILTER.key}
    kept = {key for key in every if key[0] not in differ}
    assert stability.keep_their_size(search, FIT, [through(strengths)]) == kept
    assert stability.keep_their_size(search, FIT, [through(SAME), through(strengths)]) == kept
    dataset = through(strengths)
    assert {key[0] for key in stability.Other(search, dataset).moved(FIT, ERRORS, within=0.2)} == far


@pytest.mark.parametrize(("plain", "kept"), [([0.0, 0.0, 1.0], True), ([0.0, 1.0, 0.0], False), ([0.0, 1.0, 1.0], False)])
def test_what_the_models_own_parameters_do_as_well_is_no_change_of_size(search, monkeypatch, plain, kept):
    """The second column of the filter's effect differs; a parameter does the same, or as the first column, or as both."""
    monkeypatch.setattr(Columns, "plain", (np.array([plain, np.zeros(3)]),))
    assert (FILTER.key in stability.keep_their_size(search, FIT, [through([1.0, 2.0, 4.0])])) is kept


@pytest.mark.parametrize(("strengths", "left", "there"), [
    (SAME, (900.0, 500.0, 100.0), True),
    ([1.5, 2.0, 3.0], (900.0, 500.0, 100.0), False),  # worth as much there, and of another size
    ([1.0, 3.0, 2.0], (900.0, 500.0, 100.0), True),  # the other effect's size says nothing of the first
    (SAME, (900.0, 105.0, 100.0), False)])  # fmt: skip
def test_the_first_effect_is_worth_having_there_and_of_its_size(search, strengths, left, there):
    assert stability.survives(search, FIT, [], through(strengths, left)) is there


@pytest.mark.parametrize(("rivals", "there"), [(50.0, False), (95.0, True), (300.0, True)])  # the least step is 10, both leave 100
def test_no_rival_is_better_there(search, rivals, there):
    rival = SimpleNamespace(chosen=[SimpleNamespace(key=(name, "joint"), columns=[]) for name in ("one", "other", "rival")])
    assert stability.survives(search, FIT, [rival], through(SAME, (900.0, 500.0, 100.0, rivals))) is there
    search.temperature_of = lambda fit: 60.0  # where much is left forms differ by so much, and the better one is no other cause
    assert stability.survives(search, FIT, [rival], through(SAME, (900.0, 500.0, 100.0, rivals))) is True
    search.temperature_of = lambda fit: 25.0
    assert stability.survives(search, FIT, [rival], through(SAME, (900.0, 500.0, 100.0, rivals))) is there
