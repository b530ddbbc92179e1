"""tools/talus/diagnosis/experiment/: the trajectories of the menu, the predicted gain against plain least squares and against the
experiment when it is run on the twin, and what the command writes."""

import json
import os

import numpy as np
import pytest
import yaml
from gap_in_process import recorded
from support import BUILD, REPOSITORY, run

import talus

os.environ.setdefault("TALUS_BUILD", str(BUILD))

from talus.diagnosis.experiment import choice  # noqa: E402
from talus.diagnosis.experiment.gain import Contest, Explanation, Pair  # noqa: E402
from talus.diagnosis.experiment.menu import TRAJECTORIES, beyond  # noqa: E402
from talus.diagnosis.experiment.path import STEP_S, Limits, held  # noqa: E402
from talus.diagnosis.experiment.planned import PAYLOAD_KG, Planned, with_payload  # noqa: E402
from talus.diagnosis.gram import Gram  # noqa: E402
from talus.diagnosis.search import search  # noqa: E402
from talus.diagnosis.verdict import judge  # noqa: E402

LEG = REPOSITORY / "models/leg.yaml"
HIDDEN = {"effect": "stribeck", "joint": "knee", "parameters": {"extra_Nm": 0.2, "speed_rad_s": 0.25, "exponent": 1.0}}
RIVAL = ("nonlinear_viscous", "knee")  # what looks like it


def write_truth(folder, *effects):
    tree = yaml.safe_load(LEG.read_text())
    if effects:
        tree["effects"] = list(effects)
    (folder / "truth.yaml").write_text(yaml.safe_dump(tree))
    return folder / "truth.yaml"


def simulate(folder, name, *more):
    run("talus-sim", "--model", folder / "truth.yaml", "--out", folder / name, *more)
    return folder / name


def searched(folder, *recordings):
    """(search, verdict) of recordings, in this process."""
    dataset, identified = recorded(LEG, folder, *recordings)
    found, fit = search(dataset, list(identified.base.values()))
    return found, judge(found, fit)


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    """(folder, search, verdict) of a bench with a cause that has a rival."""
    folder = tmp_path_factory.mktemp("twin")
    write_truth(folder, HIDDEN)
    return folder, *searched(folder, simulate(folder, "old.csv", "--duration", 40, "--seed", 3))


@pytest.fixture(scope="module")
def contest(twin):
    _, found, verdict = twin
    named = choice.explanation(found, verdict.fit.chosen, (HIDDEN["effect"], HIDDEN["joint"]))
    rival = choice.explanation(found, verdict.fit.chosen, RIVAL)
    return Contest(found, named, [rival], found.temperature_of(verdict.fit))


# ---- trajectories ------------------------------------------------------------------


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_a_trajectory_is_smooth_and_within_what_was_recorded(twin, name):
    terms = twin[1].all_terms[0]
    q = held(TRAJECTORIES[name][0](Limits([terms])))
    v, a = np.gradient(q, STEP_S, axis=1), np.gradient(np.gradient(q, STEP_S, axis=1), STEP_S, axis=1)
    assert 10 < q.shape[1] * STEP_S < 60
    for j in range(2):
        assert terms.q[j].min() < q[j].min() and q[j].max() < terms.q[j].max()
        assert np.abs(v[j]).max() < np.abs(terms.v[j]).max()
        assert np.abs(a[j]).max() < 1.3 * np.abs(terms.a[j]).max()
        assert np.ptp(q[j]) > 0.02  # it moves
        assert np.all(q[j, :5] == q[j, 0]) and np.all(q[j, -5:] == q[j, -1])
        assert np.isclose(q[j, 0], q[j, -1], atol=1e-6)  # repeats join


def test_slow_ramps_are_slow_and_fast_sines_are_fast(twin):
    limits = Limits(twin[1].all_terms)

    def middle_Hz(name):
        q = TRAJECTORIES[name][0](limits)[0]
        power = np.abs(np.fft.rfft(np.gradient(q))) ** 2
        return np.fft.rfftfreq(len(q), STEP_S)[np.searchsorted(np.cumsum(power), 0.5 * power.sum())]

    assert middle_Hz("fast_multisine") > 2.5 > 1.0 > middle_Hz("wide_multisine")
    slow = np.abs(np.gradient(TRAJECTORIES["slow_ramps"][0](limits)[0], STEP_S))
    assert slow.max() < 0.25
    for speed in (0.03, 0.08, 0.2):
        assert np.mean(np.isclose(slow, speed, rtol=0.02)) > 0.05


# ---- predicted gain ----------------------------------------------------------------


def rows_of(gram, columns):
    """(base columns, columns, reading) of all rows, weighted, side by side."""
    parts = [np.concatenate([plain, own]) for plain, own in zip(gram.plain, gram.gathered(columns))]
    rows = np.concatenate(parts, axis=1).T
    return rows[:, :gram.first], rows[:, gram.first + 1:], rows[:, gram.first]


def least_squares(rows, reading):
    scale = np.sqrt((rows**2).sum(0))
    scale[scale == 0] = 1
    strengths = np.linalg.lstsq(rows / scale, reading, rcond=1e-9)[0] / scale
    return strengths, float(np.sum((reading - rows @ strengths) ** 2))


def test_the_gain_is_that_of_least_squares_on_old_and_new_rows(twin, contest):
    found = twin[1]
    planned = Planned(found, held(TRAJECTORIES["speeds"][0](Limits(found.all_terms))))
    truth, rival = contest.named.sets[0], contest.others[0].sets[0]
    pair = Pair(found, truth, Explanation("one shape", [rival], 0.0))
    new = Gram(planned.dataset, [planned.terms], contest.candidates)
    columns = [[*truth[0].columns], [*rival[0].columns]]
    base, mine, reading = rows_of(found.gram, columns[0])
    strengths, _ = least_squares(np.hstack([base, mine]), reading)
    _, his, _ = rows_of(found.gram, columns[1])
    _, before = least_squares(np.hstack([base, his]), reading)
    new_base, new_mine, _ = rows_of(new, columns[0])
    _, new_his, _ = rows_of(new, columns[1])
    predicted = np.hstack([new_base, new_mine]) @ strengths
    both = np.vstack([np.hstack([base, his]), np.hstack([new_base, new_his])])
    _, after = least_squares(both, np.concatenate([reading, predicted]))
    assert np.isclose(pair.gain(new, found.gram.first), after - before, rtol=1e-3)


def test_the_truth_loses_nothing(twin, contest):
    """An explanation against itself gains no evidence, whatever is run."""
    found = twin[1]
    planned = Planned(found, held(TRAJECTORIES["wide_multisine"][0](Limits(found.all_terms))))
    pair = Pair(found, contest.named.sets[0], Explanation("itself", contest.named.sets[:1], 0.0))
    gram = Gram(planned.dataset, [planned.terms], contest.candidates)
    assert pair.gain(gram, found.gram.first) < 1e-3 * contest.gains(planned)[0].max()


@pytest.mark.long
def test_the_experiment_brings_what_was_predicted(twin, contest):
    """Run on the twin: the rival's excess over the named one grows as predicted, and the named one stands alone."""
    folder, found, verdict = twin
    limits = Limits(found.all_terms)
    option = min(choice.options(found, contest, limits), key=choice.Option.rank)
    predicted = option.repeats() * option.gains[0][0]
    words, needs = choice.why(found, verdict, contest, option, limits)
    assert contest.keys(option.reached(option.repeats())) == [{"effect": RIVAL[0], "joint": RIVAL[1]}] and needs is None
    assert f"{option.repeats() * option.length_s:.0f} s" in words and "predicted gain" in words
    q = np.concatenate([option.q] * option.repeats(), axis=1)
    (folder / "next.csv").write_text(choice.to_text(q, found.dataset.model, "next"))
    new = simulate(folder, "new.csv", "--reference", folder / "next.csv", "--seed", 5)
    again, told = searched(folder, folder / "old.csv", new)

    def lead(one):
        truth, rival = (choice.explanation(one, [one.gram.candidates[0]], key)
                        for key in ((HIDDEN["effect"], HIDDEN["joint"]), RIVAL))  # fmt: skip
        return rival.excess - truth.excess

    assert 0.5 < (lead(again) - lead(found)) / predicted < 2.0
    assert (told.effect, told.joint) == (HIDDEN["effect"], HIDDEN["joint"])
    assert RIVAL not in [(effect, joint) for _, effect, joint in told.confusable()]


def test_a_richer_form_is_judged_where_it_is_true():
    option = object.__new__(choice.Option)
    option.gains = choice.MARGIN * np.array([[1.0, 50.0], [30.0, 20.0], [40.0, 2.0]])
    option.contest = type("Contest", (), {"sizes": [[1, 2], [1, 1], [2, 1]], "temperature": 10.0})
    option.growth, option.most = 0.0, 4
    assert [option.worst(k) / choice.MARGIN for k in range(3)] == [50.0, 20.0, 40.0]
    assert np.isclose(option.needed(1), -20 * np.log(0.05) * choice.MARGIN)
    assert option.repeats() == 3 and option.reached(3) == [0, 1, 2]
    option.growth = 1e6  # the temperature grows as fast as the evidence: nothing is ever reached
    assert option.reached(4) == [] and option.repeats() == 4


def test_payload_is_a_mass_at_the_foots_centre():
    """The models with the mass added are those of a file that says so."""
    model = talus.Model.read(LEG)
    dataset = type("Evidence", (), {"model": model})
    base, given = with_payload(dataset, model)
    tree = yaml.safe_load(LEG.read_text())
    tree["foot"]["mass_kg"] += PAYLOAD_KG
    expected = talus.Model.from_tree(tree).base
    assert np.allclose(base, list(expected.values()), rtol=1e-9) and given.base == expected
    assert base[2] > model.base["foot_moment"]


# ---- words and files ---------------------------------------------------------------


def test_what_needs_more_than_a_trajectory_is_said():
    assert beyond(["asymmetric_friction", "current_offset"])[0] == "rest"
    assert beyond(["directional_efficiency"])[0] == "known mass"
    assert beyond(["linkage_error"])[0] == "camera"
    assert beyond(["stribeck"]) == (None, None)


@pytest.mark.long
def test_the_command_writes_a_file_that_the_twin_runs(twin, tmp_path):
    folder = twin[0]
    run("talus-gap", "--quick", "--model", LEG, "--report", tmp_path / "gap.json", folder / "old.csv")
    named = json.loads((tmp_path / "gap.json").read_text())["next_experiment"]["trajectory"]
    assert named == "gap.next.csv"
    lines = (tmp_path / named).read_text().splitlines()
    assert lines[0].startswith("# ") and lines[1] == "time_s,knee_rad,ankle_rad"
    run("talus-sim", "--model", LEG, "--out", tmp_path / "r.csv", "--reference", tmp_path / named)
    run("talus-gap", "--quick", "--model", LEG, "--report", tmp_path / "other.json", "--trajectory", tmp_path / "t.csv",
        folder / "old.csv")  # fmt: skip
    assert json.loads((tmp_path / "other.json").read_text())["next_experiment"]["trajectory"] == "t.csv"
    assert (tmp_path / "t.csv").read_bytes() == (tmp_path / named).read_bytes()
    assert not (tmp_path / "other.next.csv").exists()


def test_the_trajectory_is_no_other_file(tmp_path):
    for more in (("--trajectory", tmp_path / "g.json"), ("--trajectory", tmp_path / "x.csv")):
        (tmp_path / "x.csv").write_text("earlier")
        run("talus-gap", "--model", LEG, "--report", tmp_path / "g.json", *more, tmp_path / "x.csv", status=2)
        assert (tmp_path / "x.csv").read_text() == "earlier"
