"""talus-sim's benches without any effect: the grid, a draw from it, and one case's recording."""

import itertools
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import talus

from . import running

AXES = {
    "plant": ("leg", "pendulum", "slider"),
    "rate_Hz": (100, 125, 200, 250, 500, 1000),
    "bits": (12, 14, 16, 20, 0),  # 0 is exact, as talus-sim has it
    "excitation": ("multisine", "paper", "ramps"),
    "length_s": (20, 60, 300),
}


@dataclass(frozen=True)
class Null:
    """A bench that hides nothing. `round` counts how often the whole grid was drawn before."""

    seed: int
    round: int
    plant: str
    rate_Hz: int
    bits: int
    excitation: str
    length_s: int

    @property
    def encoder(self):
        return f"{self.bits}bit" if self.bits else "exact"

    @property
    def name(self):
        again = f"-again{self.round}" if self.round else ""
        return f"{self.plant}-{self.rate_Hz}Hz-{self.encoder}-{self.excitation}-{self.length_s}s{again}"

    @property
    def setting(self):
        return {axis: getattr(self, axis) for axis in AXES}

    def command(self, out):
        """talus-sim's, which makes the recording anew. Phases and noise come from the seed, the round and the case."""
        place = list(itertools.product(*AXES.values())).index(tuple(self.setting.values()))
        seed = int(np.random.SeedSequence([self.seed, self.round, place]).generate_state(1)[0])
        bits = ["--encoder-bits", str(self.bits), *(["--ankle-bits", str(self.bits)] if "ankle" in talus.Model(self.plant).joints else [])]
        return [str(running.BUILD / "bin" / "talus-sim"), "--model", str(model_of(self.plant)), "--out", str(out),
                "--excitation", self.excitation, "--fit", "--rate", str(self.rate_Hz), "--duration", str(self.length_s),
                "--seed", str(seed), *bits]  # fmt: skip


def model_of(plant):
    return running.ROOT / "models" / f"{plant}.yaml"


def draw(seed, count, only=None):
    """The first `count` of the grid in an order by the seed, so that a case is the same however many are drawn; `only` {axis:
    values} keeps the others out. After the whole grid it begins anew with other phases and noise."""
    points = list(itertools.product(*AXES.values()))
    rng, cases, rounds = np.random.default_rng(seed), [], 0
    while len(cases) < count:
        drawn = [Null(seed, rounds, *points[k]) for k in rng.permutation(len(points))]
        kept = [case for case in drawn if all(case.setting[axis] in values for axis, values in (only or {}).items())]
        if not kept:
            raise ValueError("no case of the grid is like that")
        cases += kept
        rounds += 1
    return cases[:count]


def diagnose(case):
    """A case's recording made, and what talus-gap says of it with the model that made it."""
    with tempfile.TemporaryDirectory(prefix="nulls-") as temporary:
        recording = Path(temporary) / "recording.csv.gz"
        made = subprocess.run(case.command(recording), check=False, capture_output=True, text=True)
        if made.returncode:
            raise RuntimeError(f"{case.name}: talus-sim: {made.stderr.strip()}")
        out = running.diagnosed(model_of(case.plant), recording, Path(temporary))
    return {"setting": case.setting, "bench": made.stderr.strip(), **out}
