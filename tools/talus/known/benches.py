"""Sound recordings with a model as a user would have it: simulated benches of any make (docs/blind.md, the wide protocol), with an
effect or without, and recordings of real machines."""

import itertools
import tempfile
from pathlib import Path

import numpy as np
import talus

from ..blind import cases, wide
from ..diagnosis.gate import excerpt
from .machine import model_text, recordings
from .spoilings import Bench

PLANTS = ("leg", "pendulum", "slider", "pendulum")  # a pendulum's encoder sits at the motor or behind the gear
CASES = ("wild_leg", "wild_pendulum", "leg_cases")  # of the data, with several recordings each
HANGS = "stuck sensor"  # of what may be hidden: a fault, and not a machine's effect


def numbers(seed, count):
    """Case numbers of the wide protocol so that plants take turns."""
    waiting = {plant: with_plant(seed, plant) for plant in PLANTS}
    return [next(waiting[plant]) for plant in itertools.islice(itertools.cycle(PLANTS), count)]


def with_plant(seed, plant):
    """Case numbers, in order, of cases that draw this plant first."""
    return (number for number in itertools.count() if first_plant(seed, number) == plant)


def first_plant(seed, number):
    """The plant that a case draws first."""
    return wide.draw_plant(np.random.default_rng([seed, number + 1, 0])).kind


def simulated(name, seed, number, mix):
    """A case of the wide protocol: (Bench, what it hides). What it hides is an effect, but no sensor that hangs."""
    case = cases.Case(seed, number, mix, "wide")
    while any(one.form == HANGS for one in case.drawn):
        case.redraw(case.streams["effect"].uniform())
    with tempfile.TemporaryDirectory(prefix="gate-") as folder:
        cases.write_case(Path(folder), case, cases.settle(case))
        bench = bench_of(name, plant_of(case), *files_of(next(Path(folder).iterdir())))
    return bench, ", ".join(one.effect if one.effect != "unknown" else one.form for one in case.drawn)


def plant_of(case):
    """Its kind; of one joint alone that turns, whose encoder may be on either side of the gear, where that is."""
    turns = getattr(case.plant, "units", ("",))[0] == "rad"
    return f"{case.plant.kind}, encoder {'behind the gear' if case.noise['behind'] else 'at the motor'}" if turns else case.plant.kind


def files_of(folder):
    """(model, [recordings]) of a case's folder."""
    return talus.Model.read(folder / "model.yaml"), sorted(folder.glob("train*.csv.gz"))


def bench_of(name, plant, model, files):
    """As talus-gap reads them: of long recordings some stretches."""
    names, read, _ = excerpt.read([str(file) for file in files], model)
    return Bench(name, plant, model, [dict(r.columns) for r in read],
                 [Path(r.origin.path or path).name for path, r in zip(names, read, strict=True)])  # fmt: skip


def real(data):
    """[(name, plant, model file's text, [file])] of the real machines and of the cases in the data folder."""
    out = [(path.stem, path.parent.name, model_text(path), [path]) for path in recordings(data)]
    for kind in CASES:
        out += [(f"{kind}-{case.name}", kind, (case / "model.yaml").read_text(encoding="utf-8"), files_of(case)[1])
                for case in sorted((Path(data) / kind).glob("case_*"))]  # fmt: skip
    return out
