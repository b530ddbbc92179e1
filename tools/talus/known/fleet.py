"""A fleet of simulated arms of which it is known which robots have an effect and whose friction drifts, through talus-fleet: on local
processes of which two are killed, and one by one; and whether both give the same files."""

import csv
import json
import os
import shutil
import signal
import subprocess
import threading
import time
from dataclasses import dataclass
from datetime import date, timedelta
from pathlib import Path

import numpy as np
import yaml

from ..blind.running import BUILD, ROOT
from ..blind.scores import Bar
from ..progress import Progress

LENGTH_S, BITS = 12, 18
BEGIN, WEEK = date(2026, 1, 5), timedelta(days=7)
EFFECT = {"effect": "nonlinear_viscous", "joint": "joint", "parameters": {"size_Nm": 0.1, "exponent": 2}}
WORN = 0.3  # the drifting robot's Coulomb friction grows by so much of itself
VISCOUS_PER_K = -0.01  # of every robot's oil, from REFERENCE_C
REFERENCE_C = 22.0
KILLS = 2
GROWN_MB = 20.0  # of a scheduler that keeps nothing of what is done: two diagnoses' reports


@dataclass
class Planted:
    """What there is to find."""

    robots: list
    with_effect: list
    drifting: str
    sessions: int


def draw(folder, count, seed):
    """Recordings, their table FLEET.csv, and what was planted: a tenth of the robots has EFFECT, another robot's friction drifts."""
    robots = [f"arm-{k:02d}" for k in range(1, max(10, round(np.sqrt(2 * count) / 10) * 10) + 1)]
    sessions = max(1, count // len(robots))
    rng = np.random.default_rng(seed)
    picked = rng.permutation(len(robots))
    planted = Planted(robots, sorted(robots[k] for k in picked[: len(robots) // 10]), robots[picked[-1]], sessions)
    folder.mkdir(parents=True, exist_ok=True)
    plain = (ROOT / "models" / "pendulum.yaml").read_text()
    (folder / "pendulum.yaml").write_text(plain)
    step, rows = Progress("fleet: drawing", len(robots) * sessions), []
    for robot in robots:
        own = yaml.safe_load(plain)
        own["inertia_kg_m2"] *= rng.uniform(0.98, 1.02)
        own["joint"]["friction"] = {key: value * rng.uniform(0.95, 1.05) for key, value in own["joint"]["friction"].items()}
        if robot in planted.with_effect:
            own["effects"] = [EFFECT]
        for k in range(sessions):
            rows.append(_session(folder, robot, own, k, k / max(sessions - 1, 1) * (robot == planted.drifting), rng))
            step(rows[-1]["recording"])
    with open(folder / "fleet.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)
    return planted


def _session(folder, robot, own, k, worn, rng):
    """Draws a robot's k-th session; the row of the table."""
    temperature = round(float(rng.uniform(15, 30)), 1)
    friction = own["joint"]["friction"]
    now = {"coulomb_Nm": friction["coulomb_Nm"] * (1 + WORN * worn),
           "viscous_Nms_rad": friction["viscous_Nms_rad"] * (1 + VISCOUS_PER_K * (temperature - REFERENCE_C))}  # fmt: skip
    name, seed = f"{robot}-{k:03d}.csv", int(rng.integers(1, 2**31))
    if not (folder / name).exists():
        truth = folder / f"{robot}-{k:03d}.truth.yaml"
        truth.write_text(yaml.safe_dump({**own, "joint": {**own["joint"], "friction": now}}))
        subprocess.run([BUILD / "bin" / "talus-sim", "--model", truth, "--out", folder / name, "--duration", str(LENGTH_S), "--encoder-bits", str(BITS),
                        "--seed", str(seed)], check=True, capture_output=True)  # fmt: skip
    return {"recording": name, "model": "pendulum.yaml", "robot": robot, "session": str(BEGIN + k * WEEK), "temperature_C": temperature}


# ---- running ------------------------------------------------------------------------


def command(*words):
    return [str(BUILD / "bin" / "talus-fleet"), *map(str, words)]


class Watch(threading.Thread):
    """Beside a run: kills a worker at a third and at two thirds, and notes the scheduler's memory as items end."""

    def __init__(self, child, items, count):
        super().__init__(daemon=True)
        self.child, self.items, self.count, self.killed, self.memory = child, items, count, [], []

    def run(self):
        while self.child.poll() is None:
            done = sum(1 for _ in self.items.glob("*/item.json"))
            if done:
                self.memory.append((done, resident_MB(self.child.pid)))
            if len(self.killed) < KILLS and done > self.count * (len(self.killed) + 1) / (KILLS + 1):
                self.kill()
            time.sleep(max(0.1, self.count / 1000))

    def kill(self):
        """The eldest worker dies at once, with what it holds."""
        for pid in workers(self.child.pid):
            if pid not in self.killed:
                os.kill(pid, signal.SIGKILL)
                self.killed.append(pid)
                return


def workers(parent):
    """Processes that a run's nannies have started."""
    every = Path(f"/proc/{parent}/task").glob("*/children")
    children = sorted({int(pid) for path in every for pid in path.read_text().split()})
    return [pid for pid in children if b"spawn_main" in _words(pid)]


def _words(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def resident_MB(pid):
    """Memory that a process holds; 0 when it has ended."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def through(table, out, jobs, count, *options):
    """Runs talus-fleet, with deaths where it has workers: (wall seconds, Watch)."""
    begin = time.monotonic()
    with subprocess.Popen(command("run", table, "--out", out, "--jobs", jobs, "--quick", *options)) as child:
        watch = Watch(child, Path(out) / "items", count)
        if jobs > 1:
            watch.start()
        status = child.wait()
    if status:
        raise RuntimeError(f"talus-fleet ended with status {status}")
    if jobs > 1:
        watch.join()
    return time.monotonic() - begin, watch


def files(folder):
    """{name: bytes} of a run's results."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted((Path(folder) / "items").rglob("*")) if path.is_file()}


def growth_MB(memory, count):
    """What the scheduler's process holds more in the last quarter of a run than in the second."""
    early = [held for done, held in memory if count / 4 < done <= count / 2]
    late = [held for done, held in memory if done > 3 * count / 4 and held]
    return float(np.median(late) - np.median(early)) if early and late else float("nan")


def measure(out, count, seed, jobs):
    """Everything that is to be shown, as a mapping. What an earlier run has left is taken away: it would not be measured."""
    folder = Path(out) / f"seed{seed}-{count}"
    planted = draw(folder, count, seed)
    for name in ("many", "one"):
        shutil.rmtree(folder / name, ignore_errors=True)
    items = len(planted.robots) * planted.sessions
    many_s, watch = through(folder / "fleet.csv", folder / "many", jobs, items)
    one_s, _ = through(folder / "fleet.csv", folder / "one", 1, items)
    subprocess.run(command("report", folder / "many"), check=True)
    report = json.loads((folder / "many" / "report.json").read_text())
    return {"items": items, "jobs": jobs, "killed": len(watch.killed), "diagnosed": report["diagnosed"],
            "same_bytes": files(folder / "many") == files(folder / "one"), "wall_s": many_s, "one_by_one_s": one_s,
            "speed_up_per_process": one_s / many_s / jobs, "scheduler_growth_MB": growth_MB(watch.memory, items),
            "planted": vars(planted), "found": found(report)}  # fmt: skip


def found(report):
    """Whose effects and drifts the report says there are."""
    own = {f"{one['effect']} at the {one['joint']}": sorted(r["robot"] for r in one["robots"] if r["has"] and r["more_than_the_others"])
           for one in report["effects"]}  # fmt: skip
    drifts = [(one["robot"], one["quantity"], one["over"]) for one in report["drift"] if one["drifts"] and one["scope"] != "with the fleet"]
    return {"effects": own, "drifts": drifts, "sentence": report["sentence"]}


def speed(outcome):
    """How much of each process comes to good; other work on the machine shows in it."""
    return Bar("speed-up for each process", outcome["speed_up_per_process"], outcome["jobs"], least=0.85)


def bars(outcome):
    """What a run is held to. `outcome` is measure()'s."""
    items, planted, said = outcome["items"], outcome["planted"], outcome["found"]
    named = said["effects"].get(f"{EFFECT['effect']} at the {EFFECT['joint']}", [])
    drifting = {(robot, quantity) for robot, quantity, over in said["drifts"] if over == "date"}
    every = set(named) | set(planted["with_effect"])
    drift = (planted["drifting"], "coulomb_Nm")
    return [
        Bar("diagnosed, of all", outcome["diagnosed"] / items, items, least=1),
        Bar("same bytes as one by one", float(outcome["same_bytes"]), items, least=1),
        Bar("processes killed", outcome["killed"], items, least=KILLS if outcome["jobs"] > 1 else 0),
        Bar("scheduler's memory, last quarter less the second [MB]", outcome["scheduler_growth_MB"], items, most=GROWN_MB),
        Bar("robots with the planted effect, of those named", len(set(named) & set(planted["with_effect"])) / len(every), len(every), least=1),
        Bar("robots whose friction is said to drift, planted one apart", len(drifting - {drift}), len(planted["robots"]), most=0),
        Bar("the planted drift is said", float(drift in drifting), 1, least=1),
    ]
