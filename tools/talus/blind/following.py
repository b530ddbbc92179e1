"""Does the experiment that a diagnosis proposes tell apart what it was proposed for? The twin of the case follows the
proposed trajectory, and the diagnosis is made again with that recording, too."""

import json
import tempfile
from pathlib import Path

import numpy as np

from . import cases, sensors
from .bench import simulate
from .narrow import JITTER_S, RATE_HZ
from .running import BUILD, measured, training

PAUSE_S = 10.0  # between the last recording and this one
STREAM = 9  # of random numbers, beside those of the case


def read_trajectory(path):
    """Columns time_s, knee_rad, ankle_rad; a line of words may stand before them."""
    lines = [line for line in Path(path).read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    table = np.genfromtxt(lines, delimiter=",", names=True)
    return np.array([table[name] for name in ("time_s", "knee_rad", "ankle_rad")])


def follow(case, trajectory, camera=False):
    """The recording of a case's leg along a trajectory, by the columns of the file."""
    t, knee, ankle = trajectory
    t = t - t[0]
    rng = np.random.default_rng([*case.seed, STREAM])
    n = int(t[-1] * RATE_HZ)
    times = np.round(0.002 + np.arange(n) / RATE_HZ + rng.uniform(-JITTER_S, JITTER_S, n), 6)
    last = case.runs["test"]
    session = last["job"]["session_s"] + last["times"][-1] + PAUSE_S
    series = {"points": len(t), "settle_s": 1.0, "session_s": session, "seed": int(rng.integers(1, 2**31))}
    for i, point in enumerate(zip(t, knee, ankle, strict=True)):
        series.update({f"point_{name}[{i}]": x for name, x in zip(("s", "knee", "ankle"), point, strict=True)})
    job, sensor = case.job(case.drawn), case.sensor(case.drawn)
    run = simulate({**job, **series}, times)
    if run is None:
        raise ValueError("the trajectory drives the leg out of its range")
    options = {**case.options, "camera": camera or case.options["camera"]}
    currents = sensors.shown_currents(run, sensor)
    return sensors.recording(run, currents, sensor, case.noise, options, job, session, rng, case.plant)


def find_case(folder, name):
    """The case of that name, from the sealed file, as it was drawn."""
    sealed = json.loads((folder / "sealed" / "labels.json").read_text())
    case = cases.Case(sealed["seed"], int(name.removeprefix("case_")), sealed["mix"])
    label = next(label for label in sealed["cases"] if label["case"] == name)
    hidden = label["effects"] or ([label["hidden"]] if label["hidden"] else [])
    if [entry["size"] for entry in hidden] != [one.size for one in case.drawn]:
        cases.settle(case)  # the first draw is a bench that no one records
    return case, label


def open_groups(report):
    """Effects that the verdict leaves open beside its own."""
    effect = report["verdict"]["effect"]
    return {other for g in report["confusable"] if effect in g["effects"] for other in g["effects"]} - {effect}


def proposed_for(report):
    """Of these, those that the report says its trajectory parts; all, where it says nothing of the kind."""
    parts, left = report["next_experiment"].get("parts"), open_groups(report)
    return left if parts is None else left & {part["effect"] for part in parts}


def again(folder, name, trajectory, gap):
    """Verdict before and after the proposed experiment."""
    before = json.loads((folder / "results" / f"{name}.json").read_text())["report"]
    case, label = find_case(folder, name)
    with tempfile.TemporaryDirectory(prefix="blind-") as temporary:
        place, report = Path(temporary), Path(temporary) / "gap.json"
        needs = before["next_experiment"].get("needs")
        shown = follow(case, read_trajectory(trajectory), camera=needs == "camera")
        sensors.write(place / "next.csv.gz", shown)
        source = folder / name
        recordings = [*training(source), place / "next.csv.gz"]
        done = measured([gap, "--quiet", "--model", source / "model.yaml", "--report", report, *recordings])
        after = json.loads(report.read_text()) if done["status"] == 0 else None
    open_before = sorted(proposed_for(before))
    right = {tuple(cause.values()) for cause in ({"e": e["effect"], "j": e["joint"]} for e in label["effects"])}
    out = {"case": name, "open": [before["verdict"]["effect"], *open_before], "status": done["status"]}
    if after:
        said = after["verdict"]
        out["verdict"], out["probability"] = [said["effect"], said["joint"]], said["probability"]
        out["still_open"] = sorted(open_groups(after) & {*open_before, before["verdict"]["effect"]})
        out["separated"] = (said["effect"], said["joint"]) in right and not out["still_open"]
    return out


def proposals(folder):
    """Cases whose verdict leaves something open, the truth among it, and that came with a trajectory for it."""
    labels = {label["case"]: label for label in json.loads((folder / "sealed" / "labels.json").read_text())["cases"]}
    for result in sorted((folder / "results").glob("case_???.json")):
        path = result.with_name(f"{result.stem}.trajectory.csv")
        report = json.loads(result.read_text())["report"]
        if report is None or not path.exists():
            continue
        left = {report["verdict"]["effect"], *proposed_for(report)}
        if len(left) > 1 and left & {effect["effect"] for effect in labels[result.stem]["effects"]}:
            yield result.stem, path


def run(folder, gap=None):
    """Every proposal that can be followed; the share that separates, and how many there were."""
    if "protocol" in json.loads((folder / "sealed" / "labels.json").read_text()):
        raise ValueError(f"{folder}: cases of the wide protocol; experiments are followed in the narrow one")
    out = []
    for name, path in proposals(folder):
        out.append(again(folder, name, path, gap or BUILD / "bin" / "talus-gap"))
        print(json.dumps(out[-1]), flush=True)
    (folder / "results" / "next.json").write_text(json.dumps(out, indent=1))
    return out
