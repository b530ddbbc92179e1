"""Reading a recording: the programs' reader against pandas.read_csv on the same file."""

import json
import subprocess
import time

import numpy
from measure import Comparison, Outcome

ROWS = 1_000_000
COLUMNS = {
    "time_s": "%.6f", "knee_motor_rad": "%.6f", "ankle_motor_rad": "%.6f", "ankle_joint_rad": "%.7f",
    "knee_current_A": "%.4f", "ankle_current_A": "%.5f", "bus_V": "%.2f",
}  # fmt: skip
BLOCK = 50_000


def write(path, rows):
    """A leg's recording at 1 kHz with seven columns, written as talus-sim writes numbers."""
    random, line = numpy.random.default_rng(1), ",".join(COLUMNS.values()) + "\n"
    with open(path, "w", encoding="ascii") as file:
        file.write(",".join(COLUMNS) + "\n")
        for first in range(0, rows, BLOCK):
            t = 1e-3 * numpy.arange(first, min(first + BLOCK, rows))
            knee, ankle = 0.5 * numpy.sin(3.1 * t), 0.3 * numpy.sin(4.7 * t + 1.0)
            current = random.normal(size=(2, len(t)))
            table = [t, 51.0 * knee, 65.0 * ankle, ankle, current[0], 0.1 * current[1], 24.0 + 0.1 * current[0]]
            file.write("".join([line % row for row in zip(*table, strict=True)]))


def ours(size, path):
    """What the reader says: rows, wall_s, cpu_s, sum of each column."""
    command = [str(size.folder / "read_recording"), "leg", str(path)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def peer(path):
    """The same of pandas."""
    import pandas

    wall, cpu = time.perf_counter(), time.process_time()
    table = pandas.read_csv(path)
    sums = {name: float(table[name].sum()) for name in table.columns}
    return {"rows": len(table), "wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu, "sum": sums}


def difference(one, other):
    """Largest difference of a column's mean."""
    assert one["rows"] == other["rows"] and one["sum"].keys() == other["sum"].keys()
    return max(abs(one["sum"][name] - other["sum"][name]) for name in one["sum"]) / one["rows"]


def bench(size):
    """Wall time, because the reader uses the processors that there are; processor time beside it."""
    path = size.folder / "reading.csv"
    try:
        write(path, size.scaled(ROWS, 1_000))
        pairs = [(ours(size, path), peer(path)) for _ in range(size.scaled(7, 1) + 1)][1:]
        megabytes = path.stat().st_size / 1e6
    finally:
        path.unlink(missing_ok=True)
    gap = max(difference(o, p) for o, p in pairs)
    seconds = {key: ([o[key] for o, _ in pairs], [p[key] for _, p in pairs]) for key in ("wall_s", "cpu_s")}
    file = f"{pairs[0][0]['rows']:,} rows, {len(COLUMNS)} columns, {megabytes:.3g} MB"
    reads = f"every row parsed, checked, spooled and read back: {file}"
    return Outcome(
        [
            Comparison("reading a recording", reads + ", time on the wall", "pandas.read_csv", *seconds["wall_s"], 1.0),
            Comparison("reading a recording, processor time", reads + ", all threads together", "pandas.read_csv",
                       *seconds["cpu_s"]),
        ],
        [f"same means of all columns to {gap:.1e}"],
        {"mean_difference": gap},
    )  # fmt: skip
