"""What a scheme does to waves, along an axis of the grid.

From the study `stability`. Above: what a step leaves of the slowest fading wave. Below: the flux
that a source of that wave leaves in the end, times |k|, which straight flight keeps at 1 for long
waves (see `studies.kinds.waves`). LPV's grows like 1/|k|: diffusion. Discrete ordinates with bins
depend on whether n is odd: with an odd number of bands they diffuse too, with an even number long
waves get almost nothing, as in the P_N equations.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.figures.curves import legend_above, plain_log, present
from studies.figures.workshop import Workshop, good_rows
from studies.style import COLUMN, line_of

PARTS = ("rows",)
_SCHEMES = ("lpv", "dom4", "dom8")
_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (1, 1)), (0, (4, 1, 1, 1)))


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    rows = workshop.study("stability")
    return {"rows": good_rows(rows, kind="waves", scheme=list(_SCHEMES))}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    return {
        name: _draw(rows.isel(row=rows["direction"].values == name))
        for name in present(rows, "direction")
    }


def _draw(rows: xr.Dataset) -> Figure:
    """A column of panels per scheme: damping above, response below."""
    schemes = present(rows, "scheme")
    figure = Figure(figsize=(COLUMN, 0.95 * COLUMN), layout="constrained")
    grid = figure.subplots(2, len(schemes), sharex="col", sharey="row", squeeze=False)
    for (above, below), scheme in zip(grid.T, schemes):
        own = rows.isel(row=rows["scheme"].values == scheme)
        for dashes, bands in zip(_DASHES, present(rows, "bands")):
            some = own.isel(row=own["bands"].values == bands).sortby("wave")
            _curves(above, below, some, dashes)
        below.axhline(_flight(own), color="#b0b0b0", linewidth=2.5, zorder=0)
        below.set_yscale("log")
        plain_log(below, [0.03, 0.1, 0.3, 1, 3], "x")
        above.set_title(str(scheme).upper())
        above.set_ylim(0, 1.05)
    grid[0, 0].set_ylabel("kept in a step, ρ(k)")
    grid[1, 0].set_ylabel("response × |k|")
    figure.supxlabel("wave number |k| [rad per cell]", fontsize=7)
    legend_above(figure, _entries(rows), 3)
    return figure


def _flight(rows: xr.Dataset) -> float:
    """Response times |k| of straight flight, the same for all long waves."""
    return float(rows["exact_response"][0] * rows["wave"][0])


def _curves(above: Axes, below: Axes, rows: xr.Dataset, dashes: Any) -> None:
    colour = line_of(str(rows["propagator"].values[0])).colour
    above.plot(rows["wave"], rows["radius"], color=colour, linestyle=dashes)
    response = rows["response"].values * rows["wave"].values
    shown = np.where(response > 0, response, np.nan)
    below.plot(rows["wave"], shown, color=colour, linestyle=dashes)


def _entries(rows: xr.Dataset) -> list[Line2D]:
    pairs = zip(_DASHES, present(rows, "bands"))
    found = [Line2D([], [], color="black", linestyle=d, label=f"{n} bands") for d, n in pairs]
    return [*found, Line2D([], [], color="#b0b0b0", linewidth=2.5, label="straight flight")]
