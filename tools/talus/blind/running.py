"""Diagnoses every case with the command, one process each, as a user would; the labels stay sealed."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import talus

TIMEOUT_S = 600
ROOT = Path(__file__).resolve().parents[3]
BUILD = Path(os.environ.get("TALUS_BUILD") or ROOT / "build")


def fingerprint():
    """What the diagnosis is made of: a verdict of another version does not stay."""
    digest = hashlib.sha256()
    parts = [BUILD / "bin" / "talus-gap", BUILD / "bin" / "talus-identify", BUILD / "lib" / "libtalus.so"]
    for path in parts + sorted((ROOT / "tools" / "talus").rglob("*.py")):
        digest.update(path.read_bytes() if path.exists() else b"absent")
    return digest.hexdigest()[:16]


def measured(command):
    """Runs a command: status, what it said, wall and processor seconds, peak memory of it or any of its children."""
    begin = time.monotonic()
    with tempfile.TemporaryFile() as words:
        child = subprocess.Popen(
            [*map(str, command)], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=words
        )
        status, usage = _wait(child, begin)
        words.seek(0)
        said = words.read().decode(errors="replace")
    return {
        "status": status,
        "said": said,
        "wall_s": round(time.monotonic() - begin, 3),
        "processor_s": round(usage.ru_utime + usage.ru_stime, 3),
        "peak_MB": round(usage.ru_maxrss / 1024, 1),
    }


def _wait(child, begin):
    """Waits for the child itself, so that its resource usage comes with it; ends it when it takes too long."""
    while True:
        pid, status, usage = os.wait4(child.pid, os.WNOHANG)
        if pid:
            child.returncode = os.waitstatus_to_exitcode(status)
            return child.returncode, usage
        if time.monotonic() - begin > TIMEOUT_S:
            child.kill()
        time.sleep(0.02)


def quiet(*command):
    done = subprocess.run([*map(str, command)], check=False, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{Path(command[0]).name} ended with status {done.returncode}: {done.stderr.strip()}")


def predicted(model, recording, out):
    quiet(BUILD / "bin" / "talus-predict", "--model", model, "--out", out, recording)
    return np.ascontiguousarray(np.loadtxt(out, delimiter=",", skiprows=1)[:, 1:].T)


def training(case):
    """The recordings that the tool gets."""
    return sorted(case.glob("train*.csv.gz"))


def unseen(case, fitted, folder):
    """RMS of the error on the recording that was never given, for each joint: as given, identified, with effects; and
    what white noise of standard deviation 1 leaves after the same filter."""
    recording, identified = case / "test.csv.gz", folder / "identified.yaml"
    quiet(BUILD / "bin" / "talus-identify", "--quiet", "--model", case / "model.yaml", "--out", identified,
          *training(case))  # fmt: skip
    model, data = talus.Model.read(case / "model.yaml"), talus.Recording.read(recording)
    shown, out = talus.measured(model, data), {}
    for name, path in (("nominal", case / "model.yaml"), ("identified", identified), ("extended", fitted)):
        score = talus.score(model, data, predicted(path, recording, folder / "predicted.csv"))
        out[name] = {joint: values["rms"] for joint, values in score.items()}
    noise = np.random.default_rng(1).standard_normal((8, *shown.shape))
    powers = [[values["rms"] ** 2 for values in talus.score(model, data, shown - one).values()] for one in noise]
    out["unit_noise"] = dict(zip(model.joints, np.sqrt(np.mean(powers, axis=0)).tolist(), strict=True))
    return out


def reconstruction(true, recording):
    """RMS, for each joint, of what the true model leaves of a recording without effect, which no model can take away."""
    with tempfile.TemporaryDirectory(prefix="blind-") as folder:
        torque = predicted(true, recording, Path(folder) / "predicted.csv")
        score = talus.score(talus.Model.read(true), talus.Recording.read(recording), torque)
        return {joint: values["rms"] for joint, values in score.items()}


def keep_trajectory(report, near, target):
    """Keeps the file that a report proposes to follow, if it proposes one; where it is: as it says, or near it."""
    name = (report.get("next_experiment") or {}).get("trajectory")
    if not isinstance(name, str) or not name.endswith(".csv"):
        return
    for path in (Path(name), near / name, near / Path(name).name):
        if path.is_file():
            shutil.copyfile(path, target)
            return


def diagnose(case, results, version, gap):
    """One case: the verdict, what it cost, and the figures on the unseen recording."""
    with tempfile.TemporaryDirectory(prefix="blind-") as temporary:
        folder = Path(temporary)
        report, fitted = folder / "gap.json", folder / "fitted.yaml"
        out = {"case": case.name, "version": version}
        out |= measured([gap, "--quiet", "--model", case / "model.yaml", "--report", report, "--save-model", fitted,
                         *training(case)])  # fmt: skip
        out["report"] = json.loads(report.read_text()) if out["status"] == 0 else None
        if out["status"] == 0:
            try:
                out["unseen"] = unseen(case, fitted, folder)
            except (RuntimeError, talus.TalusError) as error:  # a motion may be too slow to be scored
                out["unseen"], out["failed"] = None, str(error)
            (results / f"{case.name}.yaml").write_text(fitted.read_text())
            keep_trajectory(out["report"], folder, results / f"{case.name}.trajectory.csv")
    target = results / f"{case.name}.json"
    fresh = target.with_suffix(".new")
    fresh.write_text(json.dumps(out, indent=1))
    fresh.rename(target)
    return out


def waiting(folder, version, keep):
    """Cases that have no verdict yet, or one of another version."""
    for case in sorted(folder.glob("case_*")):
        done = folder / "results" / f"{case.name}.json"
        if not done.exists() or (not keep and json.loads(done.read_text())["version"] != version):
            yield case


def run(folder, jobs=1, keep=False, gap=None):
    """All cases of a folder; returns how many were diagnosed."""
    results, version = folder / "results", fingerprint()
    results.mkdir(exist_ok=True)
    cases, begin, done = list(waiting(folder, version, keep)), time.monotonic(), 0
    with ThreadPoolExecutor(jobs) as pool:
        for out in pool.map(lambda case: diagnose(case, results, version, gap or BUILD / "bin" / "talus-gap"), cases):
            done += 1
            verdict = (
                out["report"]["verdict"]
                if out["report"]
                else {"effect": f"status {out['status']}", "joint": "-", "probability": 0}
            )
            left = (time.monotonic() - begin) / done * (len(cases) - done)
            print(
                f"{folder.name}/{out['case']}: {verdict['effect']} {verdict['joint']} {verdict['probability']:.2f}, "
                f"{out['processor_s']:.1f} s, {out['peak_MB']:.0f} MB; {len(cases) - done} to go, {left / 60:.0f} min",
                file=sys.stderr,
                flush=True,
            )
    return done
