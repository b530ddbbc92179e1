"""What the paper's choices cost: its excitation, the slips of its print, its window and weights."""

from . import figures, published
from .bench import JOINTS
from .markup import figure, milli, number, paragraph, percent, section, table

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
JOINT_KEY = (("knee", "knee"), ("ankle", "ankle"))


# ---- the experiment ------------------------------------------------------------------

QUANTITY_UNITS = {"position": "rad", "speed": "rad/s", "acceleration": "rad/s²", "torque": "Nm"}


def excitation(r, series):
    """What (14) asks for, what is left of it, and figure 6."""
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


def slips(r):
    """Each slip of the printed equations, on the motion that hides it and on others."""
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
        " Inertias and frictions are kept from becoming negative; −100 % is a friction at that bound. The"
        f" programs, given <code>form: paper</code>, agree with the last row: {milli(whole['knee'])} and"
        f" {milli(whole['ankle'])} mNm on other phases."
    )


SETTING_NAMES = {
    "default": "default",
    "weights": "equal weights, (16) as printed",
    "paper_window": "order {order} over {length} s, as printed: across reversals",
    "paper_window_weights": "… and equal weights",
    "window": "<code>--window {order},{length}</code> of the command: across stops too",
    "printed": "default, on (14) with its printed phases",
}


def settings(r):
    """Smoothing window and weights."""
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
        " across a stop; a window set by hand does, as the paper’s. Equal weights let the knee’s larger noise drown what the ankle knows of the foot: the"
        f" noise's part in the standard deviation of its moment grows {number(ratio['foot_moment'], 2)}-fold, that of its inertia"
        f" {number(ratio['foot_inertia'], 2)}-fold."
    )
