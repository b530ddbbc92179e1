"""A bench with an effect built into it and its diagnosis: the withheld cases' simulator, which shares no code with the library."""

import json

from support import run

from talus.blind import cases, effects, plants


def leg_mass_kg():
    """What hangs from the mount: shank, foot and ankle motor."""
    return sum(plants.FIXED[part] for part in ("ms", "mf", "mm"))


def bench_with(folder, effect, joint, hidden):
    """The folder of a bench with an effect hidden in it; `hidden`: what the simulator is told."""
    case = cases.Case(5, 0, {"none": 1.0})
    case.drawn = [effects.Drawn(effect, joint, "", "", hidden)]
    cases.write_case(folder, case, case.simulate(case.drawn))
    (bench,) = folder.glob("case_*")
    return bench


def diagnosed(bench, effect, joint):
    """Parameters that talus-gap finds of the hidden effect; the verdict must name it, sure of it, nothing else be listed, and
    the gap at the joint (the knee, for one at the base) close. The fitted model is fitted.yaml in the bench's folder."""
    report = bench / "gap.json"
    run("talus-gap", "--quiet", "--model", bench / "model.yaml", "--report", report, "--save-model", bench / "fitted.yaml",
        *sorted(bench.glob("train*.csv.gz")))  # fmt: skip
    found = json.loads(report.read_text())
    assert (found["verdict"]["effect"], found["verdict"]["joint"]) == (effect, joint)
    gap = found["gap"]["knee" if joint == "base" else joint]
    assert found["verdict"]["probability"] > 0.9 and gap["closed_fraction"] > 0.9
    (listed,) = found["effects"]
    return listed["parameters"]
