"""A report as one HTML page that needs nothing besides itself: the programs' own template, from Python.

    page = talus.Page("Prediction of unseen.csv", "The model explains the knee to 1.8 %.")
    page.table("RMS residual", ["joint", "as given", "identified"], [["knee", "4.9 mNm", "1.0 mNm"]])
    page.chart("knee", "time [s]", "torque [Nm]", [("measured", "measured", t, measured)],
               below=("residual [Nm]", [("identified", "residual", t, residual)]))
    page.write("unseen.html")

A series is (name, role, x, y), NaN in y is a gap; the role decides the colour: measured, predicted, residual,
nominal, identified, extended, noise, accent.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from html import escape
from pathlib import Path
from typing import Any

Series = tuple[str, str, Iterable[float], Iterable[float]]
_PACKED = Path(__file__).resolve().parent / "_native" / "assets"  # of an installed package
_ASSETS = _PACKED if _PACKED.is_dir() else Path(__file__).resolve().parents[2] / "apps" / "page" / "assets"
BAR_REM, AXIS_REM = 2.4, 3.6  # heights of a bar with a label of two lines, and of the axis beneath
_CHART_LIBRARY = [
    folder / name for folder in (_PACKED, Path("/usr/share/javascript/chart.js")) for name in ("chart.min.js", "Chart.min.js")
]


class Page:
    """Parts in the order in which they are added; texts are plain text and are escaped here.

    >>> page = talus.Page("Monday", "The knee is explained to 1.8 %.")
    >>> page.table("RMS residual", ["joint", "identified"], [["knee", "1.0 mNm"]])
    >>> page.write("monday.html")
    """

    def __init__(self, title: str, sentence: str) -> None:
        self.title = title
        self._body = [f"<h1>{escape(title)}</h1>\n", f'<p class="lead">{escape(sentence)}</p>\n']
        self._charts: list[dict[str, Any]] = []

    def heading(self, text: str) -> None:
        """A heading within the page.

        >>> talus.Page("Monday", "Two joints.").heading("Knee")
        """
        self._body.append(f"<h2>{escape(text)}</h2>\n")

    def paragraph(self, text: str) -> None:
        """Running text.

        >>> talus.Page("Monday", "Two joints.").paragraph("The bench was warm: its gears had run for an hour.")
        """
        self._body.append(f"<p>{escape(text)}</p>\n")

    def steps(self, steps: Iterable[tuple[str, str | None]]) -> None:
        """A numbered list of what to do, each with its command or None.

        >>> page = talus.Page("Monday", "Record once more.")
        >>> page.steps([("Warm the gears up.", None), ("Fit again.", "talus-identify --model arm.yaml --out fitted.yaml new.csv")])
        """
        items = "".join(f"<li>{escape(what)}{_code(command) if command else ''}</li>\n" for what, command in steps)
        self._body.append(f"<ol>\n{items}</ol>\n")

    def code(self, caption: str, text: str) -> None:
        """Lines as they stand, as of a file or of a patch.

        >>> talus.Page("Monday", "One model.").code("model.yaml", open("models/pendulum.yaml").read())
        """
        self._body.append(f"<figure>\n<figcaption>{escape(caption)}</figcaption>\n{_code(text)}</figure>\n")

    def table(self, caption: str, columns: Sequence[str], rows: Iterable[Sequence[str]], words: bool = False) -> None:
        """A table whose first column names the rows, of figures or of words.

        >>> page = talus.Page("Monday", "Two joints.")
        >>> page.table("RMS residual", ["joint", "as given", "identified"], [["knee", "4.9 mNm", "1.0 mNm"], ["ankle", "3.1 mNm", "0.9 mNm"]])
        """
        head = "".join(f'<th scope="col">{escape(text)}</th>' for text in columns)
        body = "".join(
            f'<tr><th scope="row">{escape(first)}</th>' + "".join(f"<td>{escape(text)}</td>" for text in rest) + "</tr>\n"
            for first, *rest in rows
        )
        kind = ' class="words"' if words else ""
        self._body.append(f'<div class="wide"><table{kind}>\n<caption>{escape(caption)}</caption>\n<thead><tr>{head}</tr>'
                          f"</thead>\n<tbody>\n{body}</tbody></table></div>\n")  # fmt: skip

    def chart(self, title: str, x_label: str, y_label: str, series: Iterable[Series],
              below: tuple[str, Iterable[Series]] | None = None) -> None:
        """Lines over x; `below` is (y label, series) of a lower chart on the same x axis.

        >>> panel = talus.panels({"as given": talus.read("models/pendulum.yaml")}, talus.read("arm.csv"))[0]
        >>> page = talus.Page("Monday", "One joint.")
        >>> page.chart("joint", "time [s]", "torque [Nm]", [("measured", "measured", panel.t, panel.measured)],
        ...            below=("residual [Nm]", [("as given", "residual", panel.t, panel.residual("as given"))]))
        """
        chart = self._chart(title, x_label, y_label, series)
        plots = [("tall joined" if below else "lines", y_label)]
        if below:
            chart["below"] = self._chart(title, x_label, *below)
            plots.append(("low", below[0]))
        self._charts.append(chart)
        canvases = "".join(
            f'<div class="plot {height}"><canvas role="img" aria-label="{escape(f"{title}: {label}")}"></canvas></div>\n'
            for height, label in plots
        )
        self._body.append(f"<figure>\n<figcaption>{escape(title)}</figcaption>\n{canvases}</figure>\n")

    def bars(self, title: str, x_label: str, labels: Sequence[str | list[str]], values: Sequence[float],
             roles: Sequence[str] | None = None) -> None:
        """Horizontal bars from zero, one a label (a list is a label of several lines), each in its role's colour.

        >>> page = talus.Page("Monday", "Most of the gap is closed.")
        >>> page.bars("knee", "RMS residual [Nm]", ["as given", ["identified", "(held out)"]], [0.31, 0.05], ["nominal", "identified"])
        """
        bars = {"form": "bars", "title": title, "x": x_label, "y": "", "labels": labels, "values": values, "series": []}
        if roles:
            bars["roles"] = roles
        self._charts.append(bars)
        height = BAR_REM * len(labels) + AXIS_REM
        self._body.append(f"<figure>\n<figcaption>{escape(title)}</figcaption>\n"
                          f'<div class="plot" style="height: {height:g}rem">'
                          f'<canvas role="img" aria-label="{escape(title)}"></canvas></div>\n'
                          "</figure>\n")  # fmt: skip

    @contextmanager
    def side_by_side(self) -> Iterator[None]:
        """What is added within stands side by side where there is room.

        >>> page = talus.Page("Monday", "Two joints.")
        >>> with page.side_by_side():
        ...     page.bars("knee", "RMS residual [Nm]", ["identified"], [0.05])
        ...     page.bars("ankle", "RMS residual [Nm]", ["identified"], [0.04])
        """
        self._body.append('<div class="columns">\n')
        yield
        self._body.append("</div>\n")

    @staticmethod
    def _chart(title: str, x_label: str, y_label: str, series: Iterable[Series]) -> dict[str, Any]:
        lines = [{"name": name, "role": role, "t": [_number(value) for value in x], "y": [_number(value) for value in y]}
                 for name, role, x, y in series]  # fmt: skip
        return {"form": "lines", "title": title, "x": x_label, "y": y_label, "series": lines}

    def write(self, path: str | Path) -> None:
        """Writes the page; `tools/setup build` installs the chart library that it carries.

        >>> talus.Page("Monday", "The knee is explained to 1.8 %.").write("monday.html")
        >>> "explained to 1.8 %" in open("monday.html").read()
        True
        """
        library = next((file for file in _CHART_LIBRARY if file.exists()), None)
        if library is None:
            raise FileNotFoundError(f"{_CHART_LIBRARY[-2]} is not there; run tools/setup build")
        places = {
            "title": escape(self.title),
            "style": (_ASSETS / "page.css").read_text(encoding="utf-8"),
            "body": "".join(self._body),
            "data": json.dumps(self._charts, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
            "library": library.read_text(encoding="utf-8"),
            "script": (_ASSETS / "page.js").read_text(encoding="utf-8"),
        }
        text = (_ASSETS / "page.html").read_text(encoding="utf-8")
        pieces = text.split("{{")
        filled = pieces[0] + "".join(places[place] + rest for place, rest in (p.split("}}", 1) for p in pieces[1:]))
        Path(path).write_text(filled, encoding="utf-8")


def _code(text: str) -> str:
    return f'<pre class="wide">{escape(text)}</pre>\n'


def _number(x: float) -> float | None:
    """With nine digits; None for NaN, a gap."""
    return None if math.isnan(x) else float(f"{x:.9g}")
