"""The gap on a recording that was never given to the tool: how much of it the model file of talus-gap closes. All labelled cases:
test_gap_cases.py."""

import pytest
from shrinkage import measure, table
from support import data, needs_data

# effect, joint where it shows, and what is closed there at least
EXAMPLES = {"case_000": ("ankle", 0.99), "case_001": ("knee", 0.97)}


@pytest.mark.long
@needs_data
@pytest.mark.parametrize("case", EXAMPLES)
def test_the_model_file_closes_the_gap_on_an_unseen_recording(case, tmp_path):
    joint, bar = EXAMPLES[case]
    measured = measure(data("leg_cases") / case, tmp_path)
    assert measured["saved"] and measured["joints"][joint]["closed"] >= bar, "\n".join(table(case, measured))
