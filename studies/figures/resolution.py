"""Do finer grids help? Error by cell size, and the order p of error = C hᵖ.

From the study `resolution`: converged fields, exact blocking, each grid against the exact answer
on itself. Orders are fitted over all scenes with 95 % confidence (`studies.orders`); 0 is no
convergence, below 0 refinement makes things worse.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from studies.figures.curves import (
    draw_curves,
    legend_above,
    panels,
    plain_log,
    present,
    scheme_entries,
)
from studies.figures.workshop import Workshop, good_rows
from studies.orders import fitted_orders

PARTS = ("rows", "orders")


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    rows = good_rows(workshop.study("resolution"))
    return {"rows": rows, "orders": _orders(rows)}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows, orders = data["rows"], data["orders"]
    most = int(rows["bands"].max())
    own = rows.isel(row=rows["bands"].values == most)
    scenes = present(own, "scene")
    figure, grid = panels(len(scenes), sharey=True)
    for axes, scene in zip(grid, scenes):
        here = own.isel(row=own["scene"].values == scene)
        draw_curves(axes, here, "cells", "coefficients")
        sizes = sorted(set(here["cells"].values.tolist()))
        plain_log(axes, sizes[:: max(1, len(sizes) // 3)], "x")
        plain_log(axes, [0.3, 0.5, 0.7, 1.0, 1.5], "y")
        axes.set_title(scene)
    figure.supxlabel("cells along the longest side", fontsize=7)
    figure.supylabel(f"error of the coefficients, relative L2, {most} bands", fontsize=7)
    entries = scheme_entries(present(own, "propagator"))
    for entry, name in zip(entries, present(own, "scheme")):
        entry.set_label(f"{entry.get_label()}: p = {_shown(orders, str(name), most)}")
    legend_above(figure, entries, 1)
    return {"": figure}


def _orders(rows: xr.Dataset) -> xr.Dataset:
    """Orders of two measures by scheme and bands, as rows."""
    found = {
        (measure, scheme, bands): order
        for measure in ("coefficients", "scaled", "angular")
        for (scheme, bands), order in fitted_orders(rows, measure).items()
    }
    measures, schemes, bands = (list(column) for column in zip(*found)) if found else ([], [], [])
    values = {
        name: ("row", np.array([getattr(order, name) for order in found.values()], float))
        for name in ("order", "low", "high", "points", "worst")
    }
    keys = {"measure": ("row", measures), "scheme": ("row", schemes), "bands": ("row", bands)}
    attrs = {"about": "error = C h^p over all scenes of the rows beside it, 95 % confidence"}
    names = [f"{measure} {scheme} {n}" for measure, scheme, n in found]
    return xr.Dataset({**keys, **values}, coords={"row": names}, attrs=attrs)


def _shown(orders: xr.Dataset, scheme: str, bands: int) -> str:
    name = f"coefficients {scheme} {bands}"
    if name not in orders["row"].values:
        return "–"
    row = orders.sel(row=name)
    half = (float(row["high"]) - float(row["low"])) / 2
    return f"{float(row['order']):+.2f} ± {half:.2f}"
