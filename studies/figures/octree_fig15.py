"""Figure 15 of the octree thesis: its errors after each iteration, and what they do not tell.

From the study `levels`: a grid of 32², as large as the thesis' octree, all levels, its propagator
(gain 0.75 a step) and LPV that conserves flux. Above, e_abs and e_rel as printed (6.2) and with
the elements counted right: levels against their own children. Below, what section 7 of the thesis
asks for: the merged field against the converged uniform grid.
"""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.figures.curves import legend_above, present
from studies.figures.stability import short_name
from studies.figures.workshop import Workshop, good_rows
from studies.kinds.level_history import MERGED
from studies.style import COLUMN

PARTS = ("rows",)
SCENE = "clutter:size=32,occluders=0"
_PANELS = {
    "printed_absolute": "$e_{abs}$ as printed [W/rad]",
    "printed_relative": "$e_{rel}$ as printed",
    "corrected_relative": "$e_{rel}$, counted right",
    "coefficients": "merged, true error",
}
_STYLES: tuple[Any, ...] = (("#d55e00", "-"), ("#0072b2", (0, (4, 1.5))), ("#009e73", (0, (1, 1))))


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    rows = good_rows(workshop.study("levels"), kind="levels", level=MERGED)
    wanted = rows.isel(row=rows["scene"].values == SCENE)
    return {"rows": wanted if wanted.sizes["row"] else rows}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    figure = Figure(figsize=(COLUMN, 0.85 * COLUMN), layout="constrained")
    grid = figure.subplots(2, 2, sharex=True)
    ways = list(
        dict.fromkeys(zip(rows["scheme"].values.tolist(), rows["normalization"].values.tolist()))
    )
    for axes, (column, label) in zip(grid.flat, _PANELS.items()):
        for (scheme, normalization), style in zip(ways, _STYLES):
            _curve(axes, rows, scheme, normalization, column, style)
        axes.set_ylabel(label, fontsize=6)
        axes.set_ylim(bottom=0)
    figure.supxlabel("iterations", fontsize=7)
    entries = [
        Line2D([], [], color=style[0], linestyle=style[1], label=f"{short_name(scheme)}, {how}")
        for (scheme, how), style in zip(ways, _STYLES)
    ]
    legend_above(figure, entries, min(2, len(entries)))
    return {"": figure}


def _curve(axes: Axes, rows: xr.Dataset, scheme: str, how: str, column: str, style: Any) -> None:
    chosen = (rows["scheme"].values == scheme) & (rows["normalization"].values == how)
    first = rows["scene"].values[chosen][0]
    own = rows.isel(row=chosen & (rows["scene"].values == first)).sortby("iterations")
    axes.plot(own["iterations"], own[column], color=style[0], linestyle=style[1])
    assert present(own, "level") == [MERGED]
