"""The ankle's linkage and its Fourier series: figure 3 and table 2."""

from . import figures, published
from . import linkage as series_of
from .markup import figure, number, paragraph, section, table


def linkage(r, series):
    """Figure 3 and table 2."""
    found, drawn = r["linkage"], series["linkage"]
    reference = series_of.ankle_drive(series["models"]["cad"])
    omega = found["omega_of_published_error_1_rad"][8]
    at = {
        k: series_of.ratio_of(series_of.fit(reference, k, omega, omega), drawn["joint"]) / drawn["ratio"] - 1
        for k in series_of.ORDERS
    }
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
        "linkage",
        "The ankle’s linkage",
        paragraph(text),
        figure(
            "Figure 3: the linkage and its Fourier fits",
            figures.linkage(found, drawn, omega, at),
            key,
            "Dots: the best ω of each order, as in table 2.",
        ),
        _coefficients(found["fits"]),
    )


def _coefficients(fits):
    def cell(values, k):
        return number(values[k], 6) if k < len(values) else ""

    rows = [
        ["ω [1/rad]", *(number(f["omega_1_rad"], 6) for f in fits)],
        ["error of the motor angle [rad]", *(number(f["motor_error_rad"], 2) for f in fits)],
        ["error of the ratio, relative", *(number(f["ratio_error"], 2) for f in fits)],
    ]
    rows += [[f"a<sub>{k}</sub>", *(cell(f["a"], k) for f in fits)] for k in range(len(fits[-1]["a"]))]
    rows += [[f"b<sub>{k + 1}</sub>", *(cell(f["b"], k) for f in fits)] for k in range(len(fits[-1]["b"]))]
    head = [["", *(f"order {f['order']}" for f in fits)]]
    return table("Table 2: the best series over ±30° [rad]", head, rows, "coefficients")
