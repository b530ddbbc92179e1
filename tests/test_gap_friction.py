"""tools/gap/catalogue/friction.py, on the withheld cases' bench, which shares no code with the library."""

import json

from support import run

from blind import cases, effects

TRAVEL_RAD = 0.02


def test_presliding_that_is_most_of_the_friction_is_named(tmp_path):
    """An ankle that hardly ever slides leaves the plain model next to no Coulomb friction to tell the effect's size by.
    Iwan's friction, of which the library knows Dahl's: all of it like a spring over 20 mrad."""
    case = cases.Case(5, 0, {"none": 1.0})
    shape = {"pre_form": 3.0, "pre_share": 1.0, "pre_travel": TRAVEL_RAD, "pre_power": 0.5, "pre_rise": 0.0077, "pre_speed": 0.18}
    case.drawn = [effects.Drawn("presliding", "ankle", "Iwan", "long travel", effects.of("ankle", **shape))]
    cases.write_case(tmp_path, case, case.simulate(case.drawn))
    (folder,), report = tmp_path.glob("case_*"), tmp_path / "gap.json"
    run("talus-gap", "--quiet", "--model", folder / "model.yaml", "--report", report, *sorted(folder.glob("train*.csv.gz")))
    found = json.loads(report.read_text())
    assert (found["verdict"]["effect"], found["verdict"]["joint"]) == ("presliding", "ankle")
    assert found["verdict"]["probability"] > 0.9 and found["gap"]["ankle"]["closed_fraction"] > 0.9
    (friction,) = (e["parameters"] for e in found["effects"])
    assert TRAVEL_RAD / 2 < friction["travel_rad"] < 2 * TRAVEL_RAD  # another form's: the same size
