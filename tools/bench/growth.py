"""How identification and prediction grow: a minute, ten minutes and an hour at 1 kHz, of a leg and of one joint. Peak
memory must not grow with the recording, time must grow in step with it."""

import json
import statistics
import subprocess

from measure import Outcome, duration

MINUTES = (1, 10, 60)
MODELS = ("leg", "pendulum")
MEMORY_SHARE, MEMORY_KB = 1.10, 16_000
GROWTH = 1.25  # of a further row's time beyond ten minutes against that before
HOUR_S = {"talus-identify, pendulum": 6.0}  # of processor; on the wall less, where the cores are free
PERIOD_S = 60  # a whole number of the multisine's periods: minutes follow each other without a jump


def minute_of(size, model):
    """The minute that a model's longer recordings are made of."""
    return size.folder / f"growth-minute-{model}.csv"


def simulate(size, path, seconds, rate, model="leg"):
    """The minute that the others are made of."""
    subprocess.run(
        [str(size.build / "bin" / "talus-sim"), "--model", str(size.repository / "models" / f"{model}.yaml"),
         "--out", str(path), "--rate", str(rate), "--duration", str(seconds)],
        check=True, capture_output=True,
    )  # fmt: skip


def repeat(minute, path, times, period_s):
    """The minute `times` times, one after the other."""
    header, *lines = minute.read_text(encoding="ascii").splitlines(keepends=True)
    rows = [(float(time), rest) for time, _, rest in (line.partition(",") for line in lines)]
    with open(path, "w", encoding="ascii") as file:
        file.write(header)
        for k in range(times):
            file.write("".join([f"{time + k * period_s:.6f},{rest}" for time, rest in rows]))


def commands(size, model, recording):
    """What is measured: {program: arguments}."""
    file, folder = str(size.repository / "models" / f"{model}.yaml"), size.folder
    return {
        "talus-identify": ["--model", file, "--out", folder / "growth.yaml", "--report", folder / "growth.json",
                           recording],
        "talus-predict": ["--model", file, "--out", folder / "growth-out.csv", recording],
    }  # fmt: skip


def run(size, program, arguments):
    """Seconds and peak memory of one run."""
    command = [size.folder / "peak", size.build / "bin" / program, *arguments]
    done = subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True)
    used = json.loads(done.stdout.splitlines()[-1])
    if used["status"] != 0:
        raise RuntimeError(f"{program}: status {used['status']}\n{done.stderr}")
    return used


def rows_of(size, model, minutes, repetitions, period_s, rate):
    """One length: a row for each program, the least wall_s (others use the machine, too), median cpu_s, largest peak_kB."""
    recording = size.folder / "growth.csv"
    try:
        repeat(minute_of(size, model), recording, minutes, period_s)
        runs = {name: [] for name in commands(size, model, recording)}
        for _ in range(repetitions):
            for name, arguments in commands(size, model, recording).items():
                runs[name].append(run(size, name, arguments))
    finally:
        for path in size.folder.glob("growth*"):
            if not path.name.startswith("growth-minute"):
                path.unlink()
    return [
        {
            "program": f"{name}, {model}", "minutes": minutes, "rows": minutes * period_s * rate,
            "wall_s": min(u["wall_s"] for u in used),
            "cpu_s": statistics.median(u["cpu_s"] for u in used),
            "peak_kB": max(u["peak_kB"] for u in used),
        }
        for name, used in runs.items()
    ]  # fmt: skip


def met(good):
    """In words."""
    return "met" if good else "MISSED"


def verdicts(table):
    """Words on one program's rows, each with the name of the bar where it was missed."""
    first, middle, last = table
    name, growth = first["program"], last["peak_kB"] / first["peak_kB"]
    small = growth <= MEMORY_SHARE and last["peak_kB"] < MEMORY_KB
    yield (
        f"{name}: memory {growth:.2f} of the minute's (bar {MEMORY_SHARE}, below {MEMORY_KB / 1000:g} MB: {met(small)})"
    ), (None if small else f"memory of {name}")
    early = (middle["cpu_s"] - first["cpu_s"]) / (middle["rows"] - first["rows"])
    late = (last["cpu_s"] - middle["cpu_s"]) / (last["rows"] - middle["rows"])
    linear = late <= GROWTH * early
    yield (
        f"{name}: a further row costs {duration(early)} of processor up to ten minutes and {duration(late)} beyond "
        f"(bar {GROWTH} times: {met(linear)})"
    ), (None if linear else f"linear time of {name}")
    if name in HOUR_S:
        fast = last["cpu_s"] <= HOUR_S[name]
        yield (
            f"{name}: the longest recording takes {last['cpu_s']:.2f} s of processor, {last['wall_s']:.2f} s on the wall "
            f"(bar {HOUR_S[name]:g} s of processor: {met(fast)})"
        ), (None if fast else f"time of {name}")


def table_lines(rows):
    """The table."""
    yield f"{'program':<26}{'minutes':>8}{'rows':>11}{'peak memory':>14}{'processor':>12}{'wall':>10}{'a row':>10}"
    for r in rows:
        each = duration(r["cpu_s"] / r["rows"])
        yield (
            f"{r['program']:<26}{r['minutes']:>8}{r['rows']:>11,}{r['peak_kB'] / 1000:>11.2f} MB"
            f"{r['cpu_s']:>10.2f} s{r['wall_s']:>8.2f} s{each:>10}"
        )


def measure(size, model):
    """One model's table: a list of rows, lengths in order, for each program."""
    period_s, rate = size.scaled(PERIOD_S, 8), size.scaled(1000, 250)
    try:
        simulate(size, minute_of(size, model), period_s, rate, model)
        lengths = size.scaled(MINUTES, (1, 2, 3))
        found = [rows_of(size, model, m, 3 if m < 60 else 2, period_s, rate) for m in lengths]
    finally:
        minute_of(size, model).unlink(missing_ok=True)
    return [list(table) for table in zip(*found, strict=True)]


def bench(size):
    """The table and the verdicts."""
    tables = [table for model in MODELS for table in measure(size, model)]
    rows = [row for table in tables for row in table]
    said = [verdict for table in tables for verdict in verdicts(table)]
    missed = [name for _, name in said if name]
    return Outcome([], [*table_lines(rows), *(words for words, _ in said)], {"growth": rows}, missed)
