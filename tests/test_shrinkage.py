"""The gap on a recording that was never given to the tool: how much of it the model file of talus-gap closes."""

import numpy
import pytest
from shrinkage import closed_fractions, measure, table
from support import data, needs_data

# effect, joint where it shows, and what is closed there at least
EXAMPLES = {"case_000": ("ankle", 0.99), "case_001": ("knee", 0.97), "case_027": ("ankle", 0.80)}


@needs_data
@pytest.mark.parametrize("case", [pytest.param(case, marks=pytest.mark.long) if case == "case_027" else case for case in EXAMPLES])
def test_the_model_file_closes_the_gap_on_an_unseen_recording(case, tmp_path):
    joint, bar = EXAMPLES[case]
    measured = measure(data("leg_cases") / case, tmp_path)
    assert measured["saved"] and measured["joints"][joint]["closed"] >= bar, "\n".join(table(case, measured))


@needs_data
@pytest.mark.long
def test_the_gap_closes_over_all_labelled_cases(tmp_path):
    """Where there is something to close and the catalogue has it; the cases were looked at, so this is no rate."""
    cases = sorted(p for p in data("leg_cases").glob("case_*"))
    measured = {case.name: measure(case, tmp_path / case.name) for case in cases}
    closed = closed_fractions([m for m in measured.values() if m["truth"] not in ("none", "unknown")])
    listed = "\n".join(line for name, m in measured.items() for line in table(name, m))
    assert len(closed) >= 20, listed
    assert numpy.median(closed) >= 0.95 and numpy.quantile(closed, 0.1) >= 0.70, listed
