"""The whole experiment: recordings, identification, and what each choice of the paper costs.

`run` answers two mappings: `results`, the numbers of paper.json, and `series`, what the figures draw.
"""

import numpy

import talus

from . import bench, linkage, published, scoring, slips, smoothing
from .bench import JOINTS

BUILT_SEED = 1  # of how the leg differs from its drawing
TRAIN_PHASES = (11, 12, 13)  # of the recordings that the fit sees
UNSEEN_PHASE = 14
NULL_SHIFT = 0.2  # of the ankle motor's centre of mass, along the direction that no recording sees


def run(folder, seconds, say=lambda text: None):
    """The experiment with recordings of `seconds`; files go to `folder`."""
    work = folder / "recordings"
    work.mkdir(parents=True, exist_ok=True)
    say("linkage")
    drawn = talus.Model.from_tree(bench.design())
    results = {"schema": "talus-paper/1", "version": talus.constants.TL_VERSION, "seconds": seconds,
               "sample_hz": published.SAMPLE_HZ, "published": _published()}  # fmt: skip
    series = {}
    results["linkage"], series["linkage"] = _linkage(drawn)
    say("recordings")
    lab = Lab(work, seconds)
    results["bench"], results["score"] = lab.conditions()
    results["excitation"] = lab.excitation()
    say("identification")
    results["models"], series["models"] = lab.models()
    results["identification"], results["errors"], series["torque"] = _identification(lab)
    results["reduction_percent"] = {
        joint: (
            100
            * (
                1
                - results["errors"]["identified"][joint]["rms_Nm"] / results["errors"]["cad"][joint]["rms_Nm"]
            )
        )
        for joint in JOINTS
    }
    series["motion"] = _motion(lab)
    say("settings")
    prepared = {name: slips.Prepared(lab.cad, columns) for name, columns in lab.columns.items()}
    results["settings"] = _settings(lab) | _paper_smoothing(lab, prepared)
    say("slips")
    results["slips"] = _slips(lab, prepared)
    results["identifiability"] = _identifiability(lab, prepared)
    return results, series


def _published():
    return {"rmse_Nm": published.RMSE_NM, "reduction_percent": published.REDUCTION_PERCENT,
            "reduction_english_percent": published.REDUCTION_ENGLISH_PERCENT,
            "ratio_error": published.RATIO_ERROR}  # fmt: skip


# ---- the linkage -----------------------------------------------------------------


def _linkage(model):
    reference = linkage.ankle_drive(model)
    fits = linkage.best_fits(reference)
    omega, error = linkage.error_against_omega(reference)
    joint, motor, ratio = linkage.curves(reference)
    results = {
        "fits": fits,
        "omega_of_published_error_1_rad": {
            k: linkage.omega_of_error(omega, e, published.RATIO_ERROR) for k, e in error.items()
        },
        "ratio_range": [float(ratio.min()), float(ratio.max())],
    }
    return results, {"omega": omega, "error": error, "joint": joint, "motor": motor, "ratio": ratio}


# ---- recordings ------------------------------------------------------------------


class Lab:
    """The two legs, the excitations and the recordings; paths and arrays of each by name."""

    def __init__(self, folder, seconds):
        self.folder, self.seconds = folder, seconds
        tree = bench.design()
        built = bench.as_built(tree, BUILT_SEED)
        self.cad_file = scoring.write_model(tree, folder / "cad.yaml")
        self.truth_file = scoring.write_model(built, folder / "truth.yaml")
        self.cad, self.truth = talus.Model.from_tree(tree), talus.Model.from_tree(built)
        self.bounds = bench.limits(self.truth)
        self.plan, self.columns, self.true_torque, self.path = {}, {}, {}, {}
        for number, phase in enumerate(TRAIN_PHASES, 1):
            self._record(f"train{number}", phase, number)
        self._record("unseen", UNSEEN_PHASE, 4)
        for number in range(1, published.RECORDINGS + 1):
            self._record(f"printed{number}", None, 4 + number)
        self._record("printed_again", None, 8)
        self.unseen = scoring.Unseen(self.columns["unseen"], self.cad)

    def _record(self, name, phase, seed):
        self.path[name] = self.folder / f"{name}.csv"
        self.plan[name] = bench.scaled(self.cad, self.bounds, phase)
        self.columns[name], self.true_torque[name] = bench.record(
            self.truth, self.plan[name], self.seconds, seed, self.path[name]
        )

    @staticmethod
    def names(kind):
        """The three recordings that a fit sees: "train" with drawn phases, "printed" with those of (14)."""
        return [f"{kind}{number}" for number in range(1, published.RECORDINGS + 1)]

    def train(self, kind="train"):
        """Their paths."""
        return [self.path[name] for name in self.names(kind)]

    def excitation(self):
        """What (14) asks for as printed, and what was left of it."""
        printed = bench.series()
        asked = bench.peaks(self.cad, self.bounds, printed)
        return {
            "printed_base_hz": printed.base_hz,
            "harmonics": printed.harmonics,
            "asked": asked,
            "planned": {
                name: {"amplitude": plan.amplitude, "speed": plan.speed, "base_hz": plan.struct.base_hz,
                       "peaks": plan.peaks}
                for name, plan in self.plan.items()
            },
        }  # fmt: skip

    def conditions(self):
        """How recordings were made and how errors are scored."""
        score = self.unseen.recording.score
        bench_settings = bench.settings_of(self.truth, self.plan["train1"].struct, 1)
        return {**bench.describe(bench_settings), "spread": bench.SPREAD}, {
            name: getattr(score, name) for name in ("lowpass_hz", "order", "standstill", "guard_s", "trim_s")
        }

    def models(self):
        """Physical and base parameters of the leg as drawn and as built."""
        named = {"cad": self.cad, "truth": self.truth}
        return {k: {"parameters": m.parameters, "base": m.base} for k, m in named.items()}, named

    def fit(self, name, recordings, *options, model=None):
        """talus-identify from the leg as drawn: (report, path of the model, model)."""
        out = self.folder / f"{name}.yaml"
        report = scoring.identify(model or self.cad_file, recordings, out, *options)
        return report, out, talus.Model.read(out)

    def deviation_percent(self, values):
        """How far base parameters are from the truth."""
        values = values.tolist() if isinstance(values, numpy.ndarray) else values.base.values()
        return {
            name: 100 * (value / true - 1) for (name, true), value in zip(self.truth.base.items(), values)
        }


# ---- identification and prediction -----------------------------------------------


def _identification(lab):
    report, path, model = lab.fit("identified", lab.train())
    predicted = {
        "cad": scoring.predict(lab.cad_file, lab.path["unseen"], lab.folder / "cad_predicted.csv"),
        "identified": scoring.predict(path, lab.path["unseen"], lab.folder / "identified_predicted.csv"),
        "truth": scoring.predict(lab.truth_file, lab.path["unseen"], lab.folder / "truth_predicted.csv"),
        "noise_alone": lab.true_torque["unseen"],
    }
    errors = {name: lab.unseen.score(torque) for name, torque in predicted.items()}
    wanted = (
        "evaluations",
        "cost",
        "least_squares_cost",
        "condition_number",
        "null_space",
        "parameters",
        "base_parameters",
    )
    results = {key: report[key] for key in wanted}
    results["deviation_percent"] = lab.deviation_percent(model)
    series = {name: lab.unseen.filtered(torque) for name, torque in predicted.items()}
    series |= {
        "t": lab.unseen.grid(),
        "measured": lab.unseen.filtered(lab.unseen.measured),
        "kept": lab.unseen.kept(),
    }
    return results, errors, series


def _motion(lab):
    """Figure 6: the first recording's angles and their derivatives, and its torques."""
    first = scoring.Unseen(lab.columns["train1"], lab.cad)
    return {"t": first.t, "q": first.motion["q"], "v": first.motion["v"], "a": first.motion["a"],
            "torque": first.filtered(first.measured), "torque_t": first.grid(),
            "period_s": 1 / lab.plan["train1"].struct.base_hz}  # fmt: skip


def _settings(lab):
    """The paper's settings against the defaults: what they identify, and how well that predicts."""
    window = ",".join(f"{x:g}" for x in published.WINDOW)
    runs = {
        "default": (lab.train(), ()),
        "window": (lab.train(), ("--window", window)),
        "weights": (lab.train(), ("--weights", "equal")),
        "printed": (lab.train("printed"), ()),
    }
    return {name: _setting(lab, name, *of) for name, of in runs.items()}


def _setting(lab, name, recordings, options):
    report, path, model = lab.fit(f"with_{name}", recordings, *options)
    predicted = scoring.predict(path, lab.path["unseen"], lab.folder / f"with_{name}_predicted.csv")
    own = lab.unseen.score(predicted)
    if "--window" in options:
        own = lab.unseen.score(talus.predict(model, lab.unseen.recording, published.WINDOW))
    # the part that the residuals' noise makes: weights are chosen by it, and windows and sampling are no noise
    sigma = {key: (of["sigma"] ** 2 - of["systematic"] ** 2) ** 0.5 for key, of in report["base_parameters"].items()}
    return {
        "options": " ".join(options),
        "errors": lab.unseen.score(predicted),
        "errors_own_window": own,
        "deviation_percent": lab.deviation_percent(model),
        "base_sigma": sigma,
        "window": {j: [report["recordings"][0][j][k] for k in ("window_order", "window_s")] for j in JOINTS},
        "condition_number": report["condition_number"],
    }


def _paper_smoothing(lab, prepared):
    """The paper's window as it prints it, across reversals, with either weights."""
    smoothed = {name: smoothing.Smoothed(lab.cad, prepared[name]) for name in (*lab.names("train"), "unseen")}
    rows = slips.Rows([smoothed[name] for name in lab.names("train")])
    check = {
        "errors": slips.Rows([prepared["unseen"]]),
        "errors_own_window": slips.Rows([smoothed["unseen"]]),
    }
    out = {}
    for name, equal in (("paper_window", False), ("paper_window_weights", True)):
        fitted = slips.fit(lab.cad, rows, equal)
        errors = {key: {j: {"rms_Nm": rms} for j, rms in of.rms(fitted).items()} for key, of in check.items()}
        out[name] = {**errors, "deviation_percent": lab.deviation_percent(fitted)}
    return out


# ---- slips -----------------------------------------------------------------------


def _slips(lab, prepared):
    """Each set of slips, fitted on either motion, checked on the same motion and on the other."""
    sets = {"none": (), **{name: (name,) for name in slips.SLIPS}, "all": slips.SLIPS}
    cad = numpy.array(list(lab.cad.base.values()))
    out = {}
    for name, chosen in sets.items():
        rows = {of: slips.Rows([prepared[of]], chosen) for of in ("unseen", "printed_again")}
        out[name] = {}
        for kind, own in (("train", "unseen"), ("printed", "printed_again")):
            fitted = slips.fit(lab.cad, slips.Rows([prepared[of] for of in lab.names(kind)], chosen))
            out[name][kind] = {
                "same_motion_cad_rms_Nm": rows[own].rms(cad),
                "same_motion_rms_Nm": rows[own].rms(fitted),
                "other_phases_rms_Nm": rows["unseen"].rms(fitted),
                "deviation_percent": lab.deviation_percent(fitted),
            }
    out["paper_form"] = _paper_form(lab)
    return out


def _paper_form(lab):
    """All slips at once by the programs: the model file's `form: paper`."""
    tree = {**bench.design(), "form": "paper"}
    model = scoring.write_model(tree, lab.folder / "cad_paper_form.yaml")
    out = {}
    for kind in ("train", "printed"):
        _, path, fitted = lab.fit(f"paper_form_{kind}", lab.train(kind), model=model)
        predicted = scoring.predict(path, lab.path["unseen"], lab.folder / f"paper_form_{kind}_predicted.csv")
        score = lab.unseen.score(predicted)
        out[kind] = {"other_phases_rms_Nm": {j: score[j]["rms_Nm"] for j in JOINTS},
                     "deviation_percent": lab.deviation_percent(fitted)}  # fmt: skip
    return out


# ---- identifiability -------------------------------------------------------------


def _identifiability(lab, prepared):
    """Singular values of the ten parameters' regressor (each in units of its CAD value), and a second leg
    that differs along the null direction."""
    rows = slips.Rows([prepared[name] for name in lab.names("train")])
    parameters = lab.cad.parameters
    jacobian = numpy.zeros((len(lab.cad.base), len(parameters)))
    talus.lib.tl_base_jacobian(lab.cad.struct, talus.pointer(jacobian))
    columns = [
        x @ jacobian * list(parameters.values()) / size for (x, _), size in zip(rows.joint, rows.noise())
    ]
    values = numpy.linalg.svd(numpy.linalg.qr(numpy.vstack(columns), mode="r"), compute_uv=False)
    other, m = lab.truth.copy(), lab.truth.struct
    shifted = lab.truth.parameters["ankle_motor_com_m"] * (1 + NULL_SHIFT)
    com = (lab.truth.base["shank_moment"] - m.ankle_motor_mass_kg * shifted) / m.shank_mass_kg
    inertia = lab.truth.base["shank_inertia"] - m.shank_mass_kg * com**2 - m.ankle_motor_mass_kg * shifted**2
    other.set_parameters(ankle_motor_com_m=shifted, shank_com_m=com, shank_inertia_kg_m2=inertia)
    motion = [lab.unseen.motion[key] for key in ("q", "v", "a")]
    difference = numpy.abs(other.inverse(*motion) - lab.truth.inverse(*motion)).max()
    return {"singular_values": values.tolist(), "shift": NULL_SHIFT, "truth": lab.truth.parameters,
            "same_torque_leg": other.parameters, "largest_difference_Nm": float(difference)}  # fmt: skip
