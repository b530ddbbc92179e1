"""tools/talus/diagnosis/calibration/further.py: each further effect, judged in its own place."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from support import run
from talus.blind import cases
from talus.diagnosis import verdict
from talus.diagnosis.calibration import further, thresholds
from talus.diagnosis.search import Fit, Search


def candidate(effect):
    return SimpleNamespace(key=(effect, "joint"))


FIRST, GIVEN, RIVAL = candidate("friction_drift"), candidate("presliding"), candidate("backlash")


def fit_of(chosen):
    return SimpleNamespace(chosen=list(chosen))


@pytest.fixture
def judged(monkeypatch):
    """The verdict's further effects, where two rivals share the second place as given, another low-pass shows them or not, and they have
    the same size everywhere but for the `uneven` one."""

    def judge(shares, shown=True, nothing=0.0, uneven=None):
        monkeypatch.setattr(verdict, "rivals", lambda search, fit: [fit_of([FIRST, GIVEN]), fit_of([FIRST, RIVAL])])
        monkeypatch.setattr(verdict, "shares", lambda search, fit, rivals, sets: np.array(shares))
        monkeypatch.setattr(verdict, "other_sets", lambda search, fit: [fit_of([RIVAL, FIRST])] * (len(shares) - 2))
        monkeypatch.setattr(further, "survives", lambda search, fit, rivals, dataset: shown)
        monkeypatch.setattr(further, "is_uneven", lambda search, fit: fit.chosen[-1] is uneven)
        search = SimpleNamespace(fit=fit_of, further={GIVEN.key: nothing})
        found = SimpleNamespace(fit=fit_of([FIRST, GIVEN]), further={}, doubts={})
        return further.judged(search, found, elsewhere=object())

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


def test_what_another_low_pass_does_not_show_is_doubted(judged):
    hidden, shown = judged([1.0, 0.0], shown=False), judged([1.0, 0.0])
    assert hidden.further == {GIVEN.key: thresholds.NEARLY_HALF} and hidden.doubts == {GIVEN.key: ["lowpass"]}
    assert shown.further == {GIVEN.key: pytest.approx(1.0)} and shown.doubts == {GIVEN.key: []}


def test_what_has_another_size_elsewhere_is_doubted(judged):
    found = judged([0.9, 0.1], uneven=GIVEN)
    assert found.further == {GIVEN.key: thresholds.NEARLY_HALF} and found.doubts == {GIVEN.key: ["uneven"]}
    assert judged([0.9, 0.1], uneven=GIVEN, shown=False).doubts == {GIVEN.key: ["uneven", "lowpass"]}
    assert judged([0.9, 0.1], uneven=RIVAL).further == {GIVEN.key: pytest.approx(0.9)}
    assert judged([0.1, 0.9], uneven=RIVAL).further == {RIVAL.key: thresholds.NEARLY_HALF}


@pytest.mark.parametrize("no_cause", ["none", "unknown"])
def test_a_further_effect_is_no_surer_than_that_there_is_any(no_cause):
    """A report gives it the share of what some effect has."""
    found = verdict.Verdict([(0.45, "backlash", "joint"), (0.05, "elasticity", "joint"), (0.5, no_cause, "none")], fit_of([FIRST]), 0.2)
    assert found.known == pytest.approx(0.5)


def test_behind_what_replicates_gain_as_well_another_effect_may_stand():
    likely_nothing = {GIVEN.key: 0.9, RIVAL.key: 0.1}
    search = SimpleNamespace(nothing=lambda before, fit: likely_nothing[fit.chosen[-1].key])
    found = [fit_of([FIRST, GIVEN]), fit_of([FIRST, RIVAL])]
    assert Search._something(search, fit_of([FIRST]), found) == found[1:]


def test_a_further_effect_is_judged_at_its_own_joint_whichever_was_found_first():
    """Of an ankle's friction found first and a knee's ripple the ripple is there already: what stands open at the ankle counts."""
    ripple, friction = SimpleNamespace(key=("kinematic_error", "knee"), joint="knee"), SimpleNamespace(key=("stribeck", "ankle"), joint="ankle")
    seen = []
    search = SimpleNamespace(_is_beyond_forms=lambda before, candidate: candidate is friction,
                             significant=lambda before, after, *rest: not seen.append(after))  # fmt: skip
    assert Search.is_worth_adding(search, Fit([ripple], 1e3, [[3.0]]), Fit([friction, ripple], 1e2, [[4.0], [5.0]]))
    assert seen[0].chosen == [ripple, friction] and seen[0].strengths == [[5.0], [4.0]] and seen[0].excess == 1e2


class Toy(Search):
    """A search whose excesses are given, {effects: excess}; a further effect is worth one where it closes half of what the others leave, and
    nothing where `empty` says so."""

    def __init__(self, left, empty=()):
        self.left, self.empty, self.refined = left, empty, []
        self.plain = self.fit([])

    def fit(self, chosen):
        chosen = list(chosen)
        return SimpleNamespace(chosen=chosen, excess=self.left[frozenset(c.key[0] for c in chosen)])

    def ordered(self, fit):
        without = lambda one: self.fit([c for c in fit.chosen if c is not one]).excess
        return self.fit(sorted(fit.chosen, key=without, reverse=True))

    def reshaped(self, fit):
        return fit

    def all_refined(self, fit):
        self.refined.append([c.key[0] for c in fit.chosen])
        return fit

    def is_worth_adding(self, before, after):
        return after.excess < 0.5 * before.excess

    def is_nothing(self, before, after):
        return any(c.key[0] in self.empty for c in after.chosen if c not in before.chosen)


def kept(left, chosen, before, empty=()):
    """(effects of the set that is kept, sets that were refined for that)."""
    search = Toy({frozenset(names.split()): excess for names, excess in left.items()}, empty)
    found = search._with_worthy_last(search.fit(map(candidate, chosen.split())), search.fit(map(candidate, before.split())))
    return " ".join(c.key[0] for c in found.chosen), search.refined


def test_what_was_found_first_goes_where_the_second_explains_it_better():
    """A delay alone closes more than lost motion in the grid's shapes does; beside the right shape it closes a fifth."""
    left = {"": 1000.0, "delay": 500.0, "backlash": 125.0, "delay backlash": 100.0}
    assert kept(left, "delay backlash", before="delay") == ("backlash", [["backlash"]])
    assert kept({**left, "backlash": 400.0}, "delay backlash", before="delay") == ("backlash delay", [["backlash"]])
    assert kept({**left, "backlash": 400.0}, "delay backlash", before="delay", empty=["delay"])[0] == "backlash"


def test_a_set_that_is_in_the_order_in_which_it_was_found_was_tried_already():
    assert kept({"": 1000.0, "stribeck": 400.0, "delay": 900.0, "stribeck delay": 150.0}, "stribeck delay", before="stribeck") == ("stribeck delay", [])


def test_of_three_the_rest_is_tried_as_well():
    left = {"": 1000.0, "a": 800.0, "b": 700.0, "c": 110.0, "a b": 600.0, "a c": 108.0, "b c": 105.0, "a b c": 100.0}
    assert kept(left, "a b c", before="a b")[0] == "c"


@pytest.mark.parametrize(("left", "empty", "found"), [
    ({}, (), "constant delay friction"),  # each alone closes less than half beside the constant, and both nearly all
    ({"constant friction": 690.0}, (), "constant delay friction"),
    ({"constant delay": 170.0}, (), "constant"),  # friction is not worth adding to a delay that does as well alone
    ({}, ["delay"], "constant"),
    ({"delay friction": 150.0}, (), "constant"),  # nor what was found first
])  # fmt: skip
def test_two_effects_that_hide_each_other_are_taken_together_or_not_at_all(left, empty, found):
    plain = {"": 9000.0, "constant": 1000.0, "constant delay": 600.0, "constant friction": 590.0, "delay friction": 5000.0, "constant delay friction": 100.0}
    search = Toy({frozenset(names.split()): excess for names, excess in {**plain, **left}.items()}, empty)
    search._followed = lambda pairs: [search.fit([best.chosen[0], *beside]) for _ in pairs]
    search._near_refined, search.other_sets = list, []
    beside = [candidate(name) for name in ("delay", "friction")]
    best = search.fit([candidate("constant")])
    got = search._together(best, [search.fit([*best.chosen, one]) for one in beside])
    assert {c.key[0] for c in got.chosen} == set(found.split())


class Open(Search):
    """A search in which a further effect gains much; the first one explains 1000 at its joint, in one of several forms."""

    tolerated_of = {"T0": 10.0}
    dataset = SimpleNamespace(scopes_at=lambda joint: 3 * (["T0"],))

    def __init__(self, left, irregular):
        self.left, self.irregular = left, irregular
        self.gram = SimpleNamespace(candidates=[candidate("base_compliance")] * 2)

    def fit(self, chosen):
        return Fit(chosen, self.left if chosen else 1000.0 + self.left, [[1.0] for _ in chosen])

    def held_out_excess(self, chosen):
        return {"T0": self.fit(chosen).excess}

    def excess_by_kind(self, fit):
        return {"T0": fit.excess + self.irregular}

    def significant(self, *about):
        return True


@pytest.mark.parametrize(("left", "irregular", "worth"), [(5.0, 0.0, False), (29.0, 0.0, False), (31.0, 0.0, True), (5.0, 26.0, True)])
def test_what_does_not_come_back_stands_open_as_well(left, irregular, worth):
    """A fiftieth of what the first effect explains, beyond the tolerance; friction that drifts leaves little chi-square where it passes for noise."""
    one, more = candidate("base_compliance"), candidate("friction_drift")
    one.joint = more.joint = "joint"
    search = Open(left, irregular)
    assert search.is_worth_adding(search.fit([one]), search.fit([one, more])) is worth


class Leg(Open):
    """The same of a leg whose ankle has an encoder with less noise than is allowed for: the first effect explains so much of each channel,
    and leaves so much."""

    tolerated_of = {"E": 10.0, "T0": 10.0, "T1": 10.0}
    dataset = SimpleNamespace(scopes_at=lambda joint: (["E", "T0", "T1"], ["T0"], ["T0"]) if joint == "knee" else (["E", "T0", "T1"], ["E", "T1"], ["T1"]))

    def __init__(self, explained, left):
        super().__init__(0.0, 0.0)
        self.explained, self.left_of = explained, left

    def held_out_excess(self, chosen):
        return self.left_of if chosen else {kind: self.explained[kind] + self.left_of[kind] for kind in self.left_of}

    def excess_by_kind(self, fit):
        return self.left_of


@pytest.mark.parametrize(("joints", "explained_E", "left", "worth"), [
    (("ankle", "ankle"), 0.0, {"E": -2000.0, "T0": 0.0, "T1": 31.0}, True),  # an encoder below its noise hides nothing of the torque
    (("ankle", "ankle"), 1e6, {"E": 0.0, "T0": 0.0, "T1": 31.0}, True),  # nor what the first effect does to it
    (("ankle", "ankle"), 0.0, {"E": -2000.0, "T0": 0.0, "T1": 29.0}, False),  # what other forms of that may leave of the torque
    (("ankle", "ankle"), 0.0, {"E": -2000.0, "T0": 1000.0, "T1": 29.0}, False),  # what is open at the other joint is another's
    (("ankle", "knee"), 0.0, {"E": -2000.0, "T0": 11.0, "T1": 0.0}, True),  # which is no form of what acts there
])  # fmt: skip
def test_channels_below_their_noise_do_not_hide_what_another_shows(joints, explained_E, left, worth):
    one, more = candidate("linkage_error"), candidate("stribeck")
    one.joint, more.joint = joints
    search = Leg({"E": explained_E, "T0": 0.0, "T1": 1000.0}, left)
    search.gram = SimpleNamespace(candidates=[one, one])
    assert search.is_worth_adding(search.fit([one]), search.fit([one, more])) is worth


def test_where_the_one_that_closes_most_is_nothing_another_is_taken():
    """Of a ripple found first, a spring that replicates have as well, a friction, and one that closes too little."""
    left = {"": 1000.0, "ripple": 400.0, "ripple spring": 100.0, "ripple friction": 150.0, "ripple delay": 300.0}

    def another(empty):
        search = Toy({frozenset(names.split()): excess for names, excess in left.items()}, empty)
        sets = [search.fit([candidate("ripple"), candidate(name)]) for name in ("spring", "friction", "delay")]
        return search._another(search.fit([candidate("ripple")]), sets)

    assert [[c.key[0] for c in another(empty).chosen] for empty in ((), ["spring"])] == [["ripple", "spring"], ["ripple", "friction"]]
    assert another(["spring", "friction"]) is None


class Wandering(Search):
    """A search of one torque with a noise of 1000 degrees of freedom, of which the first effect leaves so much, and the second nothing."""

    detection_threshold, floor_of = 30.0, {"T0": 100.0}
    dataset = SimpleNamespace(kinds=["T0"], scopes_at=lambda joint: 3 * (["T0"],), freedom=lambda kind: 1000.0)

    def __init__(self, left, apart):
        self.left, self.apart = left, apart

    def excess_by_kind(self, fit):
        return {"T0": self.left[len(fit.chosen) - 1] + self.apart[len(fit.chosen) - 1]}

    def irregular(self, fit):
        return {"T0": self.apart[len(fit.chosen) - 1]}

    def share(self):
        effects = [SimpleNamespace(key=(effect, "joint"), joint="joint") for effect in ("parallel_spring", "friction_drift")]
        one, both = (SimpleNamespace(chosen=effects[:count]) for count in (1, 2))
        return self._worth_more(one), self._share(one, both, *({"T0": np.array([1000.0 + x])} for x in self.left))


@pytest.mark.parametrize(("left", "apart", "worth", "share"), [
    ((101.0, -900.0), (0.0, 0.0), False, 1001.0),  # less than noise is open, and not looked at
    ((101.0, -900.0), (4000.0, 0.0), True, 5001.0 / 4001.0),  # a drift that was in the noise: all that stood open closes
    ((101.0, 51.0), (4000.0, 3990.0), True, 60.0 / 4001.0),  # little of what does not come back
    ((1100.0, 100.0), (4000.0, 4000.0), True, 1.0),  # an effect that comes back with the motion, beside something that does not
])  # fmt: skip
def test_what_does_not_come_back_is_what_a_further_effect_must_close_where_nothing_else_stands_open(left, apart, worth, share):
    assert Wandering(left, apart).share() == (worth, pytest.approx(share))


@pytest.mark.long
@pytest.mark.parametrize(("number", "hidden"), [
    (0, {"linkage_error", "stribeck"}),  # two at the ankle
    (23, {"gravity_tilt", "delay"}),  # the bench, and the knee
    (33, {"elasticity", "asymmetric_friction"}),  # one at each joint: a constant torque is one either way
])  # fmt: skip
def test_the_second_effect_of_a_leg_is_named_whatever_its_encoders_leave(tmp_path, number, hidden):
    """Benches of the other simulator that hide two effects; beside the first one an encoder lies below the noise that is allowed for."""
    cases.make(861, number, mix={"pair": 0.75, "single": 0.25}, folder=tmp_path, protocol="wide")
    report, case = tmp_path / "gap.json", next(tmp_path.glob("**/model.yaml")).parent
    run("talus-gap", "--quiet", "--model", case / "model.yaml", "--report", report, *sorted(case.glob("train*")))
    found = {one["effect"]: one["probability"] for one in json.loads(report.read_text())["effects"]}
    assert set(found) == hidden and min(found.values()) > 0.9
