"""Diagnosis of real recordings: docs/diagnosis.md has a table of verdicts and errors, and this runs it."""

import json
import re

import pytest
from support import REPOSITORY, data, needs_data, run

ROW = re.compile(r"^\| `(\w+)/([\w-]+)` \| `(\w+)` \((\d\.\d\d)\) \| ([^|]*) \| ([\d.]+) → ([\d.]+) % \|", re.MULTILINE)
FOLDERS = {"emps": "emps", "ur10e": "ur10e_joints", "ak80": "ak80_9_dyno", "embir": "embir_dyno"}


def rows():
    return ROW.findall((REPOSITORY / "docs" / "diagnosis.md").read_text(encoding="utf-8"))


def diagnose(folder, name, tmp_path):
    base, report = FOLDERS[folder], tmp_path / "gap.json"
    run("talus-gap", "--quiet", "--model", data(f"{base}/model.yaml"), "--report", report, data(f"{base}/{name}.csv"))
    return json.loads(report.read_text())


def test_the_table_has_every_set():
    assert {folder for folder, *_ in rows()} == set(FOLDERS)


@needs_data
@pytest.mark.parametrize(("folder", "name", "verdict", "probability", "effects", "before", "after"), rows())
def test_a_row_of_the_table(folder, name, verdict, probability, effects, before, after, tmp_path):
    found = diagnose(folder, name, tmp_path)
    assert found["verdict"]["effect"] == verdict
    assert found["verdict"]["probability"] == pytest.approx(float(probability), abs=0.02)
    listed = [] if effects.strip() == "none" else effects.replace("`", "").replace(" ", "").split(",")
    assert [e["effect"] for e in found["effects"]] == listed
    gap = next(iter(found["gap"].values()))
    for figure, want in (("identified_rms", before), ("extended_rms", after)):
        assert 100 * gap[figure] / gap["measured_rms"] == pytest.approx(float(want), abs=0.06), figure
