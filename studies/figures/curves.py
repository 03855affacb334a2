"""Panels of curves: one panel per scene, one curve per scheme."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import (
    FixedLocator,
    FormatStrFormatter,
    LogLocator,
    NullFormatter,
    NullLocator,
)

from studies.style import COLUMN, curve_style

#: Height over width of a panel.
_ASPECT = 0.72
#: Room for axis labels and title of a panel, and for the legend above all [inch].
_LABELS, _LEGEND = 0.32, 0.3


def panels(
    count: int, columns: int = 2, width: float = COLUMN, legend: float = _LEGEND, **shared: Any
) -> tuple[Figure, list[Axes]]:
    """A figure with `count` panels, row by row, a column wide."""
    columns = min(columns, count)
    rows = -(-count // columns)
    height = rows * (_ASPECT * (width / columns - 0.25) + _LABELS) + legend
    figure = Figure(figsize=(width, height), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False, **shared)
    for spare, above in zip(grid.flat[count:], grid.flat[count - columns :]):
        spare.remove()
        above.tick_params(labelbottom=True)
    return figure, list(grid.flat[:count])


def draw_curves(
    axes: Axes, rows: xr.Dataset, across: str, up: str, by: str = "propagator", **style: Any
) -> None:
    """One curve for each value of the column `by`, points in the order of `across`."""
    for name in dict.fromkeys(rows[by].values.tolist()):
        own = rows.isel(row=rows[by].values == name).sortby(across)
        scheme = str(own["propagator"].values[0])
        axes.plot(own[across].values, own[up].values, **{**curve_style(scheme), **style})


def scheme_entries(names: Sequence[str], marked: bool = True) -> list[Line2D]:
    """Handles for a legend of schemes."""
    return [Line2D([], [], label=name.upper(), **curve_style(name, marked)) for name in names]


def legend_above(figure: Figure, entries: Sequence[Any], columns: int | None = None) -> None:
    """One legend for all panels."""
    figure.legend(handles=list(entries), loc="outside upper center", ncols=columns or len(entries))


def whole_ticks(axes: Axes, values: Sequence[int], which: str = "x") -> None:
    """Ticks at these values and nowhere else, written as whole numbers."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_major_locator(FixedLocator([float(value) for value in values]))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FormatStrFormatter("%d"))


def plain_log(axes: Axes, ticks: Sequence[float], which: str = "y") -> None:
    """A logarithmic axis with few ticks, written as plain numbers."""
    getattr(axes, f"set_{which}scale")("log")
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_major_locator(FixedLocator(list(ticks)))
    axis.set_major_formatter(FormatStrFormatter("%g"))
    axis.set_minor_formatter(NullFormatter())


def log_seconds(axes: Axes) -> None:
    """A logarithmic axis of run times, 1 and 3 of each power of ten written as plain numbers."""
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0), numticks=20))
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def present(rows: xr.Dataset, column: str) -> list[Any]:
    """Values of a column in their first order."""
    return list(dict.fromkeys(rows[column].values.tolist()))


def least(rows: xr.Dataset, column: str) -> xr.Dataset:
    """The row with the smallest value."""
    return rows.isel(row=int(np.nanargmin(rows[column].values)))
