"""tools/talus/diagnosis/calibration/further.py: each further effect, judged in its own place."""

from types import SimpleNamespace

import numpy as np
import pytest

from talus.diagnosis import verdict
from talus.diagnosis.calibration import further, thresholds
from talus.diagnosis.search import Search


def candidate(effect):
    return SimpleNamespace(key=(effect, "joint"))


FIRST, GIVEN, RIVAL = candidate("friction_drift"), candidate("presliding"), candidate("backlash")


def fit_of(chosen):
    return SimpleNamespace(chosen=list(chosen))


@pytest.fixture
def judged(monkeypatch):
    """The verdict's further effects, where two rivals share the second place as given, and half the low-pass shows them or not."""

    def judge(shares, shown=True, nothing=0.0):
        monkeypatch.setattr(verdict, "rivals", lambda search, fit: [fit_of([FIRST, GIVEN]), fit_of([FIRST, RIVAL])])
        monkeypatch.setattr(verdict, "shares", lambda search, fit, rivals, sets: np.array(shares))
        monkeypatch.setattr(verdict, "other_sets", lambda search, fit: [fit_of([RIVAL, FIRST])] * (len(shares) - 2))
        monkeypatch.setattr(further, "survives", lambda search, fit, rivals, dataset: shown)
        search = SimpleNamespace(fit=fit_of, further={GIVEN.key: nothing})
        found = SimpleNamespace(fit=fit_of([FIRST, GIVEN]), further={})
        return further.judged(search, found, half_dataset=object())

    return judge


def test_a_rival_that_does_better_takes_the_place(judged):
    found = judged([0.3, 0.7])
    assert [c.key for c in found.fit.chosen] == [FIRST.key, RIVAL.key]
    assert found.further == {RIVAL.key: pytest.approx(0.7)}


def test_what_rivals_take_and_what_may_be_nothing_is_taken_off(judged):
    assert judged([0.8, 0.2], nothing=0.25).further == {GIVEN.key: pytest.approx(0.6)}


def test_another_set_takes_its_share_but_not_the_place(judged):
    found = judged([0.3, 0.1, 0.6])
    assert [c.key for c in found.fit.chosen] == [FIRST.key, GIVEN.key] and found.further == {GIVEN.key: pytest.approx(0.3)}


def test_what_half_the_low_pass_does_not_show_is_doubted(judged):
    assert judged([1.0, 0.0], shown=False).further == {GIVEN.key: thresholds.NEARLY_HALF}
    assert judged([1.0, 0.0]).further == {GIVEN.key: pytest.approx(1.0)}


def test_behind_what_replicates_gain_as_well_another_effect_may_stand():
    likely_nothing = {GIVEN.key: 0.9, RIVAL.key: 0.1}
    search = SimpleNamespace(nothing=lambda before, fit: likely_nothing[fit.chosen[-1].key])
    found = [fit_of([FIRST, GIVEN]), fit_of([FIRST, RIVAL])]
    assert Search._something(search, fit_of([FIRST]), found) == found[1:]
