"""tools/talus/diagnosis/verdict.py: the share of a gap that a named effect leaves open."""

from types import SimpleNamespace

import pytest

from talus.diagnosis import verdict
from talus.diagnosis.search import Search

JOINT, LEG = {"joint": ["T0"]}, {"knee": ["T0"], "ankle": ["T1"]}


class Toy(Search):
    """A search whose excesses are given: `left` {kind: (of the plain model, of the fit)}, over floors of 10."""

    def __init__(self, joints, left):
        self.left, self.plain = left, SimpleNamespace(chosen=[])
        kinds = sorted(left)
        self.floor_of = dict.fromkeys(kinds, 10.0)
        self.dataset = SimpleNamespace(kinds=kinds, kinds_at=lambda joint: joints[joint])

    def excess_by_kind(self, fit):
        return {kind: values[bool(fit.chosen)] for kind, values in self.left.items()}


def open_share(joint, *toy):
    return verdict.still_open(Toy(*toy), SimpleNamespace(chosen=[SimpleNamespace(joint=joint)]))


def test_the_share_is_what_stands_above_the_floor_over_that_and_what_was_closed():
    assert open_share("joint", JOINT, {"T0": (1010.0, 10.0)}) == 0.0
    assert open_share("joint", JOINT, {"T0": (1010.0, 260.0)}) == pytest.approx(250 / (250 + 750))
    assert open_share("joint", JOINT, {"T0": (9.0, 5.0)}) == 0.0  # all within what reconstruction leaves


def test_what_is_open_at_the_other_joint_does_not_count_where_much_is_closed():
    assert open_share("knee", LEG, {"T0": (2010.0, 10.0), "T1": (10.0, 10.0)}) == 0.0
    assert open_share("knee", LEG, {"T0": (2010.0, 10.0), "T1": (1910.0, 1910.0)}) == pytest.approx(1900 / 3900)  # below one half anyhow
    assert open_share("knee", LEG, {"T0": (2010.0, 510.0), "T1": (910.0, 1910.0)}) == pytest.approx(500 / 2000)
    assert open_share("knee", LEG, {"T0": (1010.0, 10.0), "T1": (9010.0, 9010.0)}) == pytest.approx(9000 / 10_000)  # a tenth is little


def test_joints_are_not_counted():
    """The same gap at one joint alone, and at the first of two whose other one shows nothing."""
    for left in ((500.0, 10.0), (500.0, 400.0)):
        assert open_share("knee", LEG, {"T0": left, "T1": (10.0, 10.0)}) == open_share("joint", JOINT, {"T0": left})


# ---- what a doubt about the first effect leaves in front ---------------------


def candidate(effect):
    return SimpleNamespace(key=(effect, "joint"))


FIRST, FURTHER, RIVAL, ITS_OWN = map(candidate, ("linkage_error", "backlash", "encoder_eccentricity", "delay"))
PLAIN = SimpleNamespace(chosen=[])


def doubted(probabilities, rival_fit):
    """The verdict of a search, whose first effect gets 0.45 at the most, and in whose place `rival_fit` could stand."""
    search = SimpleNamespace(plain=PLAIN, fit=lambda chosen: SimpleNamespace(chosen=list(chosen)))
    given = [(p, effect, "none" if effect == "unknown" else "joint") for effect, p in probabilities.items()]
    found = verdict.Verdict(given, search.fit([FIRST, FURTHER]), 0.0)
    found.further, found.likeliest = {FURTHER.key: 0.9}, {RIVAL.key: search.fit(rival_fit)}
    verdict.with_named_in_front(search, found.doubted(0.45, "lowpass"))
    return found, [c.key for c in found.fit.chosen]


def test_the_named_effect_is_the_first_of_those_that_are_listed():
    """The contract: the verdict is the first of `effects`."""
    found, listed = doubted({"linkage_error": 0.52, "encoder_eccentricity": 0.48}, [FURTHER, RIVAL])
    assert (found.effect, found.joint) == RIVAL.key and listed == [RIVAL.key, FURTHER.key] and found.further == {FURTHER.key: 0.9}
    found, listed = doubted({"linkage_error": 0.8, "encoder_eccentricity": 0.2}, [FURTHER, RIVAL])
    assert (found.effect, found.joint) == FIRST.key and listed == [FIRST.key, FURTHER.key]
    assert found.doubts == {FIRST.key: ["lowpass"]}
    assert doubted({"linkage_error": 0.4, "encoder_eccentricity": 0.3, "unknown": 0.3}, [FURTHER, RIVAL])[0].doubts == {}  # it was no surer
    assert doubted({"linkage_error": 0.5, "encoder_eccentricity": 0.03, "unknown": 0.47}, [FURTHER, RIVAL])[1] == []


def test_further_effects_are_no_surer_than_their_limits_and_say_why():
    found = verdict.Verdict([(0.9, *FIRST.key)], PLAIN, 0.0)
    found.further, found.doubts = {FURTHER.key: 0.9, RIVAL.key: 0.3, ITS_OWN.key: 0.8}, {FURTHER.key: ["uneven"]}
    found.limit({FURTHER.key: (0.45, "noise"), RIVAL.key: (0.45, "noise"), ITS_OWN.key: (1.0, None)})
    assert found.further == {FURTHER.key: 0.45, RIVAL.key: 0.3, ITS_OWN.key: 0.8}
    assert found.doubts == {FURTHER.key: ["uneven", "noise"]}


def test_what_only_a_rivals_fit_has_is_not_said_with_confidence():
    found, listed = doubted({"linkage_error": 0.52, "encoder_eccentricity": 0.48}, [ITS_OWN, RIVAL])
    assert listed == [RIVAL.key, ITS_OWN.key] and found.further == {ITS_OWN.key: 0.45} and found.doubts[ITS_OWN.key] == ["unjudged"]
