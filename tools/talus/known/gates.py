"""The gate on spoiled recordings and on sound ones: the draw, what it is asked, and what came of one set of recordings."""

from dataclasses import dataclass

import talus

from ..diagnosis import experiment, gate
from ..diagnosis.calibration import lowpass
from . import benches, spoilings

NOTHING, SOMETHING = {"none": 1.0}, {"single": 0.45, "pair": 0.2, "unknown": 0.35}
LEFT_SOUND = 5  # benches with an effect, that are left as they are, for each one that is spoiled


@dataclass(frozen=True)
class Simulated:
    """A bench of the wide protocol. What hides nothing is spoiled, too."""

    seed: int
    number: int
    hides: bool

    @property
    def name(self):
        return f"{'effect' if self.hides else 'plain'}-{self.number:05d}"

    @property
    def spoils(self):
        return not self.hides

    def bench(self):
        """(Bench, what it hides)."""
        return benches.simulated(self.name, self.seed, self.number, SOMETHING if self.hides else NOTHING)


@dataclass(frozen=True)
class Recorded:
    """Recordings of the data folder."""

    seed: int
    name: str
    plant: str
    model: str
    files: tuple

    spoils = True

    def bench(self):
        return benches.bench_of(self.name, self.plant, talus.Model.from_text(self.model), self.files), ""


def draw(data, seed, count):
    """`count` plain benches, so many times as many with an effect, of other numbers, and all of the data folder."""
    numbers = benches.numbers(seed, (1 + LEFT_SOUND) * count)
    simulated = [Simulated(seed, number, k >= count) for k, number in enumerate(numbers)]
    return [*simulated, *(Recorded(seed, name, plant, text, tuple(files)) for name, plant, text, files in benches.real(data))]


def asked(model, names, recordings):
    """What talus-gap finds before it looks for a cause: the gate's findings, and without a grave one whether there is enough to see."""
    found = gate.findings(model, names, recordings)
    if any(f.grave for f in found):
        return found
    poor = experiment.too_poor(lowpass.processed_at(model, recordings, names, model.score.lowpass_hz))
    return [poor, *found] if poor else found


def findings_of(bench):
    """[{finding}] of a bench."""
    names, recordings = bench.objects()
    return [f.entry() for f in asked(bench.model, names, recordings)]


def spoiled(bench, seed):
    """What is said of each kind of fault that this bench can have."""
    out = []
    for kind in spoilings.KINDS:
        one = spoilings.spoil(bench, kind, seed)
        if one:
            out.append({"kind": kind, "finding": one.finding, "column": one.column, "findings": findings_of(one.bench)})
    return out


def examine(case):
    """What is said of a case as it is, and spoiled."""
    bench, hidden = case.bench()
    step = spoilings.step_s(bench.recordings[0])
    setting = {"plant": bench.plant, "hidden": hidden, "rate_Hz": round(1 / step), "rows": sum(len(c["time_s"]) for c in bench.recordings)}
    return {"setting": setting, "sound": findings_of(bench), "spoiled": spoiled(bench, case.seed) if case.spoils else []}
