"""Figure 11 (left) of the cascaded LPV paper: light that bleeds through a thin shelf.

The scene `shelf`, LPV with 2 bands, converged. Below the shelf it is dark, in truth, right of
x = 12 m. The titles give the share of the flux that is found in cells that are exactly dark.
"""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from flatland.scene import load_scene
from propagators import create
from studies.figures.snapshots import draw_flux, flux_bar, snapshot_data
from studies.figures.workshop import Workshop
from studies.metrics import leak
from studies.reference import Reference
from studies.running import Method, run_method
from studies.style import COLUMN

PARTS = ("snapshots",)
SCENE, BANDS, TOLERANCE = "shelf", 2, 1e-8
#: Panel: kind of blocking and strength.
WALLS = {
    "no blocking": ("none", 1.0),
    "fuzzy blocking": ("fuzzy", 1.0),
    "fuzzy, strength 1.5": ("fuzzy", 1.5),
    "fuzzy, strength 2": ("fuzzy", 2.0),
    "exact blocking": ("exact", 1.0),
}
_COMMAND = "flatland run {} --propagator {} --bands {} --reference"


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene = load_scene(SCENE)
    exact = Reference(scene).field(BANDS)
    fields, shares = {"exact answer": exact}, [leak(exact, exact)]
    commands = [_COMMAND.format(SCENE, "analytic", BANDS)]
    for name, (kind, strength) in WALLS.items():
        scheme = create("lpv")
        walls = {"blocking": kind, "strength": strength}
        method = Method(scheme, BANDS, converge=TOLERANCE, **walls)  # type: ignore[arg-type]
        fields[name] = run_method(scene, method).accumulated
        shares.append(leak(fields[name], exact))
        options = f" --converge {TOLERANCE} --blocking {kind} --strength {strength}"
        commands.append(_COMMAND.format(SCENE, "lpv", BANDS) + options)
    meaning = "share of the flux in cells that are exactly dark"
    return {"snapshots": snapshot_data(scene, fields, commands, leak=(shares, meaning))}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    snapshots = data["snapshots"]
    names = [str(name) for name in snapshots["snapshot"].values]
    top = float(snapshots["flux"].sel(snapshot=names[0]).max())
    figure = Figure(figsize=(COLUMN, 0.88 * COLUMN), layout="constrained")
    grid = figure.subplots(2, 3, sharex=True, sharey=True)
    for axes, name in zip(grid.flat, names):
        image = draw_flux(axes, snapshots, name, top)
        share = float(snapshots["leak"].sel(snapshot=name))
        axes.set_title(f"{name}\n{100 * share:.1f} % in the dark", fontsize=6)
    flux_bar(figure, grid, image)
    return {"": figure}
