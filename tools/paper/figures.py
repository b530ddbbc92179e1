"""The page's figures as small SVG panels: two beside each other on a screen, one on a phone.

Colours are written as the page's CSS variables, text stays text.
"""

import io
import re

import matplotlib

matplotlib.use("svg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy  # noqa: E402

from . import published  # noqa: E402
from .bench import JOINTS  # noqa: E402

SIZE = (4.6, 2.4)  # inches
MILLI = 1e3
EXCERPT_S = 6.0  # of figures 7 and 8
FROM_S = 10.0  # where excerpts begin, in recordings that last so long

# a colour's role on the page; the drawing's hexadecimal stands for the CSS variable of that name
ROLE = {
    "ink": "#1b1f24",
    "line": "#d8dee4",
    "measured": "#9aa4ae",
    "nominal": "#9a6700",
    "identified": "#0969da",
    "knee": "#8250df",
    "ankle": "#1a7f37",
    "residual": "#bc4c00",
    "quiet": "#59636e",
}

STYLE = {
    "svg.fonttype": "none",
    "svg.hashsalt": "talus",
    "font.size": 8.5,
    "font.family": "DejaVu Sans",
    "axes.edgecolor": ROLE["line"],
    "axes.labelcolor": ROLE["ink"],
    "text.color": ROLE["ink"],
    "xtick.color": ROLE["line"],
    "ytick.color": ROLE["line"],
    "xtick.labelcolor": ROLE["ink"],
    "ytick.labelcolor": ROLE["ink"],
    "axes.grid": True,
    "grid.color": ROLE["line"],
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.1,
    "axes.axisbelow": True,
    "axes.titlesize": 8.5,
    "axes.titlelocation": "left",
    "figure.constrained_layout.use": True,
    "path.simplify": True,
    "path.simplify_threshold": 0.3,
}


def draw(name, title, draw_into, size=SIZE):
    """One panel as inline SVG; `draw_into` is given its axes."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=size)
        draw_into(axes)
        axes.set_title(title)
        out = io.StringIO()
        figure.savefig(out, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
        plt.close(figure)
    return _inline(out.getvalue(), name, title)


def _inline(svg, name, title):
    """The drawing as part of a page: no prologue, names of its own, the page's colours and fonts."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(
        r'<svg [^>]*viewBox="([^"]*)"[^>]*>',
        rf'<svg viewBox="\1" role="img" aria-label="{title}">',
        svg,
        count=1,
    )
    svg = re.sub(r'\b(id="|url\(#|xlink:href="#)', rf"\g<1>{name}-", svg).replace("xlink:href", "href")
    for role, colour in ROLE.items():
        svg = svg.replace(colour, f"var(--{role})")
    svg = svg.replace("'DejaVu Sans'", "system-ui, sans-serif")
    return re.sub(r"\n\s*", "\n", svg)


def excerpt(t, length_s):
    """Begin and end of what a figure shows of a recording."""
    begin = FROM_S if t[-1] >= FROM_S + length_s else 0.0
    return begin, begin + length_s


def lines(x, curves, x_label, y_label, scale=1.0):
    """A drawing of curves [(role, values)] over one x."""

    def into(axes):
        for role, values in curves:
            axes.plot(x, scale * values, color=ROLE[role], linewidth=2.6 if role == "measured" else 1.1)
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
        axes.margins(x=0)

    return into


# ---- the linkage: figure 3 -----------------------------------------------------------


def linkage(results, series, omega, series_at_omega):
    """Motor angle, ratio, the series' errors over the angle, and their largest against omega."""
    degrees = numpy.degrees(series["joint"])
    roles = dict(zip(series["error"], ("residual", "ankle", "identified")))

    def against_omega(axes):
        for order, error in series["error"].items():
            axes.semilogy(series["omega"], error, color=ROLE[roles[order]])
        for fit in results["fits"]:
            axes.plot(
                fit["omega_1_rad"], fit["ratio_error"], "o", color=ROLE[roles[fit["order"]]], markersize=4
            )
        axes.axhline(published.RATIO_ERROR, color=ROLE["ink"], linewidth=0.8, linestyle=(0, (4, 3)))
        axes.set_xlabel("base frequency ω [1/rad]")
        axes.set_ylabel("largest error")
        axes.margins(x=0.02)
        axes.text(0.02, published.RATIO_ERROR * 2.5, "the paper’s", transform=axes.get_yaxis_transform())

    errors = [(roles[order], curve) for order, curve in series_at_omega.items()]
    return [
        draw("f3a", "motor angle", lines(degrees, [("ink", series["motor"])], "joint angle [°]", "[rad]")),
        draw("f3b", "ratio", lines(degrees, [("ink", series["ratio"])], "joint angle [°]", "[rad/rad]")),
        draw(
            "f3c",
            f"relative error of the ratio at ω = {omega:.3g}",
            lines(degrees, errors, "joint angle [°]", "[10⁻³]", MILLI),
        ),
        draw("f3d", "largest relative error of the ratio against ω", against_omega),
    ]


# ---- figure 6 ------------------------------------------------------------------------


def motion(series, periods=2):
    """Angles, speeds, accelerations and torques of both joints over some periods."""
    begin, end = excerpt(series["t"], periods * series["period_s"])
    out = []
    for name, key, title, unit in (
        ("f6a", "q", "joint angle", "rad"),
        ("f6b", "v", "joint speed", "rad/s"),
        ("f6c", "a", "joint acceleration", "rad/s²"),
        ("f6d", "torque", "motor torque", "mNm"),
    ):
        t = series["torque_t"] if key == "torque" else series["t"]
        shown = (t >= begin) & (t <= end)
        curves = [(joint, series[key][j][shown]) for j, joint in enumerate(JOINTS)]
        scale = MILLI if key == "torque" else 1.0
        out.append(draw(name, title, lines(t[shown], curves, "time [s]", f"[{unit}]", scale)))
    return out


# ---- figures 7 and 8 -----------------------------------------------------------------


def torque(series, joint):
    """Measured, CAD and identified motor torque of one joint, and the two errors."""
    j, t = JOINTS.index(joint), series["t"]
    begin, end = excerpt(t, EXCERPT_S)
    shown = (t >= begin) & (t <= end)
    measured, kept = series["measured"][j], series["kept"][j]
    torques = [("measured", measured), ("nominal", series["cad"][j]), ("identified", series["identified"][j])]
    errors = [(role, numpy.where(kept, measured - values, numpy.nan)) for role, values in torques[1:]]
    number = 7 + j
    return [
        draw(f"f{number}a", f"{joint}: motor torque",
             lines(t[shown], [(r, v[shown]) for r, v in torques], "time [s]", "[mNm]", MILLI)),
        draw(f"f{number}b", f"{joint}: measured − predicted",
             lines(t[shown], [(r, v[shown]) for r, v in errors], "time [s]", "[mNm]", MILLI)),
    ]  # fmt: skip


# ---- slips and identifiability --------------------------------------------------------


def slips(results, cad, labels):
    """For each joint: the error that each slip leaves on the motion it was fitted on, and on other phases."""

    def into(joint):
        def dots(axes):
            for y, name in enumerate(reversed(labels)):
                of = results[name]["printed"]
                own, other = (MILLI * of[key][joint] for key in ("same_motion_rms_Nm", "other_phases_rms_Nm"))
                axes.plot([own, other], [y, y], color=ROLE["line"], linewidth=2, zorder=1)
                axes.plot(own, y, "o", color=ROLE["measured"], markersize=6)
                axes.plot(other, y, "o", color=ROLE["residual"], markersize=6)
            axes.axvline(
                MILLI * cad[joint]["rms_Nm"], color=ROLE["nominal"], linewidth=1, linestyle=(0, (4, 3))
            )
            axes.set_xscale("log")
            axes.set_yticks(range(len(labels)), list(labels.values())[::-1])
            axes.grid(axis="y", visible=False)
            axes.xaxis.set_major_formatter("{x:g}")
            axes.set_xlabel("RMS error [mNm]")
            axes.set_ylim(-0.6, len(labels) - 0.4)

        return dots

    return [draw(f"slip{joint}", joint, into(joint)) for joint in JOINTS]


def singular_values(values):
    """The ten singular values of the regressor over the ten physical parameters."""

    def into(axes):
        share = numpy.array(values) / values[0]
        roles = ["identified"] * (len(share) - 1) + ["residual"]
        axes.bar(range(1, len(share) + 1), share, color=[ROLE[role] for role in roles], width=0.6, log=True)
        axes.set_ylim(1e-18, 10)
        axes.set_xticks(range(1, len(share) + 1))
        axes.grid(axis="x", visible=False)
        axes.set_xlabel("singular value")
        axes.set_ylabel("share of the largest")

    return draw("singular", "what the recordings see of ten parameters", into)
