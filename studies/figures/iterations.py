"""How many steps? Error of the coefficients after k steps, 4 bands, and of the converged field.

From the study `iterations`. Open markers: the paper's heuristic of 2 N steps (Kaplanyan &
Dachsbacher 2010, 3.3). Bars at the right edge: the converged field. Filled markers: the least
error on the way. Where that is below the bar, a run that is stopped early hides the scheme's own
error behind light that has not arrived yet.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.figures.curves import (
    draw_curves,
    least,
    legend_above,
    panels,
    plain_log,
    present,
    scheme_entries,
)
from studies.figures.workshop import Workshop, good_rows
from studies.style import Style, line_of

PARTS = ("rows",)
#: Steps of the bars that stand for the converged field.
_END = (1800, 3500)


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    rows = workshop.study("iterations")
    most = int(rows["bands"].max())
    return {"rows": good_rows(rows, bands=most)}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    scenes = present(rows, "scene")
    figure, grid = panels(len(scenes), sharex=True)
    for axes, scene in zip(grid, scenes):
        _draw(axes, rows.isel(row=rows["scene"].values == scene))
        axes.set_title(str(scene).partition(":")[0])
    figure.supxlabel("steps k", fontsize=7)
    figure.supylabel("error of the coefficients, relative L2", fontsize=7)
    plain: Style = {"linestyle": "", "color": "black", "markersize": 3.5}
    signs = [
        Line2D([], [], marker="o", markerfacecolor="white", label="2 N steps", **plain),
        Line2D([], [], marker="o", label="least", **plain),
        Line2D([], [], color="black", linewidth=1.6, label="converged"),
    ]
    legend_above(figure, [*scheme_entries(present(rows, "propagator"), False), *signs], 3)
    return {"": figure}


def _draw(axes: Axes, rows: xr.Dataset) -> None:
    stepped = rows.isel(row=(rows["stop"].values == "steps") & (rows["iterations"].values > 0))
    draw_curves(axes, stepped, "iterations", "coefficients", marker="")
    for name in present(rows, "propagator"):
        line = line_of(str(name))
        mark: Style = {
            "marker": line.marker,
            "markersize": 4,
            "color": line.colour,
            "linestyle": "",
        }
        own = stepped.isel(row=stepped["propagator"].values == name)
        lowest, heuristic = least(own, "coefficients"), own.isel(row=own["heuristic"].values)
        axes.plot(lowest["iterations"], lowest["coefficients"], **mark)
        hollow: Style = {**mark, "markerfacecolor": "white", "markeredgewidth": 0.7}
        axes.plot(heuristic["iterations"], heuristic["coefficients"], **hollow)
        ends = (rows["stop"].values == "converged") & (rows["propagator"].values == name)
        for value in rows["coefficients"].values[ends]:
            axes.plot(_END, [value, value], color=line.colour, linewidth=1.6, clip_on=False)
    plain_log(axes, [1, 10, 100, 1000], "x")
    axes.set_ylim(0, 1.05 * float(np.nanmax(rows["coefficients"].values)))
