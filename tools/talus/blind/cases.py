"""Draws cases and writes their folders; the answers go into one sealed file."""

import copy
import hashlib
import json

import numpy as np

from . import effects, narrow, sensors, unknowns, wide
from .bench import simulate
from .narrow import CURRENT_LIMIT_A
from .surviving import surviving

MIX = {"single": 0.45, "pair": 0.18, "none": 0.18, "unknown": 0.19}
PROTOCOLS = {protocol.NAME: protocol for protocol in (narrow, wide)}
FARTHEST_DROOP = 1.5  # times the current at which it is told, that a drive with a droop may be asked for
# steps of additive sequences: neighbours spread evenly over kinds and effects, and case k never depends on the count
KIND_STEP, EFFECT_STEP = 0.6180339887498949, 0.7548776662466927


def _place(seed, number, step, what):
    """A number in 0..1 that fills it evenly over the cases of a seed."""
    return (np.random.default_rng([seed, 0, what]).uniform() + number * step) % 1.0


def kind_of(seed, number, mix):
    at = _place(seed, number, KIND_STEP, 1) * sum(mix.values())
    for kind, share in mix.items():
        at -= share
        if at < 0:
            return kind
    return next(reversed(mix))


class Case:
    """One case: all that is random about it, by its own streams. The protocol draws plant, control, limits_A, runs, noise,
    options and what is said of it in the sealed file."""

    def __init__(self, seed, number, mix, protocol="narrow"):
        self.number, self.kind, self.seed = number, kind_of(seed, number, mix), (seed, number + 1)
        self.streams = {name: np.random.default_rng([seed, number + 1, i])
                        for i, name in enumerate(("plant", "bench", "effect", "noise", "prior"))}  # fmt: skip
        PROTOCOLS[protocol].draw_bench(self)
        self.redraw(_place(seed, number, EFFECT_STEP, 2))

    def redraw(self, at):
        """What is hidden; `at` in 0..1 chooses which."""
        rng = self.streams["effect"]
        if self.kind == "single":
            self.drawn = [effects.draw(rng, self.plant, at)]
        elif self.kind == "pair":
            self.drawn = effects.draw_pair(rng, self.plant, at)
        else:
            self.drawn = [unknowns.draw(rng, self.plant, at)] if self.kind == "unknown" else []

    def job(self, drawn):
        """What the twin is told, but for the run."""
        job = {**self.plant.job(), **self.control, "temp_tau": self.options["tau_s"]}
        for one in drawn:
            job.update(one.job)
        return job

    @staticmethod
    def sensor(drawn):
        """What the drawn effects do to the sensors."""
        return {name: value for one in drawn for name, value in one.sensor.items()}

    def simulate(self, drawn):
        """Runs, shown currents and the sensors' table; None where the leg leaves its range."""
        job, sensor, out = self.job(drawn), self.sensor(drawn), {}
        for name, run in self.runs.items():
            out[name] = simulate({**job, **run["job"]}, run["times"])
            if out[name] is None:
                return None
        return out, {name: sensors.shown_currents(out[name], sensor) for name in self.runs}, sensor

    def ratios(self, simulated, drawn):
        runs, currents, sensor = simulated
        noise = {**self.noise, "camera_rad": self.noise["camera_rad"] if self.options["camera"] else None}
        shown = {name: sensors.shown_joint(run, sensor) for name, run in runs.items()}
        currents = {name: {joint: sensors.hang(i, runs[name]["t"], sensor, joint) for joint, i in both.items()}
                    for name, both in currents.items()}  # fmt: skip
        return surviving(runs, currents, noise, self.job(drawn), self.plant, shown)


def observable(ratios):
    """Whether torque and angle show it in training."""
    seen = [r for name, r in ratios.items() if name != "test"]
    angles = ("knee_camera", "ankle_encoder")
    return (any(value > 1 for r in seen for name, value in r.items() if name not in angles),
            any(r.get(name, 0.0) > 1 for r in seen for name in angles))  # fmt: skip


def current_peak_A(simulated, joints=("knee", "ankle")):
    """Largest shown current of each joint over all recordings."""
    return {j: float(max(np.abs(both[j]).max() for both in simulated[1].values())) for j in joints}


def runs_away(simulated, limits_A=CURRENT_LIMIT_A):
    """Does the machine leave its range, or a motor swing between its current's limits? No one records such a bench."""
    if simulated is None:
        return True
    return any(peak > 0.9 * limits_A[joint] for joint, peak in current_peak_A(simulated, limits_A).items())


def drive_gives_out(drawn, simulated, told_A=effects.PEAK_A):
    """Does a current go far beyond the one at which a droop is told? Some forms would then give ever less torque for more
    current, as no drive does that is on a bench."""
    peak = current_peak_A(simulated, told_A)
    return any(effects.droops(one) and peak[one.joint] > FARTHEST_DROOP * told_A[one.joint] for one in drawn)


def settle(case):
    """The case's simulation; an effect that lets the bench run away, or its drive give out, is drawn again."""
    simulated, told_A = case.simulate(case.drawn), {joint: scale.peak_A for joint, scale in case.plant.scale.items()}
    while runs_away(simulated, case.limits_A) or drive_gives_out(case.drawn, simulated, told_A):
        case.redraw(case.streams["effect"].uniform())
        simulated = case.simulate(case.drawn)
    return simulated


def shown_name(case, joint):
    """A twin's joint as the files call it."""
    return case.plant.shown.get(joint, joint)


def by_shown_name(case, values):
    """The same of a mapping's names."""
    for joint, name in case.plant.shown.items():
        values = {name + key.removeprefix(joint) if key.split("_")[0] == joint else key: v for key, v in values.items()}
    return values


def describe(case, one, ratios=None):
    alias = [[effect, shown_name(case, joint)] for effect, joint in one.alias if effect in effects.OF_PLANT[case.plant.kind]]
    entry = {"effect": one.effect, "joint": shown_name(case, one.joint), "size": one.size, "form": one.form, "alias_with": alias,
             "parameters": one.parameters()}  # fmt: skip
    if ratios:
        entry["observable_torque"], entry["observable_angle"] = observable(ratios[0])
        entry["observable"] = entry["observable_torque"] or entry["observable_angle"]
        entry["detectability"] = ratios[1]
    return entry


def truth(case, simulated):
    """The answer."""
    ratios, detectability = case.ratios(simulated, case.drawn)
    parts = []
    for one in case.drawn:
        own = case.ratios(case.simulate([one]), [one]) if case.kind == "pair" else (ratios, detectability)
        parts.append(describe(case, one, own))
    in_torque, in_angle = observable(ratios)
    single = case.kind == "single"
    noise = {**case.noise, "camera_rad": case.noise["camera_rad"] if case.options["camera"] else None}
    return {
        **({"protocol": case.protocol} if case.protocol else {}),
        "case": f"case_{case.number:03d}",
        "kind": case.kind,
        "effects": parts if case.kind != "unknown" else [],
        "hidden": parts[0] if case.kind == "unknown" else None,
        "effect": case.drawn[0].effect if single else case.kind,
        "joint": shown_name(case, case.drawn[0].joint) if single else "none",
        "alias_with": parts[0]["alias_with"] if single else [],
        "surviving_over_noise": {name: by_shown_name(case, r) for name, r in ratios.items()},
        "detectability": detectability,
        "observable_torque": in_torque,
        "observable_angle": in_angle,
        "observable": in_torque or in_angle,
        "noise": by_shown_name(case, noise),
        "parameters": case.plant.parameters(),
        "base_parameters": case.plant.base(),
        "current_peak_A": by_shown_name(case, current_peak_A(simulated, case.plant.joints)),
    }


def write_case(folder, case, simulated):
    """model.yaml and the four recordings."""
    place = folder / f"case_{case.number:03d}"
    place.mkdir(parents=True, exist_ok=True)
    (place / "model.yaml").write_text(case.plant.cad(case.streams["prior"]))
    runs, currents, sensor = simulated
    job = case.job(case.drawn)
    for name in case.runs:
        case.noise_before = copy.deepcopy(case.streams["noise"])  # of the last one, the test's
        session = case.runs[name]["job"]["session_s"]
        shown = sensors.recording(
            runs[name], currents[name], sensor, case.noise, case.options, job, session, case.streams["noise"], case.plant
        )
        sensors.write(place / f"{name}.csv.gz", shown, decimals(case))


def decimals(case):
    """Of the files' columns: those of the narrow protocol, else as many as there are."""
    return None if case.protocol else sensors.DECIMALS


def write_floor(place, case):
    """The unseen recording as it would be without any effect: what the true model leaves of it is lost to encoder steps and
    smoothing, whatever the effect. In the narrow protocol the currents are without noise, in the wide one with the very same."""
    run = simulate({**case.job([]), **case.runs["test"]["job"]}, case.runs["test"]["times"])
    silent = case.noise if case.protocol else {**case.noise, "knee_current_A": 0.0, "ankle_current_A": 0.0}
    options = {**case.options, "camera": False, "temperature": False, "bus": False}
    rng = case.noise_before if case.protocol else np.random.default_rng(0)
    shown = sensors.recording(run, sensors.shown_currents(run, {}), {}, silent, options, {}, 0.0, rng, case.plant)
    sensors.write(place, shown, decimals(case))


def plain(value):
    """JSON has no numpy numbers."""
    if isinstance(value, (np.floating, np.integer, np.bool_)):
        return value.item()
    raise TypeError(type(value))


def make(seed, number, mix, folder, protocol="narrow"):
    """Writes one case; its truth."""
    case = Case(seed, number, mix, protocol)
    simulated = settle(case)
    answer = truth(case, simulated)
    write_case(folder, case, simulated)
    (folder / "sealed").mkdir(exist_ok=True)
    write_floor(folder / "sealed" / f"{answer['case']}.csv.gz", case)
    (folder / "sealed" / f"{answer['case']}.yaml").write_text(case.plant.model_text(case.plant.parameters()))
    return json.loads(json.dumps(answer, default=plain))


def seal(folder, seed, mix, answers, protocol="narrow"):
    """The answers in one file; returns its checksum."""
    place = folder / "sealed"
    place.mkdir(parents=True, exist_ok=True)
    named = {} if protocol == "narrow" else {"protocol": protocol}
    text = json.dumps({"seed": seed, "mix": mix, **named, "cases": answers}, indent=1)
    (place / "labels.json").write_text(text)
    return hashlib.sha256(text.encode()).hexdigest()
