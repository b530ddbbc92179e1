"""The diagnosis: every candidate on held-out blocks from products made once, against least squares anew for each
candidate and fold; and how a whole talus-gap grows with the recording, from ten seconds to an hour."""

import os
import random
from pathlib import Path

import numpy
import talus
import yaml
from talus.diagnosis.dataset import Dataset
from talus.diagnosis.search import Search
from talus.diagnosis.processed_recording import ProcessedRecording
from growth import repeat, run, simulate
from measure import Comparison, Outcome, alternate

RATE_HZ, PERIOD_S, CASE_S = 250, 8, 112  # of the twin's multisine; as long as a bench case
GROWN = (("leg", 250, (24, 112, 600, 3600), {}),
         ("pendulum", 1000, (60, 600, 3600), {"cpu_s": 40.0, "peak_kB": 200_000}))  # fmt: skip
CASE = "case_019"
LABELLED_BARS, QUICK_BARS = {"cpu_s": 16.0, "wall_s": 9.0, "peak_kB": 150_000}, {"wall_s": 2.5}
TRIED = 12  # candidates that the peer fits; its time is scaled to all
EQUAL = 1e-5  # columns are kept in single precision


def search_of(path, model):
    """All candidates' rows and products on one recording."""
    tree = yaml.safe_load(model.read_text(encoding="utf-8"))
    given = talus.Model.from_tree(tree)
    dataset = Dataset(given, [ProcessedRecording(given, talus.Recording.read(path))], tree)
    return Search(dataset, list(given.base.values()))


def rows_of(gram, candidate):
    """The weighted rows of a fit with a candidate: [(columns, reading)] fold by fold."""
    own = gram.gathered(candidate.columns)
    folds = []
    for f in range(gram.folds):
        parts = [(plain[:-1, layout.slices[f]], rows[:, layout.slices[f]], plain[-1, layout.slices[f]])
                 for layout, plain, rows in zip(gram.layouts, gram.plain, own, strict=True)]  # fmt: skip
        columns = numpy.hstack([numpy.vstack([plain[gram.base], rows]) for plain, rows, _ in parts]).T
        folds.append((columns, numpy.concatenate([reading for *_, reading in parts])))
    return folds


def least_squares(gram, candidate):
    """Chi-square on held-out folds the direct way: numpy.linalg.lstsq for each."""
    folds, (known, reading) = rows_of(gram, candidate), gram.prior_rows()
    prior = numpy.vstack([known[gram.base], numpy.zeros((len(candidate.columns), known.shape[1]))]).T
    total = 0.0
    for f, (columns, held) in enumerate(folds):
        others = [fold for k, fold in enumerate(folds) if k != f]
        matrix = numpy.vstack([prior, *(x for x, _ in others)])
        unit = numpy.sqrt((matrix**2).sum(0))
        found = numpy.linalg.lstsq(matrix / unit, numpy.concatenate([reading, *(y for _, y in others)]), rcond=None)[0]
        total += float(((held - columns @ (found / unit)) ** 2).sum())
    return total


def scan(size, recording, model):
    """All candidates by talus, some by the peer, and how far the two agree."""
    search = search_of(recording, model)
    candidates = search.gram.candidates
    some = random.Random(1).sample(candidates, size.scaled(TRIED, 3))
    mine = dict(zip(candidates, (chi2 for chi2, *_ in search.gram.scan([], candidates)), strict=True))
    off = max(abs(mine[c] - least_squares(search.gram, c)) / mine[c] for c in some)
    seconds = alternate(size.scaled(5, 2), talus=lambda: search.gram.scan([], candidates),
                        numpy=lambda: [least_squares(search.gram, c) for c in some])  # fmt: skip
    scaled = [s * len(candidates) / len(some) for s in seconds["numpy"]]
    return Comparison(f"{len(candidates)} candidates on held-out blocks", "products made once, small systems",
                      f"numpy.linalg.lstsq for each candidate and fold ({len(some)} of them, scaled)",
                      seconds["talus"], scaled, note=f"the same chi-square to {off:.0e}"), off  # fmt: skip


def diagnosed(size, name, model, recordings, rows, bars, quick=False):
    """Time and memory of a whole run; `bars` are the most that it may take, by figure."""
    used = run(size, "talus-gap", ["--quiet", *(["--quick"] if quick else []), "--model", model, "--report", size.folder / "growth-gap.json",
                                   *recordings])  # fmt: skip
    for path in size.folder.glob("growth-gap.*json"):
        path.unlink()
    (size.folder / "growth-gap.next.csv").unlink(missing_ok=True)
    return {"recording": name, "rows": rows, "bars": bars, **{figure: used[figure] for figure in ("cpu_s", "wall_s", "peak_kB")}}


def grown(size):
    """Rows of the table for recordings of a leg and of one joint, ever longer; each simulated as a whole, for rows that stand in a
    file twice are no recording."""
    rows = []
    for model, rate, lengths_s, bars in GROWN[:size.scaled(len(GROWN), 1)]:
        for length_s in lengths_s[:size.scaled(len(lengths_s), 1)]:
            path = size.folder / "growth-long.csv"
            try:
                simulate(size, path, length_s, rate, model)
                last = length_s == lengths_s[-1]
                rows.append(diagnosed(size, f"{model}, {length_s} s at {rate} Hz", size.repository / "models" / f"{model}.yaml", [path],
                                      length_s * rate, bars if last else {}))  # fmt: skip
            finally:
                path.unlink(missing_ok=True)
    return rows


def labelled(size):
    """Rows of the labelled case, with replicates and without; none where the data are not there."""
    data = Path(os.environ.get("TALUS_DATA") or size.repository.parent / "shared" / "data") / "leg_cases" / CASE
    recordings = sorted(data.glob("train*.csv.gz"))
    if not size.scaled(len(recordings), 0):
        return []
    rows = sum(len(talus.Recording.read(path).t) for path in recordings)
    return [diagnosed(size, f"labelled leg case{words}", data / "model.yaml", recordings, rows, bars, quick)
            for words, bars, quick in (("", LABELLED_BARS, False), (", --quick", QUICK_BARS, True))]  # fmt: skip


def table_lines(rows):
    """The table."""
    yield f"{'recording':<28}{'rows':>11}{'processor':>12}{'wall':>10}{'peak memory':>14}"
    for r in rows:
        yield f"{r['recording']:<28}{r['rows']:>11,}{r['cpu_s']:>10.2f} s{r['wall_s']:>8.2f} s{r['peak_kB'] / 1000:>11.0f} MB"


def over(rows):
    """What takes more than its bar."""
    return [f"{figure} of {r['recording']}" for r in rows for figure, most in r["bars"].items() if r[figure] > most]


def bench(size):
    """The comparison and the table."""
    model, first, case = size.repository / "models" / "leg.yaml", size.folder / "gap-first.csv", size.folder / "gap-case.csv"
    try:
        simulate(size, first, PERIOD_S, RATE_HZ)
        repeat(first, case, size.scaled(CASE_S, 3 * PERIOD_S) // PERIOD_S, PERIOD_S)
        comparison, off = scan(size, case, model)
    finally:
        first.unlink(missing_ok=True)
        case.unlink(missing_ok=True)
    rows = [*labelled(size), *grown(size)]
    missed = ([] if off < EQUAL else ["the same chi-square"]) + over(rows)
    return Outcome([comparison], ["talus-gap as a whole", *table_lines(rows)], {"diagnosis": rows}, missed)
