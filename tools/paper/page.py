"""The page: what the experiment found, in words, tables and figures. Every number comes from `results`."""

from pathlib import Path

from . import figures, linkage, published
from .bench import JOINTS
from .markup import figure, milli, number, paragraph, percent, section, table

ROOT = Path(__file__).resolve().parents[2]
INERTIAL = 6  # of the ten parameters; the others are frictions

UNITS = {"kg_m2": "kg m²", "Nms_rad": "Nm s/rad", "Nm": "Nm", "m": "m"}
BASE_NAMES = {
    "shank_inertia": "shank inertia",
    "shank_moment": "shank moment",
    "foot_moment": "foot moment",
    "foot_inertia": "foot inertia",
    "ankle_rotor_inertia": "ankle rotor inertia",
    "knee_coulomb": "knee Coulomb",
    "knee_viscous": "knee viscous",
    "ankle_coulomb": "ankle Coulomb",
    "ankle_viscous": "ankle viscous",
}
SLIP_NAMES = {
    "none": "correct equations",
    "rotor": "velocity terms 3 I<sub>ma</sub>",
    "sign": "sign of T<sub>τf</sub>",
    "speed": "ankle friction on the foot’s speed",
    "all": "all three: the print",
}
SLIP_LABELS = {
    "none": "correct",
    "rotor": "3 Ima",
    "sign": "sign of Tτf",
    "speed": "foot’s speed",
    "all": "all three",
}
TORQUE_KEY = (("measured", "measured"), ("nominal", "CAD values"), ("identified", "identified"))
JOINT_KEY = (("knee", "knee"), ("ankle", "ankle"))


def write(path, results, series):
    """The whole page into one file that needs no other."""
    css = (ROOT / "apps/common/assets/page.css").read_text(encoding="utf-8")
    css += (Path(__file__).parent / "paper.css").read_text(encoding="utf-8")
    parts = [
        _opening(results), _prediction(results, series), _parameters(results), _identifiability(results),
        _excitation(results, series), _slips(results), _settings(results), _linkage(results, series),
        _making(results),
    ]  # fmt: skip
    path.write_text(
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n<link rel="icon" href="data:,">\n'
        f"<title>The paper, reproduced</title>\n<style>\n{css}</style>\n</head>\n<body>\n<main>\n"
        f"{''.join(parts)}</main>\n</body>\n</html>\n",
        encoding="utf-8",
    )


# ---- opening -------------------------------------------------------------------------


def _opening(r):
    cad, found, truth, noise = (r["errors"][k] for k in ("cad", "identified", "truth", "noise_alone"))
    rows = []
    for j in JOINTS:
        before, after = published.RMSE_NM[j]
        rows.append(
            [
                j,
                milli(cad[j]["rms_Nm"]),
                milli(found[j]["rms_Nm"]),
                percent(r["reduction_percent"][j], 4),
                milli(truth[j]["rms_Nm"]),
                milli(noise[j]["rms_Nm"]),
                milli(before, 2),
                milli(after, 2),
                percent(published.REDUCTION_PERCENT[j], 4),
            ]
        )
    lead = (
        f"From three recordings of {_length(r)} of a simulated knee-ankle leg, talus finds the leg’s inertias"
        " and frictions, and then predicts the motor torques of a recording that it has not seen: off by"
        f" {milli(found['knee']['rms_Nm'])} mNm at the knee and {milli(found['ankle']['rms_Nm'])} mNm at the"
        f" ankle, where the drawing’s values are off by {milli(cad['knee']['rms_Nm'])} and"
        f" {milli(cad['ankle']['rms_Nm'])}."
    )
    about = (
        "This is the experiment of ‘Dynamic parameter identification of ankle-knee prostheses based on"
        f" Coulomb-viscous friction’ (J. Dynamics and Control 22(2), 2024, DOI {published.DOI}), done on"
        " talus’s bench twin instead of a bench. The leg is a design of our own, so the paper’s figures"
        " stand beside ours for comparison, not as a target; in exchange the truth is known, and what each"
        " choice of the paper costs can be measured. Bracketed numbers are the paper’s equations. All"
        " numbers: <a href='paper.json'>paper.json</a>."
    )
    head = [
        ["", ("here", 'colspan="5"'), ("the paper", 'colspan="3"')],
        [
            "",
            "CAD values",
            "identified",
            "reduction",
            "true values",
            "noise alone",
            "CAD values",
            "identified",
            "reduction",
        ],
    ]
    return (
        "<h1>The paper, reproduced</h1>\n"
        + paragraph(lead, "lead")
        + paragraph(about)
        + table("RMS error of the predicted motor torque on the unseen recording [mNm]", head, rows)
        + _navigation()
    )


def _length(r):
    minutes = r["seconds"] / 60
    return f"{number(minutes, 1)} minutes" if minutes >= 2 else f"{number(r['seconds'], 2)} s"


def _navigation():
    entries = {
        "prediction": "Figures 7, 8",
        "parameters": "Tables 3, 4",
        "nine": "Nine of ten",
        "excitation": "(14), figure 6",
        "slips": "Slips",
        "settings": "Window and weights",
        "linkage": "Figure 3, table 2",
        "making": "How",
    }
    return (
        "<nav>" + " ".join(f'<a href="#{anchor}">{name}</a>' for anchor, name in entries.items()) + "</nav>\n"
    )


# ---- results -------------------------------------------------------------------------


def _prediction(r, series):
    found = r["errors"]["identified"]
    text = (
        f"Figures 7 and 8 of the paper: {number(figures.EXCERPT_S, 1)} s of the unseen recording, as it is"
        f" scored ({number(r['score']['lowpass_hz'], 2)} Hz zero-phase low-pass on both). Where a joint"
        " stands still, its friction is anything between the two Coulomb levels; such samples are left out"
        f" and appear as gaps in the error ({found['knee']['left_out']:,} of"
        f" {found['knee']['left_out'] + found['knee']['scored']:,} samples at the knee,"
        f" {found['ankle']['left_out']:,} at the ankle)."
    )
    return section(
        "prediction",
        "Predicted torque",
        paragraph(text),
        figure("Figure 7: knee", figures.torque(series["torque"], "knee"), TORQUE_KEY),
        figure("Figure 8: ankle", figures.torque(series["torque"], "ankle"), TORQUE_KEY),
        paragraph(
            "The true values predict about as well as the identified ones: what is left is noise of the"
            " currents and what encoders cannot tell of the acceleration. The paper’s abstracts disagree"
            f" about its own reductions ({_pair(published.REDUCTION_PERCENT)} in Chinese,"
            f" {_pair(published.REDUCTION_ENGLISH_PERCENT)} in English); its RMSE values, shown above, give"
            " the Chinese ones."
        ),
    )


def _pair(values):
    return " and ".join(percent(values[j], 4) for j in JOINTS)


def _unit(name):
    return next(unit for suffix, unit in UNITS.items() if name.endswith("_" + suffix))


def _in_sigma(of, truth):
    return number((of["value"] - truth) / of["sigma"], 2) if of["sigma"] else ("–", 'class="none"')


def _within(r):
    base, truth = r["identification"]["base_parameters"], r["models"]["truth"]["base"]
    inside = sum(abs(of["value"] - truth[name]) <= 3 * of["sigma"] for name, of in base.items())
    return f"{inside} of the {len(base)}"


def _parameters(r):
    found, truth = r["identification"]["parameters"], r["models"]["truth"]["parameters"]
    rows = []
    for name, of in found.items():
        symbol, words = published.SYMBOLS[name]
        sigma = number(of["sigma"], 2) if of["identifiable"] else ("not identifiable", 'class="none"')
        rows.append(
            [
                f"{symbol} <span class='note'>{words} [{_unit(name)}]</span>",
                number(of["prior"], 4),
                number(of["value"], 4),
                sigma,
                number(truth[name], 4),
                percent(100 * (of["value"] / of["prior"] - 1), 3, True),
                percent(100 * (of["value"] / truth[name] - 1), 2, True),
                _in_sigma(of, truth[name]),
            ]
        )
    head = [["", "CAD", "identified", "σ", "truth", "from CAD", "from truth", "in σ"]]
    base = []
    for name, formula in (
        (
            "shank_inertia",
            (
                "I<sub>1</sub> + m<sub>s</sub>d<sub>s</sub>² + m<sub>m</sub>d<sub>ma</sub>² "
                "<span class='note'>[kg m²]</span>"
            ),
        ),
        (
            "shank_moment",
            "m<sub>s</sub>d<sub>s</sub> + m<sub>m</sub>d<sub>ma</sub> <span class='note'>[kg m]</span>",
        ),
    ):
        of, true, cad = (r["identification"]["base_parameters"][name], r["models"]["truth"]["base"][name],
                         r["models"]["cad"]["base"][name])  # fmt: skip
        base.append(
            [
                formula,
                number(cad, 4),
                number(of["value"], 4),
                number(of["sigma"], 2),
                number(true, 4),
                percent(100 * (of["value"] / cad - 1), 3, True),
                percent(100 * (of["value"] / true - 1), 2, True),
                _in_sigma(of, true),
            ]
        )
    i = r["identification"]
    swarm = (
        f"The swarm ended {number(i['cost'] / i['least_squares_cost'] - 1, 1)} (relative) above linear least"
        f" squares after {i['evaluations']:,} evaluations; the regressor’s condition number is"
        f" {number(i['condition_number'])}. σ is the standard deviation that talus reports; {_within(r)} base"
        " parameters lie within 3 σ of the truth. σ counts noise; beyond it lies what is systematic, here"
        " mainly the acceleration as a window reads it from encoders at this rate."
    )
    return section(
        "parameters",
        "Identified parameters",
        table("Table 3: inertial parameters", head, rows[:INERTIAL], "even"),
        table("Table 4: friction", head, rows[INERTIAL:], "even"),
        table("The two numbers behind d<sub>ma</sub>, d<sub>s</sub> and I<sub>1</sub>", head, base, "even"),
        paragraph(swarm),
    )


def _identifiability(r):
    i = r["identifiability"]
    share = i["singular_values"][-1] / i["singular_values"][0]
    names = ("ankle_motor_com_m", "shank_com_m", "shank_inertia_kg_m2")
    rows = [[f"{published.SYMBOLS[n][0]} <span class='note'>[{_unit(n)}]</span>", number(i["truth"][n], 4),
             number(i["same_torque_leg"][n], 4)] for n in names]  # fmt: skip
    text = (
        "d<sub>ma</sub>, d<sub>s</sub> and I<sub>1</sub> are three names for two numbers, so of the paper’s"
        " ten parameters no recording of angles and currents can tell more than nine. The tenth singular"
        f" value of the regressor is {number(share, 1)} of the first, which is rounding. talus finds this"
        " from the recordings, names the three, and keeps them as near to the drawing as the data allow. The"
        " paper reports a large deviation of d<sub>ma</sub> from CAD and leaves it open: this is the cause."
    )
    drawn = figures.singular_values(i["singular_values"])
    difference = i["largest_difference_Nm"]
    same = (
        "do not differ at all in double precision"
        if difference == 0
        else f"differ by {number(difference, 1)} Nm at most"
    )
    legs = table("Two legs with the same torques", [["", "true leg", "another leg"]], rows) + paragraph(
        f"The other leg has its ankle motor {percent(100 * i['shift'], 2)} farther down. On every sample of"
        f" the unseen recording the motor torques of the two {same}."
    )
    return section("nine", "Nine of ten", paragraph(text), figure("", [drawn, legs]))


# ---- the experiment ------------------------------------------------------------------

QUANTITY_UNITS = {"position": "rad", "speed": "rad/s", "acceleration": "rad/s²", "torque": "Nm"}


def _excitation(r, series):
    e = r["excitation"]
    plans = {
        kind: [p for name, p in e["planned"].items() if name.startswith("printed") == kind]
        for kind in (False, True)
    }
    rows = []
    for joint in JOINTS:
        for quantity, unit in QUANTITY_UNITS.items():
            asked = _largest(e["asked"], joint, quantity)
            beyond = abs(asked["peak"] / asked["limit"])
            kept = max(
                abs(_largest(p["peaks"], joint, quantity)["peak"]) for ps in plans.values() for p in ps
            )
            rows.append(
                [
                    f"{joint}, {quantity} [{unit}]",
                    number(abs(asked["peak"]), 4),
                    number(abs(asked["limit"]), 3),
                    f"{number(beyond, 2)} ×" if beyond > 1 else "fits",
                    number(kept, 3),
                ]
            )
    acceleration = [abs(_largest(e["asked"], j, "acceleration")["peak"]) for j in JOINTS]
    base = sorted(p["base_hz"] for p in plans[False])
    amplitude = min(min(p["amplitude"]) for ps in plans.values() for p in ps)
    kept = "stay as printed" if amplitude > 1 - 1e-9 else f"come down to {percent(100 * amplitude)}"
    text = (
        f"(14) as printed has a base frequency of {number(e['printed_base_hz'], 2)} Hz and {e['harmonics']}"
        f" harmonics. At the joints this asks for {number(acceleration[0], 4)} and"
        f" {number(acceleration[1], 4)} rad/s², out of reach of this leg and of any like it. Scaled into the"
        f" limits, amplitudes {kept} (they fit the range of motion) and the base frequency falls to"
        f" {number(plans[True][0]['base_hz'])} Hz, {number(1 / plans[True][0]['speed'], 2)} times slower;"
        f" with other phases it may be {number(base[0])} to {number(base[-1])} Hz. No bench of this kind can"
        " run (14) as it is printed."
    )
    phases = (
        "As printed, the ankle also gets exactly half of the knee’s motion. Our three recordings and the"
        " unseen one keep the amplitudes of (14) but give each harmonic of each joint a phase of its own, so"
        " that the joints move against each other; the printed phases are kept as a second experiment."
    )
    head = [["", "(14) asks", "limit", "beyond", "as scaled, at most"]]
    return section(
        "excitation", "The excitation (14), scaled into the limits", paragraph(text), paragraph(phases),
        table("What (14) asks of the leg", head, rows),
        figure("Figure 6: two periods of the first recording, as reconstructed from its encoders",
               figures.motion(series["motion"]), JOINT_KEY),
    )  # fmt: skip


def _largest(peaks, joint, quantity):
    """The peak that is farthest out for its limit."""
    found = [p for p in peaks if p["joint"] == joint and p["quantity"] == quantity]
    return max(found, key=lambda p: abs(p["peak"]) / abs(p["limit"]))


# ---- what the print costs --------------------------------------------------------------


def _worst(deviation):
    name = max(deviation, key=lambda n: abs(deviation[n]))
    return f"{BASE_NAMES[name]} {percent(deviation[name], 3, True)}"


def _slips(r):
    s, cad = r["slips"], r["errors"]["cad"]
    rows = []
    for name, words in SLIP_NAMES.items():
        printed, drawn = s[name]["printed"], s[name]["train"]
        cells = [words]
        for of, key in (
            (printed, "same_motion_rms_Nm"),
            (printed, "other_phases_rms_Nm"),
            (drawn, "other_phases_rms_Nm"),
        ):
            cells += [milli(of[key][j]) for j in JOINTS]
        cells.append(_worst(printed["deviation_percent"]))
        rows.append({"best": cells} if name == "none" else cells)
    head = [
        [
            "",
            ("fitted and checked on (14) as printed", 'colspan="2"'),
            ("the same model, other phases", 'colspan="2"'),
            ("fitted and checked on other phases", 'colspan="2"'),
            "farthest from the truth",
        ],
        ["", *JOINTS * 3, "when fitted on (14) as printed"],
    ]
    return section(
        "slips",
        "What the slips of the print cost",
        paragraph(_slips_text(r)),
        figure(
            "RMS error of models fitted on (14) as printed",
            figures.slips(s, cad, SLIP_LABELS),
            (
                ("measured", "checked on the same motion"),
                ("residual", "checked on other phases"),
                ("nominal", "CAD values, correct equations, other phases"),
            ),
        ),
        table(
            "RMS error [mNm] with each slip alone and with all (the model file’s <code>form: paper</code>)",
            head,
            rows,
        ),
        paragraph(_slips_list(s)),
    )


def _slips_text(r):
    s, cad = r["slips"], r["errors"]["cad"]
    whole, speed = s["all"]["printed"], s["speed"]["printed"]
    reduction = [
        100 * (1 - whole["same_motion_rms_Nm"][j] / whole["same_motion_cad_rms_Nm"][j]) for j in JOINTS
    ]
    return (
        "Where the paper’s equations differ from Lagrange’s, the same recordings tell what the difference"
        " costs. Checked on the motion that they were fitted on, the printed equations look sound: the error"
        f" falls by {percent(reduction[0])} and {percent(reduction[1])} from their own CAD values, figures"
        " like the paper’s. The same model on other phases is off by"
        f" {milli(whole['other_phases_rms_Nm']['knee'])} and {milli(whole['other_phases_rms_Nm']['ankle'])}"
        f" mNm, more than the drawing’s values in the correct equations ({milli(cad['knee']['rms_Nm'])} and"
        f" {milli(cad['ankle']['rms_Nm'])}). The third slip alone is all but invisible on the printed motion"
        f" ({milli(speed['same_motion_rms_Nm']['ankle'])} mNm at the ankle, correct:"
        f" {milli(s['none']['printed']['same_motion_rms_Nm']['ankle'])}): there joint and foot turn together,"
        " and a wrong friction hides in a wrong coefficient. Other phases show it:"
        f" {milli(speed['other_phases_rms_Nm']['ankle'])} mNm."
    )


def _slips_list(s):
    whole = s["paper_form"]["printed"]["other_phases_rms_Nm"]
    return (
        "The slips: <b>velocity terms</b>, +3 I<sub>ma</sub>k<sub>a</sub>k<sub>a</sub>′θ<sub>a</sub>′² where"
        " Lagrange gives −1 (and −3 for +1 in the foot’s row): energy is not conserved without friction."
        " <b>Sign of T<sub>τf</sub></b>: the ankle’s friction acts on shank and foot in opposite directions;"
        " in print it is counted the same way in both, which puts it twice into the knee’s torque. <b>Ankle"
        " friction on the foot’s absolute speed</b>, where friction in a joint acts on the joint’s speed."
        " Inertias and frictions are kept from becoming negative; without that bound the printed equations"
        f" would ask for it. The programs, given <code>form: paper</code>, agree: {milli(whole['knee'])} and"
        f" {milli(whole['ankle'])} mNm on other phases."
    )


SETTING_NAMES = {
    "default": "default",
    "weights": "equal weights, (16) as printed",
    "paper_window": "order {order} over {length} s, as printed: across reversals",
    "paper_window_weights": "… and equal weights",
    "window": "<code>--window {order},{length}</code>: never across a stop",
    "printed": "default, on (14) with its printed phases",
}


def _settings(r):
    s = r["settings"]
    order, length = published.WINDOW
    rows = []
    for name, words in SETTING_NAMES.items():
        of = s[name]
        cells = [words.format(order=order, length=f"{length:g}")]
        for key in ("errors_own_window", "errors"):
            cells += [milli(of[key][j]["rms_Nm"]) for j in JOINTS]
        cells.append(_worst(of["deviation_percent"]))
        rows.append({"best": cells} if name == "default" else cells)
    head = [["", ("predicted with its own window", 'colspan="2"'), ("with the default window", 'colspan="2"'),
             "farthest from the truth"], ["", *JOINTS * 2, ""]]  # fmt: skip
    return section(
        "settings", "Window and weights", paragraph(_settings_text(s)),
        table("RMS error on the unseen recording [mNm]", head, rows),
    )  # fmt: skip


def _settings_text(s):
    order, seconds = s["default"]["window"]["knee"]
    ratio = {
        name: s["weights"]["base_sigma"][name] / s["default"]["base_sigma"][name]
        for name in ("foot_moment", "foot_inertia")
    }
    default, smooth = (s[name]["errors_own_window"] for name in ("default", "paper_window"))
    return (
        f"The paper smooths angles with polynomials of order {published.WINDOW[0]} over"
        f" {published.WINDOW[1]:g} s. A window that long reaches across reversals, where friction turns over"
        " at once, and smears the step into acceleration: the error grows"
        f" {number(smooth['knee']['rms_Nm'] / default['knee']['rms_Nm'], 2)}-fold at the knee and"
        f" {number(smooth['ankle']['rms_Nm'] / default['ankle']['rms_Nm'], 2)}-fold at the ankle. The default"
        f" is order {order} over {number(1e3 * seconds, 2)} ms, chosen from the data, and never reaches"
        " across a stop; held to that rule, the paper’s order is far too high for the short pieces between"
        " stops. Equal weights let the knee’s larger noise drown what the ankle knows of the foot: the"
        f" standard deviation of its moment grows {number(ratio['foot_moment'], 2)}-fold, that of its inertia"
        f" {number(ratio['foot_inertia'], 2)}-fold."
    )


# ---- the linkage -----------------------------------------------------------------------


def _linkage(r, series):
    found, drawn = r["linkage"], series["linkage"]
    reference = linkage.ankle_drive(series["models"]["cad"])
    omega = found["omega_of_published_error_1_rad"][8]
    at = {k: linkage.ratio_of(linkage.fit(reference, k, omega, omega), drawn["joint"]) / drawn["ratio"] - 1
          for k in linkage.ORDERS}  # fmt: skip
    best = found["fits"][-1]
    text = (
        "The paper takes (6) for an equation that cannot be inverted and fits a Fourier series (10) to it."
        f" It has a closed form, which talus uses; the ratio runs from {number(found['ratio_range'][0], 4)}"
        f" to {number(found['ratio_range'][1], 4)} over ±30°. How good a series is depends on its base"
        f" frequency above all: with ω = {number(best['omega_1_rad'])} order 8 leaves"
        f" {number(best['ratio_error'], 1)} of the ratio, the rounding of double precision; the paper’s"
        f" {number(published.RATIO_ERROR)} is what order 8 gives at ω = {number(omega)}. (The motor’s angle"
        " is a periodic function of the crank’s, with period 2π: ω near 1 is the natural choice.)"
    )
    key = (("residual", "order 6"), ("ankle", "order 7"), ("identified", "order 8"), ("ink", "closed form"))
    return section(
        "linkage", "The ankle’s linkage", paragraph(text),
        figure("Figure 3: the linkage and its Fourier fits", figures.linkage(found, drawn, omega, at), key,
               "Dots: the best ω of each order, as in table 2."), _coefficients(found["fits"]),
    )  # fmt: skip


def _coefficients(fits):
    def cell(values, k):
        return number(values[k], 6) if k < len(values) else ""

    rows = [["ω [1/rad]", *(number(f["omega_1_rad"], 6) for f in fits)],
            ["error of the motor angle [rad]", *(number(f["motor_error_rad"], 2) for f in fits)],
            ["error of the ratio, relative", *(number(f["ratio_error"], 2) for f in fits)]]  # fmt: skip
    rows += [[f"a<sub>{k}</sub>", *(cell(f["a"], k) for f in fits)] for k in range(len(fits[-1]["a"]))]
    rows += [[f"b<sub>{k + 1}</sub>", *(cell(f["b"], k) for f in fits)] for k in range(len(fits[-1]["b"]))]
    head = [["", *(f"order {f['order']}" for f in fits)]]
    return table("Table 2: the best series over ±30° [rad]", head, rows, "coefficients")


# ---- how -------------------------------------------------------------------------------


def _making(r):
    bench, rows = r["bench"], len(r["excitation"]["planned"])
    spread = {name: f"{number(50 * s, 1)} to {number(100 * s, 2)} %" for name, s in bench["spread"].items()}
    noise = " and ".join(f"{1e3 * x:g}" for x in bench["current_noise_A"])
    return section(
        "making",
        "How this page was made",
        paragraph(
            f"<code>make paper</code>, talus {r['version']}. The leg as drawn (CAD) is"
            " <code>models/leg.yaml</code>; the leg as built differs by a seeded draw: centres of mass by"
            f" {spread['com_m']}, inertias by {spread['inertia_kg_m2']}, frictions by {spread['coulomb_Nm']},"
            f" up or down. {rows} recordings of {number(r['seconds'], 3)} s at"
            f" {number(bench['sample_hz'], 3)} Hz come from the bench twin: position control at"
            f" {number(bench['control_hz'] / 1e3, 1)} kHz, friction that sticks, encoders of"
            f" {number(bench['encoder_bits'][0], 2)} bits, noise of {noise} mA on the currents, sampling"
            f" jitter of ±{milli(bench['jitter_s'], 1)} ms. <code>talus-identify</code> sees three of them,"
            " <code>talus-predict</code> the angles of the fourth. Errors are scored as every command scores"
            " them. Recordings, models and reports lie beside this page."
        ),
    )
