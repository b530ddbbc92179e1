"""The twin: a random plant, its excitation, and one run of the C program for a recording."""

import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
SOURCES = ("bench_twin.c", "twin_read.c", "twin_laws.c", "twin_plant.c", "twin_step.c")
COLUMNS = ("t", "knee_motor", "ankle_motor", "ankle_joint", "shank", "foot", "knee_A", "ankle_A", "knee_motor_v",
           "knee_motor_a", "ankle_motor_v", "ankle_motor_a", "knee_motor_true", "ankle_motor_true", "knee_load",
           "ankle_load", "energy", "work")  # fmt: skip
RATE_HZ, JITTER_S, PERIOD_S, PERIODS = 250.0, 3e-4, 4.0, 6
SETTLE_S = 6.0
LINKAGE = {"lead_m": 0.002, "AB_m": 0.090, "BO_m": 0.040, "AC_m": 0.035, "BOF_deg": 84.75}
FIXED = {"gravity": 9.81, "ms": 1.624, "mf": 0.442, "mm": 0.4112, "ls": 0.3615, "ratio": 51.0, "K": 0.1031}
RECORDINGS = ("train1", "train2", "train3", "test")
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


@dataclass
class Plant:
    """A leg as it really is."""

    shank_com_m: float
    shank_inertia_kg_m2: float
    foot_com_m: float
    foot_inertia_kg_m2: float
    ankle_motor_com_m: float
    ankle_rotor_inertia_kg_m2: float
    knee_coulomb_Nm: float
    knee_viscous_Nms_rad: float
    ankle_coulomb_Nm: float
    ankle_viscous_Nms_rad: float

    @staticmethod
    def draw(rng):
        near = lambda x, part: x * rng.uniform(1 - part, 1 + part)  # noqa: E731
        return Plant(near(0.160, 0.13), near(0.042, 0.25), near(0.055, 0.13), near(0.0021, 0.25), near(0.118, 0.13),
                     near(2.4e-6, 0.2), rng.uniform(0.8, 2.5), rng.uniform(0.2, 0.8), rng.uniform(0.4, 1.2),
                     rng.uniform(0.1, 0.5))  # fmt: skip

    def base(self):
        """What can be identified of the inertial parameters."""
        shank = self.shank_inertia_kg_m2 + FIXED["ms"] * self.shank_com_m**2 + FIXED["mm"] * self.ankle_motor_com_m**2
        return {
            "shank_inertia": shank,
            "shank_moment": FIXED["ms"] * self.shank_com_m + FIXED["mm"] * self.ankle_motor_com_m,
            "foot_moment": FIXED["mf"] * self.foot_com_m,
            "foot_inertia": self.foot_inertia_kg_m2 + FIXED["mf"] * self.foot_com_m**2,
            "ankle_rotor_inertia": self.ankle_rotor_inertia_kg_m2,
        }

    def job(self):
        """The plant as the twin's names."""
        job = {"gravity": 9.81, "ms": FIXED["ms"], "ds": self.shank_com_m, "i1": self.shank_inertia_kg_m2,
               "mf": FIXED["mf"], "df": self.foot_com_m, "i_f": self.foot_inertia_kg_m2, "mm": FIXED["mm"],
               "dma": self.ankle_motor_com_m, "ls": FIXED["ls"], "ima": self.ankle_rotor_inertia_kg_m2,
               "ratio": FIXED["ratio"], "lead": LINKAGE["lead_m"], "bof": np.radians(LINKAGE["BOF_deg"])}  # fmt: skip
        for name in ("ab", "bo", "ac"):
            job[name] = job[f"n_{name}"] = LINKAGE[f"{name.upper()}_m"]
        for joint in ("knee", "ankle"):
            job[f"{joint}.coulomb"] = getattr(self, f"{joint}_coulomb_Nm")
            job[f"{joint}.viscous"] = getattr(self, f"{joint}_viscous_Nms_rad")
            job[f"{joint}.torque_constant"] = FIXED["K"]
        return job


CURRENT_LIMIT_A = {"knee": 8.0, "ankle": 1.5}


def draw_control(rng):
    return {
        "knee.bandwidth": rng.uniform(7, 11),
        "ankle.bandwidth": rng.uniform(8, 13),
        "knee.zeta": rng.uniform(0.7, 1.0),
        "ankle.zeta": rng.uniform(0.7, 1.0),
        **{f"{joint}.current_limit": limit for joint, limit in CURRENT_LIMIT_A.items()},
    }


def draw_multisine(rng, style, speed, periodic):
    """A realisation of the multisine: random phases, amplitudes scaled to the joints' ranges."""
    base = speed / PERIOD_S
    job = {"base_hz": base, "harmonics": style["harmonics"], "settle_s": SETTLE_S / speed if periodic else SETTLE_S}
    t = np.linspace(0, 1 / base, 512, endpoint=False)
    k = np.arange(1, style["harmonics"] + 1)
    for joint, reach in (("knee", style["knee_rad"]), ("ankle", style["ankle_rad"])):
        best = None
        for _ in range(3):  # of three draws the one with the flattest peak
            phase = rng.uniform(0, 2 * np.pi, len(k))
            shape = np.sin(2 * np.pi * base * np.outer(t, k) + phase) @ k ** -style["fall"]
            if best is None or np.abs(shape).max() < best[0]:
                best = np.abs(shape).max(), phase
        size = reach * rng.uniform(0.9, 1.1) / best[0] * k ** -style["fall"]
        job.update(
            {f"{joint}_a[{i}]": a for i, a in enumerate(size)} | {f"{joint}_p[{i}]": p for i, p in enumerate(best[1])}
        )
    return job, base


def draw_style(rng):
    return {"harmonics": 8, "fall": rng.uniform(0.4, 0.7), "knee_rad": rng.uniform(0.55, 0.68),
            "ankle_rad": rng.uniform(0.31, 0.36)}  # fmt: skip


def draw_ramps(rng):
    """Slow ramps with holds at three speeds: knee alone, ankle alone, both."""
    knee, ankle, begin = rng.uniform(0.37, 0.43), rng.uniform(0.29, 0.34), 1.0
    speeds = np.array([0.1, 0.19, 0.3]) * rng.uniform(0.9, 1.1)
    where, points = np.zeros(2), [(0.0, 0.0, 0.0), (begin, 0.0, 0.0)]
    for which in ((1, 0), (0, 1), (1, 1)):
        for speed in speeds[1:] if which != (1, 1) else speeds[[0, 2]]:
            for side in rng.permutation([1, -1]):
                aim = np.where(which, np.array([knee, ankle]) * side, where)
                begin += np.max(np.abs(aim - where) / speed / (1.0, 0.9)) + 1e-3
                points.append((begin, *aim))
                begin += rng.uniform(0.25, 0.6)
                points.append((begin, *aim))
                where = aim
        if which != (1, 1):
            begin += np.max(np.abs(where) / speeds[2])
            where = np.zeros(2)
            points.append((begin, 0.0, 0.0))
            begin += 0.3
            points.append((begin, 0.0, 0.0))
    job = {"points": len(points), "settle_s": 1.0, "ref_filter": 40.0}
    for i, (t, k, a) in enumerate(points):
        job.update({f"point_s[{i}]": t, f"point_knee[{i}]": k, f"point_ankle[{i}]": a})
    return job, begin


def draw_runs(rng):
    """Each recording's job, its length and when in the session it begins."""
    style, runs, session = draw_style(rng), {}, 0.0
    faster = rng.uniform(1.25, 1.36)
    unseen = rng.choice([rng.uniform(0.75, 0.85), rng.uniform(1.1, 1.18)])
    for name in RECORDINGS:
        if name == "train3":
            job, length = draw_ramps(rng)
        else:
            speed = {"train1": 1.0, "train2": faster, "test": unseen}[name]
            job, base = draw_multisine(rng, style, speed, True)
            length = 20.0 if name == "test" else PERIODS / base
        n = int(length * RATE_HZ)
        times = 0.002 + np.arange(n) / RATE_HZ + rng.uniform(-JITTER_S, JITTER_S, n)
        session += job["settle_s"]
        runs[name] = {
            "job": {**job, "session_s": session, "seed": int(rng.integers(1, 2**31))},
            "times": np.round(times, 6),
        }
        session += length + rng.uniform(3, 12)
    return runs


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
