"""What gets through walls? Leak by strength of fuzzy blocking, beside exact blocking and none.

From the study `blocking`, with the most bands it has. For open scenes the leak is the share of the
flux found in cells that are exactly dark; for closed boxes it is the share that escaped. Bars at
the left edge: no blocking; at the right edge: exact blocking.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.figures.curves import draw_curves, legend_above, panels, present, scheme_entries
from studies.figures.workshop import Workshop, good_rows
from studies.style import line_of

PARTS = ("rows",)


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    rows = good_rows(workshop.study("blocking"))
    rows = rows.isel(row=rows["bands"].values == rows["bands"].values.max())
    closed = np.char.startswith(rows["scene"].values.astype(str), "box")
    share = rows["left"].values / rows["emitted"].values
    leak = np.where(closed, share, rows["leak"].values)
    meaning = "escaped share of a closed box; else the share of the flux in dark cells"
    return {"rows": rows.assign(shown_leak=("row", leak, {"long_name": meaning}))}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    scenes = present(rows, "scene")
    figure, grid = panels(len(scenes), sharex=True)
    for axes, scene in zip(grid, scenes):
        _draw(axes, rows.isel(row=rows["scene"].values == scene))
        axes.set_title(scene)
    figure.supxlabel("strength of fuzzy blocking", fontsize=7)
    figure.supylabel("leak, share of the flux", fontsize=7)
    bar = Line2D([], [], color="black", linewidth=1.6, label="left: none, right: exact")
    legend_above(figure, [*scheme_entries(present(rows, "propagator")), bar], 2)
    return {"": figure}


def _draw(axes: Axes, rows: xr.Dataset) -> None:
    fuzzy = rows.isel(row=rows["blocking"].values == "fuzzy")
    draw_curves(axes, fuzzy, "strength", "shown_leak")
    last = float(fuzzy["strength"].max())
    for kind, ends in (("none", (-0.12, 0.0)), ("exact", (1.0, 1.12))):
        for row in range(rows.sizes["row"]):
            if str(rows["blocking"].values[row]) == kind:
                colour = line_of(str(rows["propagator"].values[row])).colour
                value = float(rows["shown_leak"][row])
                where = [end * last for end in ends]
                axes.plot(where, [value, value], color=colour, linewidth=1.6)
    axes.set_xlim(-0.14 * last, 1.14 * last)
    axes.set_ylim(-0.02, 1.05 * max(0.1, float(rows["shown_leak"].max())))
