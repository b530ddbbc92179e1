"""Verdicts on the labelled bench cases, also from other recordings of them than those that were looked at."""

import json

import pytest
from support import data, needs_data, run

TRAININGS = {
    "as they were made": ("train1", "train2", "train3"),
    "another one in the first's place": ("test", "train2", "train3"),
    "without the ramps": ("train1", "train2"),
    "without the faster one": ("train1", "train3"),
}
EXAMPLES = ("case_007", "case_010", "case_019")  # all of them in the long run


def answers(truth):
    """What may be named: (effect, joint)."""
    if truth["kind"] in ("none", "unknown"):
        return {(truth["kind"], "none")}
    named = {(effect["effect"], effect["joint"]) for effect in truth["effects"]}
    alias = {tuple(other) for effect in truth["effects"] for other in effect["alias_with"]}
    return named | alias | (set() if truth.get("observable", True) else {("none", "none")})


def verdict(case, trainings, folder):
    report = folder / f"{case.name}.json"
    run("talus-gap", "--quiet", "--model", case / "model.yaml", "--report", report,
        *(case / f"{name}.csv.gz" for name in trainings))  # fmt: skip
    said = json.loads(report.read_text())["verdict"]
    return said["effect"], said["joint"]


@needs_data
@pytest.mark.parametrize("name", EXAMPLES)
def test_the_hidden_cause_is_named_from_recordings_that_nobody_looked_at(name, tmp_path):
    case = data("leg_cases") / name
    truth = json.loads((case / "truth.json").read_text())
    assert verdict(case, TRAININGS["another one in the first's place"], tmp_path) in answers(truth)


@needs_data
@pytest.mark.long
@pytest.mark.parametrize("trainings", TRAININGS)
def test_the_hidden_cause_of_every_labelled_case_is_named(trainings, tmp_path):
    cases = sorted(path for path in data("leg_cases").glob("case_*"))
    truths = [json.loads((case / "truth.json").read_text()) for case in cases]
    said = [verdict(case, TRAININGS[trainings], tmp_path) for case in cases]
    wrong = [f"{case.name}: {named}" for case, truth, named in zip(cases, truths, said) if named not in answers(truth)]
    assert len(cases) >= 28 and not wrong, "\n".join(wrong)
