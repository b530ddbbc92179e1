"""Runs talus-gap on one case after another, a few at a time; what has its report already is not run again."""

import json
import os
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import numpy as np

from ..blind.running import BUILD, fingerprint, measured
from ..progress import Progress

ROOT = Path(__file__).resolve().parents[3]


def diagnosed(model, recording, folder, *options):
    """What talus-gap says of a recording, and what it cost; `report` is None where it ended in another way than by a report."""
    report = folder / "gap.json"
    out = measured([BUILD / "bin" / "talus-gap", "--quiet", "--model", model, "--report", report, *options, recording])
    out["report"] = json.loads(report.read_text()) if out["status"] == 0 else None
    return out


def read(path):
    """A case's result, or None."""
    return json.loads(path.read_text()) if path.exists() else None


def write(path, text):
    """The file appears whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    fresh.write_text(text, encoding="utf-8")
    fresh.replace(path)


def run(name, cases, folder, one, jobs=1, keep=False):
    """[result] of all cases in order. A case has a `name`; `one(case)` gives its result, which is kept in the folder. A result of
    another version of the diagnosis is made anew, unless it is to be kept."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    version, results = fingerprint(), {}
    for case in cases:
        old = read(folder / f"{case.name}.json")
        if old and (keep or old["version"] == version):
            results[case.name] = old
    waiting = [case for case in cases if case.name not in results]
    step = Progress(name, len(waiting))

    def whole(case):
        result = {"case": case.name, "version": version, **one(case)}
        write(folder / f"{case.name}.json", json.dumps(result, indent=1, default=_plain))
        return result

    with ThreadPoolExecutor(jobs) as pool:
        try:
            for done in as_completed([pool.submit(whole, case) for case in waiting]):
                result = done.result()
                results[result["case"]] = result
                step(f"{result['case']}: {said(result)}")
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return [results[case.name] for case in cases]


def _plain(value):
    """NumPy's numbers for JSON."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} is no JSON")


def said(result):
    """A verdict in a few words, or how many faults were tried."""
    if "spoiled" in result:
        return f"{len(result['spoiled'])} faults"
    if result["report"] is None:
        return f"status {result['status']}"
    verdict = result["report"]["verdict"]
    return f"{verdict['effect']} {verdict['probability']:.2f}"
