"""What results need besides NumPy where they are asked for a data frame or a picture, and how they draw.

Both are extras of the package: who does without them need not install them.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from ._arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

COLOURS = {"measured": "0.25", "predicted": "tab:blue", "nominal": "tab:brown", "identified": "tab:blue",
           "extended": "tab:green", "noise": "tab:purple"}  # fmt: skip
WIDTH, HEIGHT = 5.0, 2.4  # of one plot, in inches


def _extra(module: str, extra: str) -> Any:
    """A module of an extra; ImportError says in one line how to get it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.split(".")[0]
        raise ImportError(f"{package} is not there; pip install {package}, or 'talus[{extra}]'", name=package) from None


def frame(columns: Mapping[str, Any], index: Iterable[str] | None = None) -> DataFrame:
    """The columns as a pandas data frame."""
    table: DataFrame = _extra("pandas", "frame").DataFrame(dict(columns), index=index)
    return table


def joined(frames: Iterable[DataFrame]) -> DataFrame:
    """Data frames one below the other."""
    table: DataFrame = _extra("pandas", "frame").concat(list(frames), ignore_index=True)
    return table


def axes(rows: int, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """(figure, array of its rows x columns plots)."""
    pyplot = _extra("matplotlib.pyplot", "plot")
    size = (WIDTH * (1 + columns), HEIGHT * rows)
    figure, plots = pyplot.subplots(rows, columns, squeeze=False, layout="constrained", figsize=size, **options)
    return figure, plots


def lines(plot: Any, t: Array, series: Mapping[str, Array], y_label: str) -> None:
    """Series over time in one plot; each name has the same colour in every picture."""
    for name, values in series.items():
        plot.plot(t, values, label=name, linewidth=0.8, color=COLOURS.get(name))
    plot.set_ylabel(y_label)
    plot.grid(True, alpha=0.3)
    if len(series) > 1:
        plot.legend(loc="upper right", fontsize="small")


def over_residuals(plots: Any, t: Array, series: Mapping[str, Array], residuals: Mapping[str, Array], label: str, unit: str) -> None:
    """Two plots, one below the other: measured with predicted, and what is left."""
    lines(plots[0], t, series, f"{label} [{unit}]")
    lines(plots[1], t, residuals, f"residual [{unit}]")
    plots[1].set_xlabel("time [s]")
