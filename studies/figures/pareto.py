"""What does accuracy cost a scheme that steps? Run time against error of every timed run.

From the study `pareto`, its first two scenes, LPV and DOM and the exact answer: one thread, one
case at a time, the median of repeats after a run that is not counted; set-up (stencil, blocking)
does not count. Filled: float64, open: float32. Circled: converged by `solve`; the others were
stepped. Thin diamonds: octrees. The line is the front, runs that no other beats in both; all
others are drawn pale. Each grid is compared with the exact answer on itself.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray

from studies.figures.curves import legend_above, log_seconds, plain_log, present
from studies.figures.workshop import Workshop, good_rows
from studies.style import COLUMN, Style, line_of

PARTS = ("rows", "decades")
_SCENES = 2
_OCTREE = "d"
#: Digits of an error that tell two apart.
_SAME = 6


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    """Timed rows, each with whether it is on the front of its scene."""
    rows = timed_rows(workshop)
    stepped = (rows["stop"].values != "direct") | (rows["propagator"].values == "analytic")
    rows = rows.isel(row=stepped & rows["scene"].isin(present(rows, "scene")[:_SCENES]).values)
    marked = with_front(rows)
    return {"rows": marked, "decades": best_per_decade(marked)}


def timed_rows(workshop: Workshop) -> xr.Dataset:
    """Rows of the study `pareto` that are done and timed."""
    rows = good_rows(workshop.study("pareto"))
    return rows.isel(row=np.isfinite(rows["angular"].values) & (rows["repeats"].values > 0))


def with_front(rows: xr.Dataset) -> xr.Dataset:
    """The rows with a column `front`."""
    on_front = np.zeros(rows.sizes["row"], bool)
    for scene in present(rows, "scene"):
        own = np.flatnonzero(rows["scene"].values == scene)
        on_front[own] = front(rows["seconds"].values[own], rows["angular"].values[own])
    meaning = "no other run on the scene is both faster and closer over all directions"
    return rows.assign(front=("row", on_front, {"long_name": meaning}))


def best_per_decade(rows: xr.Dataset) -> xr.Dataset:
    """The row with the least error for each scene and power of ten of the run time, in order.

    Of errors that differ by rounding, the fastest.
    """
    seconds = rows["seconds"].values
    decades = np.floor(np.log10(seconds)).astype(int)
    marks = zip(rows["angular"].values.round(_SAME).tolist(), seconds.tolist())
    best: dict[tuple[str, int], int] = {}
    ranks = dict(enumerate(marks))
    for place, key in enumerate(zip(rows["scene"].values.tolist(), decades.tolist())):
        if key not in best or ranks[place] < ranks[best[key]]:
            best[key] = place
    chosen = [best[key] for key in sorted(best)]
    meaning = "power of ten of the run time"
    return rows.isel(row=chosen).assign(decade=("row", decades[chosen], {"long_name": meaning}))


def front(seconds: ArrayLike, errors: ArrayLike) -> NDArray[np.bool_]:
    """Which points no other point beats: none is as fast and as good, and better in one of both."""
    time, error = np.asarray(seconds, float), np.asarray(errors, float)
    best, chosen = np.inf, np.zeros(time.size, bool)
    for place in np.lexsort((error, time)):
        if error[place] < best:
            best, chosen[place] = error[place], True
    return chosen


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    scenes = present(rows, "scene")
    size = (COLUMN, 0.1 + len(scenes) * 0.72 * COLUMN)
    figure = Figure(figsize=size, layout="constrained")
    for axes, scene in zip(figure.subplots(len(scenes), squeeze=False)[:, 0], scenes):
        _draw(axes, rows.isel(row=rows["scene"].values == scene))
        axes.set_title(scene)
    figure.supxlabel("seconds", fontsize=7)
    figure.supylabel("error over all directions, relative L2", fontsize=7)
    legend_above(figure, _entries(rows), 4)
    return {"": figure}


def _draw(axes: Axes, rows: xr.Dataset) -> None:
    for place in range(rows.sizes["row"]):
        _point(axes, rows.isel(row=place))
    own = rows.isel(row=rows["front"].values).sortby("seconds")
    axes.step(own["seconds"], own["angular"], "k-", where="post", linewidth=0.6, zorder=1)
    log_seconds(axes)
    plain_log(axes, [0.2, 0.3, 0.5, 0.7, 1.0, 1.5], "y")


def _point(axes: Axes, row: xr.Dataset) -> None:
    line, good = line_of(str(row["propagator"].values)), bool(row["front"])
    hollow = str(row["precision"].values) == "float32"
    marker = _OCTREE if int(row["levels"]) > 1 else line.marker
    style: Style = {"marker": marker, "color": line.colour, "alpha": 1.0 if good else 0.3}
    face = "white" if hollow else line.colour
    where = [float(row["seconds"])], [float(row["angular"])]
    size: Style = {
        "markersize": 4 if good else 2.6,
        "markeredgewidth": 0.6,
        "zorder": 3 if good else 2,
    }
    axes.plot(*where, markerfacecolor=face, **style, **size)
    if good and str(row["stop"].values) == "converged":
        ring: Style = {
            "marker": "o",
            "markersize": 7,
            "markerfacecolor": "none",
            "markeredgewidth": 0.5,
        }
        axes.plot(*where, color="black", linestyle="", **ring)


def _entries(rows: xr.Dataset) -> list[Line2D]:
    found = []
    for name in present(rows, "propagator"):
        line = line_of(str(name))
        shown = "exact" if name == "analytic" else str(name).upper()
        marks: Style = {"marker": line.marker, "color": line.colour, "linestyle": ""}
        found.append(Line2D([], [], markersize=4, label=shown, **marks))
    ring: Style = {"marker": "o", "markersize": 6, "markerfacecolor": "none", "linestyle": ""}
    plain: Style = {"marker": "s", "markersize": 4, "linestyle": "", "color": "black"}
    octree: Style = {**plain, "marker": _OCTREE}
    return [
        *found,
        Line2D([], [], color="black", markeredgewidth=0.5, label="converged", **ring),
        Line2D([], [], markerfacecolor="white", label="float32", **plain),
        *([Line2D([], [], label="octree", **octree)] if rows["levels"].values.max() > 1 else []),
        Line2D([], [], color="black", linewidth=0.6, label="front"),
    ]
