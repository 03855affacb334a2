"""Figure 17 of the octree thesis: the jump of the index volume beside a light, and its remedy.

The scene `level-jump` after injection, all levels: the thesis' index volume jumps from level 0 to
the coarsest on the sides of the light where its tree ends; the symmetric one, which it asks for
(7.1), grows in rings. The numbers are the levels that cells are read from.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flatland.octree import INDEX_STRATEGIES, most_levels
from flatland.scene import load_scene
from propagators import create
from studies.figures.octree_index import draw_index, octree_data
from studies.figures.slices import extent_of
from studies.figures.workshop import Workshop
from studies.running import Method
from studies.style import COLUMN

PARTS = ("index",)
SCENE = "level-jump"
_TITLES = {"finest": "thesis", "symmetric": "symmetric"}
_COMMAND = "flatland run {} --iterations 0 --levels {} --index {}"


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene = load_scene(SCENE)
    levels = most_levels(scene.grid.shape)
    runs = {}
    for strategy in INDEX_STRATEGIES:
        simulation = Method(create("lpv"), 2, 0, levels=levels, index=strategy).simulation(scene)
        simulation.start()
        runs[strategy] = simulation, None
    commands = [_COMMAND.format(SCENE, levels, strategy) for strategy in INDEX_STRATEGIES]
    return {"index": octree_data(scene, runs, commands)}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    fields = data["index"]
    figure = Figure(figsize=(COLUMN, 0.58 * COLUMN), layout="constrained")
    grid = figure.subplots(1, 2, sharey=True)
    grid[0].set_ylabel("y [m]", fontsize=6)
    for axes, name in zip(grid, fields["snapshot"].values):
        axes.set_xlabel("x [m]", fontsize=6)
        index = fields["index"].sel(snapshot=name).values
        draw_index(axes, index, extent_of(fields))
        steps = max(np.abs(np.diff(index.astype(int), axis=axis)).max() for axis in (0, 1))
        axes.set_title(f"{_TITLES.get(str(name), str(name))}: steps up to {steps}", fontsize=6)
    return {"": figure}
