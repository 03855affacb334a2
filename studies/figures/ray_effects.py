"""Ray effects: a few ordinates leave dark fans between them, wherever space is exact or not.

The flux of `corridor`, whose light is seen from up to 44 cells away, by exact beams along 16, 48
and 192 ordinates, and the exact answer. Two neighbouring ordinates leave a gap where the light is
farther away than (w + h) M / 2π, w its width across them and h a cell: 15 and 46 cells for the
first two. `orders`: the error by number of ordinates. That of beams is the quadrature in angle
alone; it falls with the second power once the gaps are closed. That of a sweep stops falling where
its false scattering takes over, which is what `false-scattering` shows.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.figures.answers import Answers, Asked
from studies.figures.curves import legend_above, panels, plain_log, present
from studies.figures.snapshots import draw_flux, flux_bar, snapshot_data
from studies.figures.workshop import Workshop
from studies.style import COLUMN, Style

PARTS = ("snapshots", "rows")
SCENE, BANDS = "corridor", 2
ORDINATES = (16, 48, 192)
CURVES = ("corridor", "fig5-one-light")
COUNTS = (16, 32, 64, 128, 256, 512, 1024)
#: Sweeps beyond this many ordinates change nothing that could be seen.
MOST_SWEPT = 512
_STYLES: dict[str, Style] = {
    "beam": {"color": "#0072b2", "marker": "o"},
    "sn": {"color": "#d55e00", "marker": "s", "linestyle": (0, (4, 1.5))},
}


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    answers = Answers()
    beams = [Asked(SCENE, "beam", {"ordinates": m}, BANDS) for m in ORDINATES]
    exact = Asked(SCENE, "analytic", {}, BANDS)
    scene = answers.scene(exact)
    fields = {f"{each.options['ordinates']} ordinates": each.field(scene) for each in beams}
    fields["exact answer"] = answers.exact(exact)
    errors = [answers.error(each) for each in beams] + [0.0]
    commands = [each.command for each in (*beams, exact)]
    meaning = "relative L2 error of the coefficients"
    asked = [
        Asked(name, scheme, {"ordinates": m}, BANDS)
        for name in CURVES
        for scheme in _STYLES
        for m in COUNTS
        if scheme == "beam" or m <= MOST_SWEPT
    ]
    counts = [each.options["ordinates"] for each in asked]
    return {
        "snapshots": snapshot_data(scene, fields, commands, error=(errors, meaning)),
        "rows": answers.rows(asked, ordinates=counts),
    }


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    return {"": _maps(data["snapshots"]), "orders": _orders(data["rows"])}


def _maps(snapshots: xr.Dataset) -> Figure:
    names = [str(name) for name in snapshots["snapshot"].values]
    top = float(snapshots["flux"].sel(snapshot=names[-1]).max())
    figure = Figure(figsize=(COLUMN, 0.78 * COLUMN), layout="constrained")
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, name in zip(grid.flat, names):
        image = draw_flux(axes, snapshots, name, top)
        error = float(snapshots["error"].sel(snapshot=name))
        axes.set_title(f"{name}, error {error:.1g}" if error else name, fontsize=6)
    flux_bar(figure, grid, image)
    return figure


def _orders(rows: xr.Dataset) -> Figure:
    scenes = present(rows, "scene")
    figure, grid = panels(len(scenes), sharex=True, sharey=True)
    for axes, scene in zip(grid, scenes):
        for scheme, style in _STYLES.items():
            chosen = (rows["scene"].values == scene) & (rows["propagator"].values == scheme)
            own = rows.isel(row=chosen).sortby("ordinates")
            axes.plot(own["ordinates"], own["error"], markersize=2.6, **style)
        ends = np.array([128.0, 1024.0])
        axes.plot(ends, 0.02 * (ends / 128) ** -2.0, color="#808080", linewidth=0.6, linestyle=":")
        axes.set_title(scene)
        axes.set_yscale("log")
        plain_log(axes, [16, 64, 256, 1024], "x")
        axes.set_xlabel("ordinates M")
    grid[0].set_ylabel("error, relative L2")
    legend_above(figure, _entries())
    return figure


def _entries() -> list[Line2D]:
    names = {"beam": "exact beams", "sn": "sweep (step characteristics)"}
    found = [Line2D([], [], label=names[key], markersize=3, **_STYLES[key]) for key in _STYLES]
    return [*found, Line2D([], [], color="#808080", linestyle=":", label="M⁻²")]
