"""The page's results: predicted torques, identified parameters, and what of them can be identified."""

from . import figures, published
from .bench import JOINTS
from .markup import figure, number, paragraph, percent, section, table

INERTIAL = 6  # of the ten parameters; the others are frictions
UNITS = {"kg_m2": "kg m²", "Nms_rad": "Nm s/rad", "Nm": "Nm", "m": "m"}
TORQUE_KEY = (("measured", "measured"), ("nominal", "CAD values"), ("identified", "identified"))


def prediction(r, series):
    """Figures 7 and 8."""
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


def _within(r):
    base, truth = r["identification"]["base_parameters"], r["models"]["truth"]["base"]
    inside = sum(abs(of["value"] - truth[name]) <= 3 * of["sigma"] for name, of in base.items())
    return f"{inside} of the {len(base)}"


def _row(label, of, cad, truth):
    """A parameter as identified (value, sigma; no sigma where it cannot be), beside CAD and truth."""
    return [
        label,
        number(cad, 4),
        number(of["value"], 4),
        number(of["sigma"], 2) if of["sigma"] else ("not identifiable", 'class="none"'),
        number(truth, 4),
        percent(100 * (of["value"] / cad - 1), 3, True),
        percent(100 * (of["value"] / truth - 1), 2, True),
        number((of["value"] - truth) / of["sigma"], 2) if of["sigma"] else ("–", 'class="none"'),
    ]


def _parameter_rows(r):
    truth, rows = r["models"]["truth"]["parameters"], []
    for name, of in r["identification"]["parameters"].items():
        symbol, words = published.SYMBOLS[name]
        rows.append(
            _row(f"{symbol} <span class='note'>{words} [{_unit(name)}]</span>", of, of["prior"], truth[name])
        )
    return rows


def _base_rows(r):
    """The two base parameters that stand behind the three which no recording tells apart."""
    truth, cad, found = r["models"]["truth"]["base"], r["models"]["cad"]["base"], r["identification"]
    moment = "m<sub>s</sub>d<sub>s</sub> + m<sub>m</sub>d<sub>ma</sub> <span class='note'>[kg m]</span>"
    inertia = (
        "I<sub>1</sub> + m<sub>s</sub>d<sub>s</sub>² + m<sub>m</sub>d<sub>ma</sub>² <span class='note'>[kg"
        " m²]</span>"
    )
    return [
        _row(formula, found["base_parameters"][name], cad[name], truth[name])
        for name, formula in (("shank_inertia", inertia), ("shank_moment", moment))
    ]


def parameters(r):
    """Tables 3 and 4."""
    i, rows = r["identification"], _parameter_rows(r)
    head = [["", "CAD", "identified", "σ", "truth", "from CAD", "from truth", "in σ"]]
    excess = max(abs(i["cost"] / i["least_squares_cost"] - 1), 1e-15)
    swarm = (
        f"The swarm ended within {number(excess, 1)} (relative) of linear least squares after"
        f" {i['evaluations']:,} evaluations; the regressor’s condition number is"
        f" {number(i['condition_number'])}. σ is the standard deviation that talus reports; {_within(r)} base"
        " parameters lie within 3 σ of the truth. σ counts noise; beyond it lies what is systematic, here"
        " mainly the acceleration as a window reads it from encoders at this rate."
    )
    return section(
        "parameters",
        "Identified parameters",
        table("Table 3: inertial parameters", head, rows[:INERTIAL], "even"),
        table("Table 4: friction", head, rows[INERTIAL:], "even"),
        table(
            "The two numbers behind d<sub>ma</sub>, d<sub>s</sub> and I<sub>1</sub>",
            head,
            _base_rows(r),
            "even",
        ),
        paragraph(swarm),
    )


def identifiability(r):
    """Three names for two numbers."""
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
