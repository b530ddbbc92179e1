"""Draws cases and writes their folders; the answers go into one sealed file."""

import hashlib
import json
from dataclasses import asdict

import numpy as np

from . import effects, sensors, unknowns
from .bench import CURRENT_LIMIT_A, FIXED, LINKAGE, RECORDINGS, Plant, draw_control, draw_runs, simulate
from .surviving import surviving

MIX = {"single": 0.45, "pair": 0.18, "none": 0.18, "unknown": 0.19}
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
    """One case: all that is random about it, by its own streams."""

    def __init__(self, seed, number, mix):
        self.number, self.kind, self.seed = number, kind_of(seed, number, mix), (seed, number + 1)
        self.streams = {name: np.random.default_rng([seed, number + 1, i])
                        for i, name in enumerate(("plant", "bench", "effect", "noise", "prior"))}  # fmt: skip
        self.plant = Plant.draw(self.streams["plant"])
        bench = self.streams["bench"]
        self.control, self.runs = draw_control(bench), draw_runs(bench)
        self.noise, self.options = sensors.complete_noise(sensors.draw_noise(bench)), sensors.draw_options(bench)
        rng, at = self.streams["effect"], _place(seed, number, EFFECT_STEP, 2)
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
        for name in RECORDINGS:
            out[name] = simulate({**job, **self.runs[name]["job"]}, self.runs[name]["times"])
            if out[name] is None:
                return None
        return out, {name: sensors.shown_currents(out[name], sensor) for name in RECORDINGS}, sensor

    def ratios(self, simulated, drawn):
        runs, currents, sensor = simulated
        noise = {**self.noise, "camera_rad": self.noise["camera_rad"] if self.options["camera"] else None}
        shown = {name: sensors.shown_joint(run, sensor) for name, run in runs.items()}
        currents = {name: {joint: sensors.hang(i, runs[name]["t"], sensor, joint) for joint, i in both.items()}
                    for name, both in currents.items()}  # fmt: skip
        return surviving(runs, currents, noise, self.job(drawn), shown)


def observable(ratios):
    """Whether torque and angle show it in training."""
    seen = [ratios[name] for name in RECORDINGS if name != "test"]
    return (any(max(r["knee"], r["ankle"]) > 1 for r in seen),
            any(max(r["knee_camera"], r["ankle_encoder"]) > 1 for r in seen))  # fmt: skip


def current_peak_A(simulated):
    """Largest shown current of each joint over all recordings."""
    return {j: float(max(np.abs(simulated[1][n][j]).max() for n in RECORDINGS)) for j in CURRENT_LIMIT_A}


def runs_away(simulated):
    """Does the leg leave its range, or a motor swing between its current's limits? No one records such a bench."""
    if simulated is None:
        return True
    return any(peak > 0.9 * CURRENT_LIMIT_A[joint] for joint, peak in current_peak_A(simulated).items())


def drive_gives_out(drawn, simulated):
    """Does a current go far beyond the one at which a droop is told? Some forms would then give ever less torque for more
    current, as no drive does that is on a bench."""
    peak = current_peak_A(simulated)
    return any(effects.droops(one) and peak[one.joint] > FARTHEST_DROOP * effects.PEAK_A[one.joint] for one in drawn)


def settle(case):
    """The case's simulation; an effect that lets the bench run away, or its drive give out, is drawn again."""
    simulated = case.simulate(case.drawn)
    while runs_away(simulated) or drive_gives_out(case.drawn, simulated):
        rng = case.streams["effect"]
        case.drawn = ([effects.draw(rng, case.plant, rng.uniform())] if case.kind == "single"
                      else effects.draw_pair(rng, case.plant, rng.uniform()) if case.kind == "pair"
                      else [unknowns.draw(rng, case.plant, rng.uniform())])  # fmt: skip
        simulated = case.simulate(case.drawn)
    return simulated


def describe(case, one, ratios=None):
    entry = {"effect": one.effect, "joint": one.joint, "size": one.size, "form": one.form, "alias_with": one.alias,
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
        "case": f"case_{case.number:03d}",
        "kind": case.kind,
        "effects": parts if case.kind != "unknown" else [],
        "hidden": parts[0] if case.kind == "unknown" else None,
        "effect": case.drawn[0].effect if single else case.kind,
        "joint": case.drawn[0].joint if single else "none",
        "alias_with": case.drawn[0].alias if single else [],
        "surviving_over_noise": ratios,
        "detectability": detectability,
        "observable_torque": in_torque,
        "observable_angle": in_angle,
        "observable": in_torque or in_angle,
        "noise": noise,
        "parameters": asdict(case.plant),
        "base_parameters": case.plant.base(),
        "current_peak_A": current_peak_A(simulated),
    }


def cad_model(case):
    """The model as CAD gives it: what has to be identified is off."""
    rng, p = case.streams["prior"], case.plant
    parts = {name: 0.10 if name.endswith("com_m") else 0.20 if "inertia" in name else 0.40 for name in asdict(p)}
    return model_text({name: x * rng.uniform(1 - parts[name], 1 + parts[name]) for name, x in asdict(p).items()})


def model_text(parameters):
    """A model file with these values of what has to be identified, and the drawing's of all else."""
    p = {name: f"{value:.9g}" for name, value in parameters.items()}
    com = [p[f"{name}_com_m"] for name in ("shank", "foot", "ankle_motor")]
    inertia = [p[name] for name in ("shank_inertia_kg_m2", "foot_inertia_kg_m2", "ankle_rotor_inertia_kg_m2")]
    friction = [p[f"{joint}_{what}"] for joint in ("knee", "ankle") for what in ("coulomb_Nm", "viscous_Nms_rad")]
    sizes = ", ".join(f"{name}: {value}" for name, value in LINKAGE.items())
    return f"""plant: leg
gravity_m_s2: {FIXED["gravity"]}
shank: {{length_m: {FIXED["ls"]}, mass_kg: {FIXED["ms"]}, com_m: {com[0]}, inertia_kg_m2: {inertia[0]}}}
foot: {{mass_kg: {FIXED["mf"]}, com_m: {com[1]}, inertia_kg_m2: {inertia[1]}}}
ankle_motor: {{mass_kg: {FIXED["mm"]}, com_m: {com[2]}}}
knee:
  transmission: {{type: fixed, ratio: 51}}
  torque_constant_Nm_A: {FIXED["K"]}
  friction: {{coulomb_Nm: {friction[0]}, viscous_Nms_rad: {friction[1]}}}
ankle:
  transmission: {{type: screw_linkage, {sizes}}}
  torque_constant_Nm_A: {FIXED["K"]}
  rotor_inertia_kg_m2: {inertia[2]}
  friction: {{coulomb_Nm: {friction[2]}, viscous_Nms_rad: {friction[3]}}}
"""


def write_case(folder, case, simulated):
    """model.yaml and the four recordings."""
    place = folder / f"case_{case.number:03d}"
    place.mkdir(parents=True, exist_ok=True)
    (place / "model.yaml").write_text(cad_model(case))
    runs, currents, sensor = simulated
    job = case.job(case.drawn)
    for name in RECORDINGS:
        session = case.runs[name]["job"]["session_s"]
        shown = sensors.recording(
            runs[name], currents[name], sensor, case.noise, case.options, job, session, case.streams["noise"]
        )
        sensors.write(place / f"{name}.csv.gz", shown)


def write_floor(place, case):
    """The unseen recording as it would be without any effect and without noise on the currents: what the true model
    leaves of it is lost to encoder steps and smoothing, whatever the effect."""
    run = simulate({**case.job([]), **case.runs["test"]["job"]}, case.runs["test"]["times"])
    silent = {**case.noise, "knee_current_A": 0.0, "ankle_current_A": 0.0}
    options = {**case.options, "camera": False, "temperature": False, "bus": False}
    rng = np.random.default_rng(0)
    sensors.write(place, sensors.recording(run, sensors.shown_currents(run, {}), {}, silent, options, {}, 0.0, rng))


def plain(value):
    """JSON has no numpy numbers."""
    if isinstance(value, (np.floating, np.integer, np.bool_)):
        return value.item()
    raise TypeError(type(value))


def make(seed, number, mix, folder):
    """Writes one case; its truth."""
    case = Case(seed, number, mix)
    simulated = settle(case)
    answer = truth(case, simulated)
    write_case(folder, case, simulated)
    (folder / "sealed").mkdir(exist_ok=True)
    write_floor(folder / "sealed" / f"{answer['case']}.csv.gz", case)
    return json.loads(json.dumps(answer, default=plain))


def seal(folder, seed, mix, answers):
    """The answers in one file; returns its checksum."""
    place = folder / "sealed"
    place.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"seed": seed, "mix": mix, "cases": answers}, indent=1)
    (place / "labels.json").write_text(text)
    return hashlib.sha256(text.encode()).hexdigest()
