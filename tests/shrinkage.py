"""How far the gap shrinks on a recording that was never given to the tool, measured from outside: what talus-predict
says with the model file that talus-gap wrote, against the plain model of talus-identify and the true noise.

    PYTHONPATH=tools:tests python tests/shrinkage.py FOLDER [CASE...]

measures labelled cases ($TALUS_DATA/leg_cases; all without CASE), prints a table, and leaves the files in FOLDER."""

import json
import sys
from pathlib import Path

import numpy
import yaml
from support import REPOSITORY, data, run

import talus

TRAININGS = ("train1", "train2", "train3")
LEAST_LEFT = 0.5  # of the noise floor: a systematic rest below it is what reconstruction leaves without any effect too


def scored_rms(model, recording, predicted):
    return [joint["rms"] for joint in talus.score(model, recording, predicted).values()]


def noise_floor(model, recording, truth):
    """RMS that the true noise of the currents leaves after the score's filter."""
    shown, random = talus.measured(model, recording), numpy.random.default_rng(1)
    deviation = [[truth["noise"][f"{joint}_torque_Nm"]] for joint in model.joints]
    return scored_rms(model, recording, shown + deviation * random.standard_normal(shown.shape))


def predict(model_file, recording_file):
    """Columns that talus-predict answers, (joints, n)."""
    done = run("talus-predict", "--model", model_file, recording_file)
    lines = done.stdout.splitlines()
    return numpy.array([[float(x) for x in line.split(",")[1:]] for line in lines[1:]]).T


def measure(case, folder, again=True):
    """What one labelled case leaves: {"notes", "effects", joint: {"identified", "extended", "floor", "closed"}}."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {name: case / f"{name}.csv.gz" for name in (*TRAININGS, "test")}
    trainings, notes = [files[name] for name in TRAININGS], ""
    if again or not (folder / "extended.yaml").exists():
        run("talus-identify", "--quiet", "--model", case / "model.yaml", "--out", folder / "identified.yaml", *trainings)
        done = run("talus-gap", "--quiet", "--model", case / "model.yaml", "--report", folder / "gap.json",
                   "--save-model", folder / "extended.yaml", *trainings)  # fmt: skip
        (folder / "notes.txt").write_text(done.stderr)
    notes, report = (folder / "notes.txt").read_text(), json.loads((folder / "gap.json").read_text())
    tree, truth = yaml.safe_load((case / "model.yaml").read_text()), json.loads((case / "truth.json").read_text())
    model = talus.Model.from_tree(tree)
    recording = talus.Recording.read(files["test"], tree.get("score"))
    floor = noise_floor(model, recording, truth)
    left = [scored_rms(model, recording, predict(folder / f"{name}.yaml", files["test"])) for name in ("identified", "extended")]
    out = {"notes": notes, "effects": [(e["effect"], e["joint"]) for e in report["effects"]],
           "verdict": report["verdict"], "saved": yaml.safe_load((folder / "extended.yaml").read_text()).get("effects", []),
           "truth": truth["effect"], "joints": {}}  # fmt: skip
    for joint, identified, extended, noise in zip(model.joints, *left, floor):
        rest = identified**2 - noise**2
        closable = rest > (LEAST_LEFT * noise) ** 2
        out["joints"][joint] = {"identified": identified, "extended": extended, "floor": noise, "closable": closable,
                                "closed": (identified**2 - extended**2) / rest if closable else None}  # fmt: skip
    return out


def closed_fractions(measured):
    """Of all joints where something can be closed."""
    return [j["closed"] for m in measured for j in m["joints"].values() if j["closable"]]


def table(name, measured):
    """Lines of one case."""
    for joint, j in measured["joints"].items():
        closed = f"{j['closed']:7.3f}" if j["closable"] else "      -"
        notes = [line for line in measured["notes"].splitlines() if "not identifiable" not in line]
        found = " ".join(f"{e}/{at}" for e, at in measured["effects"])
        yield (f"{name} {joint:5} {1e3 * j['identified']:8.3f} {1e3 * j['extended']:8.3f} {1e3 * j['floor']:8.3f} mNm {closed}  "
               f"{measured['truth']}: {found} {len(measured['saved'])} saved")  # fmt: skip
    yield from notes


def main(arguments):
    folder, cases = Path(arguments[0]), arguments[1:] or sorted(p.name for p in data("leg_cases").glob("case_*"))
    every = []
    for name in cases:
        every.append(measure(data("leg_cases") / name, folder / name))
        print(*table(name, every[-1]), sep="\n", flush=True)
    closed = closed_fractions(every)
    if closed:
        print(f"{len(closed)} joints: median {numpy.median(closed):.3f}, tenth {numpy.quantile(closed, 0.1):.3f}")


if __name__ == "__main__":
    main(sys.argv[1:])
