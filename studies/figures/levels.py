"""Do an octree's levels agree with the uniform grid? Error of each level and of what is merged.

From the study `levels`, scene `shelf`: against the converged uniform grid, downsampled to each
level, after every iteration. Left: levels filled with the mean of their children (the octree
thesis), right: with the flux, 2^i times as much.
"""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.figures.curves import legend_above, plain_log, present
from studies.figures.workshop import Workshop, good_rows
from studies.kinds.level_history import MERGED
from studies.style import COLUMN, Style, line_of

PARTS = ("rows",)
SCENE = "shelf"
_DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (2, 1)), (0, (1, 1.4)), (0, (5, 1, 1, 1)))
_WIDE: Style = {"color": "black", "linewidth": 1.4}


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    """One scene of the study, schemes with their defaults."""
    rows = good_rows(workshop.study("levels"), kind="levels", options="")
    scenes = present(rows, "scene")
    chosen = SCENE if SCENE in scenes else scenes[0]
    return {"rows": rows.isel(row=rows["scene"].values == chosen)}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    schemes, ways = present(rows, "propagator"), present(rows, "normalization")
    figure = Figure(figsize=(COLUMN, 0.35 + 0.36 * COLUMN * len(schemes)), layout="constrained")
    grid = figure.subplots(len(schemes), len(ways), sharex=True, sharey=True, squeeze=False)
    levels = [level for level in present(rows, "level") if level != MERGED]
    for line, scheme in zip(grid, schemes):
        for axes, way in zip(line, ways):
            chosen = (rows["propagator"].values == scheme) & (rows["normalization"].values == way)
            own = rows.isel(row=chosen & (rows["iterations"].values > 0))
            colour = line_of(str(scheme)).colour
            for level, dashes in zip(levels, _DASHES):
                some = own.isel(row=own["level"].values == level).sortby("iterations")
                axes.plot(some["iterations"], some["coefficients"], color=colour, linestyle=dashes)
            merged = own.isel(row=own["level"].values == MERGED).sortby("iterations")
            axes.plot(merged["iterations"], merged["coefficients"], **_WIDE)
            axes.set_title(f"{str(scheme).upper()}, {way}", fontsize=6)
            axes.set_ylim(0, 1.05)
            plain_log(axes, [1, 4, 16, 64], "x")
    figure.supxlabel("iterations", fontsize=7)
    figure.supylabel("error against the uniform grid, relative L2", fontsize=7)
    pairs = zip(levels, _DASHES)
    entries = [Line2D([], [], color="grey", linestyle=d, label=f"level {n}") for n, d in pairs]
    legend_above(figure, [*entries, Line2D([], [], label="merged", **_WIDE)], 3)
    return {"": figure}
