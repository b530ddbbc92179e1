"""Reported standard deviations against the truth of simulated benches: plants x rates x encoders x motions x seeds.

`TALUS_BUILD=build python tests/sigma_table.py 30` prints the whole table for seeds 1 to 30: for each bench the share of parameters within
three standard deviations, how many had none (hidden by noise), and the inertias' mean errors.
"""

import itertools
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from support import REPOSITORY, run

PLANTS = ("leg", "pendulum", "slider")
RATES = (100, 200, 250, 1000)
BITS = (12, 14, 16)
MOTIONS = ("multisine", "paper")
LENGTH_S = 60
FEW = 1  # seeds that a test takes


def draw(seeds):
    """Every bench and seed: (plant, motion, rate, bits, seed)."""
    return list(itertools.product(PLANTS, MOTIONS, RATES, BITS, range(1, seeds + 1)))


def bench(plant, motion, rate, bits, seed, folder):
    """One bench's identifiable parameters: {name: (found, truth, sigma or None)}."""
    model = REPOSITORY / "models" / f"{plant}.yaml"
    ankle = ["--ankle-bits", bits] if plant == "leg" else []
    run("talus-sim", "--model", model, "--out", folder / "r.csv", "--truth", folder / "t.json", "--excitation", motion, "--fit",
        "--rate", rate, "--duration", LENGTH_S, "--seed", seed, "--encoder-bits", bits, *ankle)  # fmt: skip
    run("talus-identify", "--quiet", "--model", model, "--out", folder / "f.yaml", "--report", folder / "r.json", folder / "r.csv")
    report, truth = (json.loads((folder / name).read_text()) for name in ("r.json", "t.json"))
    return {name: (p["value"], truth["parameters"][name], p["sigma"]) for name, p in report["parameters"].items() if p["identifiable"]}


def measured(cases):
    """(case, its parameters), one after the other."""
    with tempfile.TemporaryDirectory(prefix="sigma-") as folder:
        for case in cases:
            yield case, bench(*case, Path(folder))


def deviations(parameters):
    """(found - truth) / sigma of those that have one."""
    return [(value - true) / sigma for value, true, sigma in parameters.values() if sigma is not None]


def inside(every):
    """(share within three standard deviations, how many there were)."""
    z = np.concatenate([deviations(parameters) for _, parameters in every])
    return np.mean(np.abs(z) <= 3), len(z)


def line(bench_name, cases):
    """One bench's row of the table."""
    z = np.concatenate([deviations(parameters) for _, parameters in cases])
    hidden = sum(sigma is None for _, parameters in cases for _, _, sigma in parameters.values())
    off = {name: np.mean([p[name][0] / p[name][1] - 1 for _, p in cases]) for name in cases[0][1] if "inertia" in name or name == "mass_kg"}
    biases = ", ".join(f"{name} {100 * value:+.2f} %" for name, value in off.items())
    share = f"{100 * np.mean(np.abs(z) <= 3):5.1f} %" if len(z) else "    -"
    return f"{bench_name:30} {share} of {len(z):4}, {hidden:3} hidden; {biases}"


def main(seeds):
    every = []
    for name, cases in itertools.groupby(measured(draw(seeds)), lambda one: one[0][:4]):
        every.append((name, list(cases)))
        print(line(" ".join(map(str, name)), every[-1][1]), flush=True)
    for plant in PLANTS:
        share, count = inside([one for name, cases in every if name[0] == plant for one in cases])
        print(f"{plant}: {100 * share:.1f} % of {count}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 30)
