"""Figure 7 of the octree thesis: the index volume, the levels, and what is sampled from them.

The scene `level-jump`, LPV with 2 bands, 3 levels after 1 iteration, filled with the mean as in
the thesis. Dark means no light. The merged field takes each cell from the level that the index
names; bold lines are borders between levels.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flatland.octree import spread
from flatland.scene import load_scene
from propagators import create
from studies.figures.level_borders import draw_level_borders
from studies.figures.octree_index import draw_index, extent_of, octree_data
from studies.figures.snapshots import draw_flux, flux_bar
from studies.figures.workshop import Workshop
from studies.running import Method
from studies.style import COLUMN

PARTS = ("levels",)
SCENE, LEVELS, STEPS = "level-jump", 3, 1
_COMMAND = (
    "flatland run {} --bands 2 --iterations {} --levels {} --normalization mean --index finest"
)


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene = load_scene(SCENE)
    method = Method(create("lpv"), 2, STEPS, levels=LEVELS, normalization="mean")
    simulation = method.simulation(scene)
    simulation.run(STEPS)
    data = octree_data(
        scene, {"merged": (simulation, None)}, [_COMMAND.format(SCENE, STEPS, LEVELS)]
    )
    for level in range(LEVELS):
        flux = simulation.level(level).accumulated.scalar_flux()
        spread_out = spread(flux, level, scene.grid.shape)
        meaning = {"units": "W", "long_name": f"flux of level {level}, in each cell of level 0"}
        data[f"level_{level}"] = (("x", "y"), spread_out, meaning)
    data.attrs["method"] = json.dumps(method.as_dict(), default=str)
    return {"levels": data}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    levels = data["levels"]
    names = [str(name) for name in levels.data_vars if str(name).startswith("level_")]
    figure = Figure(figsize=(COLUMN, 0.88 * COLUMN), layout="constrained")
    grid = figure.subplots(2, 3, sharex=True, sharey=True)
    index = levels["index"].values[0]
    top = float(levels["flux"].max())
    draw_index(grid[0, 0], index, extent_of(levels), 3.4)
    grid[0, 0].set_title("index volume", fontsize=6)
    images: list[Any] = []
    for axes, name in zip(grid.flat[1:], names):
        images.append(draw_flux(axes, _as_snapshot(levels, name), name, top))
        axes.set_title(f"level {name.partition('_')[2]}", fontsize=6)
    images.append(draw_flux(grid.flat[-2], levels, "merged", top))
    draw_level_borders(grid.flat[-2], index, extent_of(levels))
    grid.flat[-2].set_title("merged", fontsize=6)
    _legend(grid.flat[-1], np.unique(index))
    flux_bar(figure, grid, images[-1])
    grid.flat[-1].set_xlabel("")
    return {"": figure}


def _as_snapshot(data: xr.Dataset, name: str) -> xr.Dataset:
    """A level's flux in the place of a snapshot's."""
    flux = data[name].expand_dims(snapshot=[name])
    return xr.Dataset({"flux": flux}, attrs=data.attrs)


def _legend(axes: Any, levels: Any) -> None:
    axes.axis("off")
    text = "read from\n" + "\n".join(f"{level}: level {level}" for level in levels)
    axes.text(0.5, 0.5, text, ha="center", va="center", fontsize=6, transform=axes.transAxes)
