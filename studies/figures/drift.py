"""Where does energy go? Flux made or lost by schemes and options, over the flux emitted.

From the study `energy`, in the first of its scenes after 2 N steps. Schemes that conserve flux to
rounding, in float64, are one line at zero and are named; what float32 adds is in the data.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from studies.figures.curves import present, whole_ticks
from studies.figures.stability import short_name
from studies.figures.workshop import Workshop, good_rows
from studies.style import COLUMN, Style

PARTS = ("rows",)
#: A drift this small is rounding.
ROUNDING = 1e-9
_STYLES = (
    ("#d55e00", "-", "o"),
    ("#0072b2", (0, (4, 1.5)), "s"),
    ("#009e73", (0, (4, 1.2, 1, 1.2)), "^"),
    ("#cc79a7", (0, (1.2, 1.2)), "v"),
    ("#e69f00", "-", "D"),
    ("#56b4e9", (0, (4, 1.5)), "P"),
    ("#000000", (0, (4, 1.2, 1, 1.2)), "X"),
    ("#999999", (0, (1.2, 1.2)), "<"),
)


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    return {"rows": good_rows(workshop.study("energy"), stop="steps")}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    first = rows["scene"].values[0]
    chosen = (rows["scene"].values == first) & (rows["precision"].values == "float64")
    own = rows.isel(row=chosen & rows["heuristic"].values)
    figure = Figure(figsize=(COLUMN, 0.85 * COLUMN), layout="constrained")
    axes = figure.subplots()
    exact, styles = [], iter(_STYLES * 3)
    for scheme in present(own, "scheme"):
        some = own.isel(row=own["scheme"].values == scheme).sortby("bands")
        drift = some["drift"].values
        if np.abs(drift).max() < ROUNDING:
            exact.append(short_name(str(scheme)))
            continue
        colour, dashes, marker = next(styles)
        style: Style = {"color": colour, "linestyle": dashes, "marker": marker, "markersize": 3}
        axes.plot(some["bands"], drift, label=short_name(str(scheme)), **style)
    label = "none: " + ", ".join(exact)
    axes.axhline(0, color="black", linewidth=0.6, label=label if exact else None)
    axes.set_yscale("symlog", linthresh=0.1)
    axes.set_xlabel("bands n")
    axes.set_ylabel("flux made or lost / emitted")
    axes.set_title(f"{first}, after 2 N steps")
    whole_ticks(axes, present(own, "bands"))
    figure.legend(loc="outside lower center", ncols=2)
    return {"": figure}
