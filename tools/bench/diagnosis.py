"""The diagnosis: every candidate on held-out blocks from products made once, against least squares anew for each
candidate and fold; and how a whole talus-gap grows with the recording, from ten seconds to an hour."""

import random

import numpy
import talus
import yaml
from talus.diagnosis.dataset import Dataset
from talus.diagnosis.search import Search
from talus.diagnosis.processed_recording import ProcessedRecording
from growth import repeat, run, simulate
from measure import Comparison, Outcome, alternate, duration

RATE_HZ, PERIOD_S, CASE_S = 250, 8, 112  # of the twin's multisine; as long as a bench case
LENGTHS_S = (8, 112, 600, 3600)
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


def grown(size, first, model):
    """Time and memory of whole runs: [{seconds, rows, cpu_s, peak_kB}]."""
    rows, recording = [], size.folder / "growth-gap.csv"
    for length_s in size.scaled(LENGTHS_S, (8, 16)):
        repeat(first, recording, length_s // PERIOD_S, PERIOD_S)
        used = run(size, "talus-gap", ["--quiet", "--model", model, "--report", size.folder / "growth-gap.json", recording])
        rows.append({"seconds": length_s, "rows": length_s * RATE_HZ, "cpu_s": used["cpu_s"], "peak_kB": used["peak_kB"]})
    for path in size.folder.glob("growth-gap*"):
        path.unlink()
    return rows


def table_lines(rows):
    """The table, and what a further row costs."""
    yield f"{'recording':>12}{'rows':>11}{'processor':>12}{'peak memory':>14}{'a further row':>16}"
    for before, r in zip([None, *rows], rows, strict=False):
        each = duration((r["cpu_s"] - before["cpu_s"]) / (r["rows"] - before["rows"])) if before else ""
        yield f"{r['seconds']:>10} s{r['rows']:>11,}{r['cpu_s']:>10.2f} s{r['peak_kB'] / 1000:>11.0f} MB{each:>16}"


def bench(size):
    """The comparison and the table."""
    model, first, case = size.repository / "models" / "leg.yaml", size.folder / "gap-first.csv", size.folder / "gap-case.csv"
    try:
        simulate(size, first, PERIOD_S, RATE_HZ)
        repeat(first, case, size.scaled(CASE_S, 3 * PERIOD_S) // PERIOD_S, PERIOD_S)
        comparison, off = scan(size, case, model)
        rows = grown(size, first, model)
    finally:
        first.unlink(missing_ok=True)
        case.unlink(missing_ok=True)
    missed = [] if off < EQUAL else ["the same chi-square"]
    return Outcome([comparison], ["talus-gap as a whole", *table_lines(rows)], {"diagnosis": rows}, missed)
