"""The page: what the experiment found, in words, tables and figures. Every number comes from `results`."""

from pathlib import Path

from . import page_costs, page_linkage, page_results, published
from .bench import JOINTS
from .markup import milli, number, paragraph, percent, section, table

ROOT = Path(__file__).resolve().parents[2]


def write(path, results, series):
    """The whole page into one file that needs no other."""
    css = (ROOT / "apps/page/assets/page.css").read_text(encoding="utf-8")
    css += (Path(__file__).parent / "paper.css").read_text(encoding="utf-8")
    parts = [
        _opening(results),
        page_results.prediction(results, series),
        page_results.parameters(results),
        page_results.identifiability(results),
        page_costs.excitation(results, series),
        page_costs.slips(results),
        page_costs.settings(results),
        page_linkage.linkage(results, series),
        _making(results),
    ]
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


# ---- how -----------------------------------------------------------------------------


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
