"""Does accuracy come with angular resolution? Error by number of bands, over the floor.

From the study `bands`: converged fields, exact blocking. The grey area holds errors that no field
with so many bands can have: the exact intensity, projected. Parallel light has no intensity over
angle, so that the atrium shows in the second figure only, which compares coefficients and has no
floor.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from studies.figures.curves import (
    draw_curves,
    legend_above,
    panels,
    present,
    scheme_entries,
    whole_ticks,
)
from studies.figures.workshop import Workshop, good_rows

PARTS = ("rows",)
_FLOOR = "#d8d8d8"


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    return {"rows": workshop.study("bands")}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = good_rows(data["rows"])
    seen = rows.isel(row=np.isfinite(rows["angular"].values))
    return {
        "angular": _draw(seen, "angular", "error over all directions"),
        "coefficients": _draw(rows, "coefficients", "error of the coefficients"),
    }


def _draw(rows: xr.Dataset, measure: str, label: str) -> Figure:
    scenes = present(rows, "scene")
    figure, grid = panels(len(scenes), sharex=True)
    for axes, scene in zip(grid, scenes):
        own = rows.isel(row=rows["scene"].values == scene)
        if measure == "angular":
            _floor(axes, own)
        draw_curves(axes, own, "bands", measure)
        axes.set_title(scene)
        axes.set_ylim(0, min(2.0, 1.05 * float(own[measure].max())))
        whole_ticks(axes, present(rows, "bands"))
    figure.supxlabel("bands n", fontsize=7)
    figure.supylabel(f"{label}, relative L2", fontsize=7)
    entries = scheme_entries(present(rows, "propagator"))
    floor = [Patch(color=_FLOOR, label="below the floor")] if measure == "angular" else []
    legend_above(figure, [*entries, *floor])
    return figure


def _floor(axes: Axes, rows: xr.Dataset) -> None:
    lowest = rows.isel(row=rows["propagator"].values == rows["propagator"].values[0])
    lowest = lowest.sortby("bands")
    axes.fill_between(lowest["bands"], lowest["floor"], color=_FLOOR, linewidth=0)
