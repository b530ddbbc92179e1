"""How identification and prediction grow: a minute, ten minutes and an hour at 1 kHz. Peak memory must not
grow with the recording, time must grow in step with it."""

import json
import statistics
import subprocess

from measure import Outcome, duration

MINUTES = (1, 10, 60)
MEMORY_SHARE, MEMORY_KB = 1.10, 64_000
PERIOD_S = 60  # a whole number of the multisine's periods: minutes follow each other without a jump


def simulate(size, path, seconds, rate):
    """The minute that the others are made of."""
    subprocess.run(
        [str(size.build / "bin" / "talus-sim"), "--model", str(size.repository / "models" / "leg.yaml"),
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


def commands(size, recording):
    """What is measured: {program: arguments}."""
    model, folder = str(size.repository / "models" / "leg.yaml"), size.folder
    return {
        "talus-identify": ["--model", model, "--out", folder / "growth.yaml", "--report", folder / "growth.json",
                           recording],
        "talus-predict": ["--model", model, "--out", folder / "growth-out.csv", recording],
    }  # fmt: skip


def run(size, program, arguments):
    """Seconds and peak memory of one run."""
    command = [size.folder / "peak", size.build / "bin" / program, *arguments]
    done = subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True)
    used = json.loads(done.stdout.splitlines()[-1])
    if used["status"] != 0:
        raise RuntimeError(f"{program}: status {used['status']}\n{done.stderr}")
    return used


def rows_of(size, minutes, repetitions, period_s, rate):
    """One length: {program: medians of wall_s, cpu_s; largest peak_kB}."""
    recording = size.folder / "growth.csv"
    try:
        repeat(size.folder / "growth-minute.csv", recording, minutes, period_s)
        runs = {name: [] for name in commands(size, recording)}
        for _ in range(repetitions):
            for name, arguments in commands(size, recording).items():
                runs[name].append(run(size, name, arguments))
    finally:
        for path in size.folder.glob("growth*"):
            if path.name != "growth-minute.csv":
                path.unlink()
    return {
        name: {
            "program": name, "minutes": minutes, "rows": minutes * period_s * rate,
            "wall_s": statistics.median(u["wall_s"] for u in used),
            "cpu_s": statistics.median(u["cpu_s"] for u in used),
            "peak_kB": max(u["peak_kB"] for u in used),
        }
        for name, used in runs.items()
    }  # fmt: skip


def verdicts(table):
    """Words on one program's rows, and the bars that it missed."""
    first, middle, last = table
    name, growth = first["program"], last["peak_kB"] / first["peak_kB"]
    early = (middle["cpu_s"] - first["cpu_s"]) / (middle["rows"] - first["rows"])
    late = (last["cpu_s"] - middle["cpu_s"]) / (last["rows"] - middle["rows"])
    good = growth <= MEMORY_SHARE and last["peak_kB"] < MEMORY_KB
    yield (
        f"{name}: memory {growth:.2f} of the minute's (bar {MEMORY_SHARE}, below {MEMORY_KB / 1000:g} MB: "
        f"{'met' if good else 'MISSED'}); a further row costs {duration(early)} up to ten minutes and "
        f"{duration(late)} beyond"
    ), ([] if good else [f"memory of {name}"])


def table_lines(rows):
    """The table."""
    yield f"{'program':<16}{'minutes':>8}{'rows':>11}{'peak memory':>14}{'processor':>12}{'wall':>10}{'a row':>10}"
    for r in rows:
        each = duration(r["cpu_s"] / r["rows"])
        yield (
            f"{r['program']:<16}{r['minutes']:>8}{r['rows']:>11,}{r['peak_kB'] / 1000:>11.2f} MB"
            f"{r['cpu_s']:>10.2f} s{r['wall_s']:>8.2f} s{each:>10}"
        )


def bench(size):
    """The table and the verdicts."""
    period_s, rate = size.scaled(PERIOD_S, 8), size.scaled(1000, 250)
    minute = size.folder / "growth-minute.csv"
    try:
        simulate(size, minute, period_s, rate)
        found = [rows_of(size, m, 3 if m < 60 else 2, period_s, rate) for m in size.scaled(MINUTES, (1, 2, 3))]
    finally:
        minute.unlink(missing_ok=True)
    rows = [length[name] for name in found[0] for length in found]
    words, missed = [], []
    for name in found[0]:
        for line, names in verdicts([length[name] for length in found]):
            words.append(line)
            missed += names
    return Outcome([], [*table_lines(rows), *words], {"growth": rows}, missed)
