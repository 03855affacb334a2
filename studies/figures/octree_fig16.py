"""Figure 16 of the octree thesis: light that turns back behind a directed source.

LPV with 2 bands, one cell lit to the right, free space (the lit cell of the scene `back-bleeding`,
walls without effect). In truth no light ever gets to the left of the source's middle. The titles
give the share of the accumulated flux in the columns of cells left of the source.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flatland.field import Field
from flatland.scene import load_scene
from propagators import create
from studies.figures.octree_fig3 import SCENE, window_of, without_walls
from studies.figures.snapshots import draw_snapshot, snapshot_data
from studies.figures.workshop import Workshop
from studies.running import Method
from studies.style import COLUMN

PARTS = ("snapshots",)
REACH = 3
STEPS = (0, 2, 3)
_COMMAND = "flatland run {} --propagator lpv --bands 2 --blocking none --iterations {}"


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene = load_scene(SCENE)
    source = int(scene.lights[0].cell[0])  # type: ignore[attr-defined]
    simulation = Method(create("lpv"), 2, STEPS[-1], blocking="none").simulation(scene)
    fields: dict[str, Field] = {}
    behind = []
    for steps in STEPS:
        simulation.run(steps - simulation.iteration)
        fields[str(steps)] = simulation.accumulated
        flux = np.abs(simulation.accumulated.scalar_flux())
        behind.append(float(flux[:source].sum() / flux.sum()))
    commands = [_COMMAND.format(SCENE, steps) for steps in STEPS]
    shares = behind, "share of the flux in cells left of the source"
    return {"snapshots": snapshot_data(scene, fields, commands, behind=shares)}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    snapshots = without_walls(data["snapshots"])
    names = [str(name) for name in snapshots["snapshot"].values]
    figure = Figure(figsize=(COLUMN, 0.38 * COLUMN), layout="constrained")
    for axes, name in zip(figure.subplots(1, len(names)), names):
        draw_snapshot(axes, snapshots, name, window_of(snapshots, REACH))
        share = float(snapshots["behind"].sel(snapshot=name))
        axes.set_title(f"{name} steps: {100 * share:.1f} % behind")
    return {"": figure}
