"""The twin: one run of the C program for a recording."""

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
SOURCES = ("bench_twin.c", "twin_read.c", "twin_laws.c", "twin_plant.c", "twin_step.c")
COLUMNS = ("t", "knee_motor", "ankle_motor", "ankle_joint", "shank", "foot", "knee_A", "ankle_A", "knee_motor_v",
           "knee_motor_a", "ankle_motor_v", "ankle_motor_a", "knee_motor_true", "ankle_motor_true", "knee_load",
           "ankle_load", "energy", "work", "shank_v", "shank_a")  # fmt: skip
STEP_S, FLEXIBLE_STEP_S = 1e-4, 5e-5


def program():
    """The compiled twin; compiled when a source is newer."""
    build = Path(os.environ.get("TALUS_BUILD") or HERE.parents[2] / "build") / "blind"
    target = build / "bench_twin"
    sources = [HERE / name for name in SOURCES]
    newest = max(path.stat().st_mtime for path in [*sources, HERE / "twin.h"])
    if not target.exists() or target.stat().st_mtime < newest:
        build.mkdir(parents=True, exist_ok=True)
        fresh = build / f"bench_twin.{os.getpid()}"
        subprocess.run([os.environ.get("CC") or "cc", "-std=c99", "-O3", "-ffp-contract=off", "-o", fresh, *sources,
                        "-lm"], check=True)  # fmt: skip
        fresh.rename(target)
    return target


def simulate(job, times):
    """Columns of one recording, without noise, by name. None where the leg leaves its range."""
    with tempfile.TemporaryDirectory(prefix="blind-") as folder:
        paths = [Path(folder) / name for name in ("job", "times", "rows")]
        flexible = any(job.get(f"{joint}.elastic_form") for joint in ("knee", "ankle"))
        step = {"step_s": FLEXIBLE_STEP_S if flexible else STEP_S}
        paths[0].write_text("".join(f"{name} {float(value)!r}\n" for name, value in {**step, **job}.items()))
        paths[1].write_bytes(np.ascontiguousarray(times, float).tobytes())
        done = subprocess.run([program(), *paths], check=False, capture_output=True, text=True)
        if done.returncode == 1:
            return None
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
        rows = np.frombuffer(paths[2].read_bytes()).reshape(-1, len(COLUMNS))
    return dict(zip(COLUMNS, rows.T.copy(), strict=True))
