"""The numbers that decide a verdict stand in one file, and docs/diagnosis.md has them as they are."""

import ast
import math
import re
from fractions import Fraction

from support import REPOSITORY
from talus.diagnosis.calibration import thresholds

DIAGNOSIS = REPOSITORY / "tools/talus/diagnosis"
ROW = re.compile(r"^\| (`[A-Z_]+`(?:, `[A-Z_]+`)*) \| ([^|]+) \| [^|]{20,} \|$", re.MULTILINE)
STEERING = {  # what saves time, numerics, or how a page prints it
    "search.py": {"BEAM", "MOST_JOINED", "PROMISING", "REFINED"},
    "verdict.py": {"HOPELESS", "LEAST_PROBABILITY", "CONFUSABLE_ABOVE"},
    "irregular.py": {"VIEWS"},
    "machine/drawing.py": set(),
    "machine/pushes_back.py": {"PLACES"},
    "outside/beside.py": {"HOPELESS"},
    "calibration/gains.py": {"FEWEST", "MOST", "SURE_BELOW", "SURE_ABOVE"},
    "calibration/stability.py": {"MOST_RIVALS"},
    "calibration/further.py": set(),
    "calibration/lowpass.py": {"STEP", "SLOWEST_HZ", "ALL_OF_IT"},
}


def values():
    return {name: value for name, value in vars(thresholds).items() if name.isupper()}


def of_words(text):
    return math.log(float(text.removeprefix("ln "))) if text.startswith("ln ") else float(Fraction(text))


def test_the_docs_have_each_threshold_with_its_value_and_its_reason():
    told = {}
    for names, numbers in ROW.findall((REPOSITORY / "docs/diagnosis.md").read_text(encoding="utf-8")):
        told |= dict(zip(re.findall(r"[A-Z_]+", names), map(of_words, numbers.split(", ")), strict=True))
    assert told == values()


def test_they_are_at_most_fifteen():
    assert len(values()) <= 15


def test_what_decides_a_verdict_stands_nowhere_else():
    for name, steering in STEERING.items():
        tree = ast.parse((DIAGNOSIS / name).read_text(encoding="utf-8"))
        targets = [target for node in tree.body if isinstance(node, ast.Assign) for target in node.targets]
        names = [n.id for target in targets for n in ast.walk(target) if isinstance(n, ast.Name) and n.id.isupper()]
        assert set(names) == steering, name
