"""What is left of a penumbra: flux down a column, from light through half shadow to dark.

The column x = 4.5 of `shelf`, past the end of the shelf at (12, 16). Above y = 15.2 all of the
light is seen, below y = 11 none of it. Left: the stencils, converged. Right: schemes that follow
rays, beams or sweeps. Below, the same on a logarithmic axis, on which light in the dark shows. A
line that ends has no light left.
"""

from __future__ import annotations

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flatland.results import versions
from flatland.scene import scene_to_toml
from studies.figures.answers import Answers, Asked
from studies.figures.workshop import Workshop
from studies.style import COLUMN, Style

PARTS = ("profiles",)
SCENE, COLUMN_OF_CELLS, BANDS = "shelf", 4, 2
#: Cells shown, and by how much less than the brightest.
ROWS, FAINTEST = (6, 20), 1e-4
_STENCILS = {"lpv": Asked(SCENE, "lpv"), "dom4": Asked(SCENE, "dom4"), "dom8": Asked(SCENE, "dom8")}
_RAYS = {
    "sweep": Asked(SCENE, "sn"),
    "cascades, vanilla": Asked(SCENE, "radiance-cascades", {"fix": "vanilla"}),
    "cascades, bilinear": Asked(SCENE, "radiance-cascades"),
    "holographic": Asked(SCENE, "holographic-rc"),
    "maps": Asked(SCENE, "light-propagation-maps"),
    "beam": Asked(SCENE, "beam"),
}
_EXACT: Style = {"color": "#b0b0b0", "linewidth": 3, "zorder": 0}
_STYLES: dict[str, Style] = {
    "exact": _EXACT,
    "lpv": {"color": "#d55e00", "marker": "o"},
    "dom4": {"color": "#0072b2", "marker": "s", "linestyle": (0, (4, 1.5))},
    "dom8": {"color": "#009e73", "marker": "^", "linestyle": (0, (4, 1.2, 1, 1.2))},
    "sweep": {"color": "#e69f00", "marker": "s", "linestyle": (0, (4, 1.5))},
    "cascades, vanilla": {"color": "#d55e00", "marker": "v", "linestyle": (0, (1.2, 1.2))},
    "cascades, bilinear": {"color": "#cc79a7", "marker": "^", "linestyle": (0, (4, 1.2, 1, 1.2))},
    "holographic": {"color": "#56b4e9", "marker": "D", "linestyle": (0, (6, 1))},
    "maps": {"color": "#009e73", "marker": "x", "linestyle": ""},
    "beam": {"color": "black", "linewidth": 0.6},
}


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    answers, asked = Answers(), {**_STENCILS, **_RAYS}
    exact = Asked(SCENE, "analytic", {}, BANDS)
    scene = answers.scene(exact)
    fields = {"exact": answers.exact(exact)}
    fields |= {name: each.field(scene) for name, each in asked.items()}
    flux = [field.scalar_flux()[COLUMN_OF_CELLS] for field in fields.values()]
    centres = scene.grid.to_world(np.arange(scene.grid.shape[1])[:, None] + [0.5, 0.5])[:, 1]
    data = xr.Dataset(
        {
            "flux": (("scheme", "y"), flux, {"units": "W"}),
            "command": ("scheme", [each.command for each in (exact, *asked.values())]),
            "stencil": ("scheme", [name in _STENCILS for name in fields]),
        },
        {"scheme": list(fields), "y": ("y", centres, {"units": "m"})},
    )
    data.attrs = {
        "scene": scene_to_toml(scene),
        "column": COLUMN_OF_CELLS,
        "versions": json.dumps(versions(), sort_keys=True),
    }
    return {"profiles": data}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    profiles = data["profiles"].isel(y=slice(*ROWS))
    top = float(profiles["flux"].sel(scheme="exact").max())
    figure = Figure(figsize=(COLUMN, 1.25 * COLUMN), layout="constrained")
    grid = figure.subplots(2, 2, sharex=True, sharey="row")
    for (above, below), stencils in zip(grid.T, (True, False)):
        names = [
            str(name)
            for name, own in zip(profiles["scheme"].values, profiles["stencil"].values)
            if own == stencils and name != "exact"
        ]
        for axes, faintest in ((above, -np.inf), (below, FAINTEST * top)):
            _curves(axes, profiles, ["exact", *names], faintest)
        below.set(yscale="log", ylim=(FAINTEST * top, 2 * top), xlabel="y [m]")
        above.legend(handles=_entries(names), loc="upper left", fontsize=5, borderpad=0.1)
        above.set_title("stencils" if stencils else "rays, beams, sweeps")
    grid[0, 0].set(ylabel="flux that leaves a cell [W]", ylim=(0, 2 * top))
    grid[1, 0].set_ylabel("flux that leaves a cell [W]")
    return {"": figure}


def _curves(axes: Axes, profiles: xr.Dataset, names: list[str], faintest: float) -> None:
    for name in names:
        flux = profiles["flux"].sel(scheme=name).values
        shown = np.where(flux > faintest, flux, np.nan)
        marks: Style = {"markersize": 2.4, "markeredgewidth": 0.5}
        axes.plot(profiles["y"], shown, **{**marks, **_STYLES[name]})


def _entries(names: list[str]) -> list[Line2D]:
    return [
        Line2D([], [], label=name, markersize=2.4, **_STYLES[name]) for name in (*names, "exact")
    ]
