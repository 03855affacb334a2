"""What does accuracy cost? Run time against error of every propagator, one figure per scene.

From the study `pareto`: LPV and DOM, stepped, solved and on octrees; beams, sweeps, cascades and
maps; and the exact answer. One thread, one case at a time, medians. Above, the error over all
directions, which holds the truncation to n bands: the lines are the floors of 2, 4 and 8 bands.
Below, with 4 bands alone, the error of the coefficients, which has no floor; what is below 1e-4, as
the exact answer, stands at the lower edge. The step line is the front; all that it beats is drawn
pale.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from studies.figures.curves import legend_above, log_seconds, plain_log, present
from studies.figures.pareto import best_per_decade, front, timed_rows, with_front
from studies.figures.workshop import Workshop
from studies.style import COLUMN, Style, line_of

PARTS = ("rows", "decades")
#: Bands of the lower panel, and of the floors in the upper one.
BANDS, _FLOORS = 4, (2, 4, 8)
_SHORT = {"analytic": "exact", "light-propagation-maps": "LP maps", "holographic-rc": "hol. RC"}
_NAMES = {**_SHORT, "radiance-cascades": "rad. cascades", "modified-dom": "mod. DOM"}
_TICKS = (0.0001, 0.001, 0.01, 0.1, 1.0)
#: Error of the lower panel's edge; smaller ones are drawn there.
LEAST = 1e-4
#: Points of a scheme in a panel that would hide others if they were not small and pale.
_MANY = 30


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    rows = with_front(timed_rows(workshop))
    return {"rows": rows, "decades": best_per_decade(rows)}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    drawn = {}
    for scene in present(rows, "scene"):
        own = rows.isel(row=rows["scene"].values == scene)
        drawn[str(scene)] = _figure(own, present(rows, "propagator"))
    return drawn


def _figure(rows: xr.Dataset, names: list[str]) -> Figure:
    figure = Figure(figsize=(COLUMN, 1.45 * COLUMN), layout="constrained")
    above, below = figure.subplots(2, sharex=True)
    _floors(above, rows)
    _points(above, rows, rows["angular"].values)
    plain_log(above, [0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5], "y")
    above.set_ylabel("error over all directions")
    some = rows.isel(row=rows["bands"].values == BANDS)
    _points(below, some, np.maximum(some["coefficients"].values, LEAST))
    plain_log(below, _TICKS, "y")
    below.set_ylim(0.7 * LEAST, None)
    below.set_ylabel(f"error of the coefficients, {BANDS} bands")
    log_seconds(below)
    below.set_xlabel("seconds")
    above.set_title(str(rows["scene"].values[0]))
    legend_above(figure, _entries(names), 4)
    return figure


def _floors(axes: Axes, rows: xr.Dataset) -> None:
    """Where the exact answer of so many bands is."""
    for bands in _FLOORS:
        floors = rows["floor"].values[(rows["bands"].values == bands) & _finest(rows)]
        if floors.size:
            axes.axhline(floors[0], color="#909090", linewidth=0.5, linestyle=(0, (1, 2)), zorder=0)
            axes.annotate(
                f"{bands} bands",
                (1.0, floors[0]),
                (-1, 1),
                xycoords=("axes fraction", "data"),
                textcoords="offset points",
                ha="right",
                fontsize=5,
            )


def _finest(rows: xr.Dataset) -> NDArray[np.bool_]:
    """Rows on the scene's own grid."""
    return np.asarray(rows["resolution"].values == 1)


def _points(axes: Axes, rows: xr.Dataset, errors: NDArray[np.float64]) -> None:
    seconds = rows["seconds"].values
    good = front(seconds, errors)
    for name in present(rows, "propagator"):
        line, own = line_of(str(name)), rows["propagator"].values == name
        pale = (2.2, 0.3) if own.sum() > _MANY else (3.0, 0.7)
        for chosen, size, shade in ((own & ~good, *pale), (own & good, 4.2, 1.0)):
            style: Style = {"marker": line.marker, "color": line.colour, "linestyle": ""}
            style |= {"markersize": size, "alpha": shade, "markeredgewidth": 0.4}
            axes.plot(seconds[chosen], errors[chosen], zorder=2 + shade, **style)
    order = np.argsort(seconds[good])
    across, up = seconds[good][order], errors[good][order]
    axes.step(across, up, "k-", where="post", linewidth=0.6, zorder=1)


def _entries(names: list[str]) -> list[Line2D]:
    entries = []
    for name in names:
        line = line_of(str(name))
        label = _NAMES.get(str(name), str(name).upper())
        marks: Style = {"marker": line.marker, "color": line.colour, "linestyle": ""}
        entries.append(Line2D([], [], markersize=3.5, label=label, **marks))
    return [*entries, Line2D([], [], color="black", linewidth=0.6, label="front")]
