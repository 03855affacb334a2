"""Figure 9 of the octree thesis: two lit walls, in the simulator's view of the merged octree.

The scene `two-walls`, LPV with 2 bands, all levels, after 2 iterations, filled with the mean as in
the thesis. Lobes are the accumulated intensity, their radius its 0.35th power; negative intensity
is blue. Bold lines are borders between levels, at which the intensity jumps (its section 6.1).
"""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from flatland.octree import most_levels
from flatland.scene import load_scene
from propagators import create
from studies.figures.level_borders import draw_level_borders
from studies.figures.octree_index import octree_data
from studies.figures.slices import extent_of
from studies.figures.snapshots import draw_snapshot, name_axes
from studies.figures.workshop import Workshop
from studies.running import Method
from studies.style import COLUMN

PARTS = ("merged",)
SCENE, STEPS = "two-walls", 2
_COMMAND = "flatland run {} --bands 2 --iterations {} --levels {} --normalization mean"


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene = load_scene(SCENE)
    levels = most_levels(scene.grid.shape)
    method = Method(create("lpv"), 2, STEPS, levels=levels, normalization="mean")
    simulation = method.simulation(scene)
    simulation.run(STEPS)
    commands = [_COMMAND.format(SCENE, STEPS, levels)]
    return {"merged": octree_data(scene, {"merged": (simulation, None)}, commands)}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    merged = data["merged"]
    figure = Figure(figsize=(COLUMN, COLUMN), layout="constrained")
    axes = figure.subplots()
    extent = extent_of(merged)
    draw_snapshot(axes, merged, "merged", extent)
    draw_level_borders(axes, merged["index"].values[0], extent)
    name_axes(figure)
    axes.set_title(f"{merged.attrs['title']}: {STEPS} steps, merged")
    return {"": figure}
