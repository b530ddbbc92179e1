"""Whole sets of effects that stand against each other: tools/talus/diagnosis/search.py and verdict.py."""

from types import SimpleNamespace

import pytest

from talus.diagnosis import verdict
from talus.diagnosis.search import Search

TOLERATED = 100.0


def candidate(effect, weight=1.0):
    return SimpleNamespace(key=(effect, "joint"), weight=lambda strengths: weight)


def fit_of(chosen, excess=0.0):
    return SimpleNamespace(chosen=list(chosen), strengths=[[1.0]] * len(chosen), excess=excess)


SPRING, TWIST, TEETH, GAP = map(candidate, ("parallel_spring", "elasticity", "cogging", "backlash"))


@pytest.fixture
def search():
    """Its refined sets leave a half of what they left on the grid."""
    half = lambda fit: fit_of(fit.chosen, 0.5 * fit.excess)
    return SimpleNamespace(tolerated=TOLERATED, rough=TOLERATED, temperature_of=lambda fit: 1.0, off_drawing=lambda fit, temperature: 0.0, reshaped=lambda fit: fit, all_refined=half, fit=fit_of, ordered=lambda fit: fit,
                           nothing=lambda before, after: 0.0, other_sets=[], camera_zero_rad=None)  # fmt: skip


def test_each_set_is_refined_once_and_only_near_the_best(search):
    near, again, far = fit_of([SPRING, TWIST], 300.0), fit_of([TWIST, SPRING], 310.0), fit_of([TEETH, TWIST], 900.0)
    best = fit_of([TEETH, GAP], 290.0)
    found = Search._near_refined(search, [near, again, far, best])
    assert [(fit.chosen, fit.excess) for fit in found] == [(best.chosen, 145.0), (near.chosen, 150.0)]
    assert Search._near_refined(search, []) == []


def test_sets_without_the_first_effect_and_of_its_size_are_rivals(search):
    search.other_sets = [fit_of([TEETH, GAP]), fit_of([TEETH, SPRING]), fit_of([TEETH])]
    (found,) = verdict.other_sets(search, fit_of([SPRING, TWIST]))
    assert found.chosen == [GAP, TEETH]  # the set's own first one last


def test_that_one_comes_first_without_which_the_others_in_their_best_forms_are_worst(search):
    """As it stands beside the spring the twist leaves 900 alone; in another form it leaves 100, less than the spring alone."""
    search.fit = lambda chosen: fit_of(chosen, 0.0 if len(chosen) > 1 else 300.0 if chosen == [SPRING] else 900.0)
    search.reshaped = lambda fit: fit_of(fit.chosen, 100.0 if fit.chosen == [TWIST] else fit.excess)
    assert Search.ordered(search, fit_of([SPRING, TWIST])).chosen == [TWIST, SPRING]


def test_a_set_that_differs_in_one_effect_is_not_counted_twice(search):
    """It stands among the rivals already: beside the same others, with another effect in the first one's place."""
    search.other_sets = [fit_of([TEETH, TWIST]), fit_of([TWIST, GAP]), fit_of([GAP])]
    assert verdict.other_sets(search, fit_of([SPRING, TWIST])) == []
    assert verdict.other_sets(search, fit_of([SPRING])) == []


@pytest.mark.parametrize("weight, share", [(1.0, 0.5), (0.25, 0.2)])
def test_a_set_that_does_as_well_halves_the_first_ones_probability(monkeypatch, search, weight, share):
    """By what it leaves and by how likely its forms are, all of them."""
    monkeypatch.setattr(verdict, "Odds", lambda search, fit: SimpleNamespace(of=lambda other: 1.0))
    fit, other = fit_of([SPRING, TWIST]), fit_of([candidate("backlash", weight), TEETH])
    assert verdict.shares(search, fit, [fit_of([TWIST, SPRING])], [other]) == pytest.approx([1 - share, share])


def test_an_effect_that_leads_several_sets_has_the_probability_of_all():
    one, other, third = fit_of([TWIST, SPRING]), fit_of([GAP, TEETH]), fit_of([TWIST, TEETH])
    summed, likeliest = verdict._by_effect([0.2, 0.5, 0.3], [one, other, third])
    assert summed == {SPRING.key: 0.2, TEETH.key: 0.8} and likeliest[TEETH.key] is other and likeliest[SPRING.key] is one
