"""tools/talus/diagnosis/effects: one entry for each effect of the library, and nothing else that asks for an effect by its id."""

import ast

import pytest
from support import REPOSITORY
from talus.diagnosis import effects, kinds
from talus.diagnosis.experiment.menu import BEYOND, TRAJECTORIES

DIAGNOSIS = REPOSITORY / "tools/talus/diagnosis"
# the judge of the withheld cases draws effects in forms of its own and must not follow the diagnosis
# what draws effects of its own, and what another program's file can say of each
DRAWN = {"blind/effects.py", "known/spikes.py", "known/camera_scores.py", "known/fleet.py"}
SAID_ELSEWHERE = {"exporting/target.py", "exporting/terms.py"}
MAY_NAME_THEM = {*(REPOSITORY / "tools/talus" / name for name in DRAWN | SAID_ELSEWHERE), *DIAGNOSIS.glob("effects/*.py")}
COORDINATES = {"position", "velocity", "acceleration", "load", "current", "time", "reversal", "motor_angle", "frequency", "encoder"}


def test_every_effect_of_the_library_has_one_entry_in_a_file_of_its_name():
    assert list(effects.EFFECTS) == kinds.ids()
    assert {path.stem for path in DIAGNOSIS.glob("effects/*.py")} == {*kinds.ids(), "__init__", "entry"}


@pytest.mark.parametrize("effect", effects.EFFECTS.values(), ids=list(effects.EFFECTS))
def test_an_entry_is_in_the_words_of_the_rest(effect):
    assert effect.words and not effect.words.endswith(".")
    assert set(effect.coordinates) <= COORDINATES
    assert effect.trajectory in TRAJECTORIES
    assert effect.needs is None or effect.needs in [needs for needs, _ in BEYOND]


def texts(path):
    """Every text of a Python source, docstrings apart."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    notes = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    return {node.value for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in notes}  # fmt: skip


def test_no_other_module_asks_for_an_effect_by_its_id():
    sources = [*(REPOSITORY / "tools").rglob("*.py"), REPOSITORY / "tools/demo"]
    asking = {str(path): found for path in set(sources) - MAY_NAME_THEM if (found := texts(path) & set(kinds.ids()))}
    # a column of delays in a report of its own, no effect
    assert asking == {str(REPOSITORY / "tools/talus/acquire_export/report.py"): {"delay"}}
