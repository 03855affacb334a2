"""Figure 7 of the octree thesis: the index volume, the levels, and what is sampled from them.

The scene `level-jump`, LPV with 2 bands, 3 levels after 1 iteration, filled with the mean as in
the thesis. The darkest colour is no light. The merged field takes each cell from the level whose
number the index volume holds; bold lines are borders between levels. Last, what all of it stands
for: the converged uniform grid.
"""

from __future__ import annotations

import json

import xarray as xr
from matplotlib.figure import Figure

from flatland.octree import spread
from flatland.scene import load_scene
from propagators import create
from studies.figures.level_borders import draw_level_borders
from studies.figures.octree_index import draw_index, octree_data
from studies.figures.slices import extent_of
from studies.figures.snapshots import draw_flux, flux_bar
from studies.figures.workshop import Workshop
from studies.running import Method
from studies.style import COLUMN

PARTS = ("levels",)
SCENE, LEVELS, STEPS, TOLERANCE = "level-jump", 3, 1, 1e-8
_COMMAND = (
    "flatland run {} --bands 2 --iterations {} --levels {} --normalization mean --index finest"
)
_UNIFORM = "flatland run {} --bands 2 --converge {}"


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene = load_scene(SCENE)
    method = Method(create("lpv"), 2, STEPS, levels=LEVELS, normalization="mean")
    simulation = method.simulation(scene)
    simulation.run(STEPS)
    uniform = Method(create("lpv"), 2, converge=TOLERANCE).simulation(scene)
    uniform.solve(TOLERANCE)
    commands = [_COMMAND.format(SCENE, STEPS, LEVELS), _UNIFORM.format(SCENE, TOLERANCE)]
    runs = {"merged": (simulation, None), "uniform grid": (uniform, None)}
    data = octree_data(scene, runs, commands)
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
    figure = Figure(figsize=(COLUMN, 1.55 * COLUMN), layout="constrained")
    grid = figure.subplots(3, 2, sharex=True, sharey=True)
    index, extent = levels["index"].sel(snapshot="merged").values, extent_of(levels)
    top = float(levels["flux"].max())
    draw_index(grid[0, 0], index, extent)
    grid[0, 0].set_title("index volume", fontsize=6)
    for axes, name in zip(grid.flat[1:], names):
        draw_flux(axes, _as_snapshot(levels, name), name, top)
        axes.set_title(f"level {name.partition('_')[2]}", fontsize=6)
    for axes, name in zip(grid[2], ("merged", "uniform grid")):
        image = draw_flux(axes, levels, name, top)
        axes.set_title(name, fontsize=6)
    draw_level_borders(grid[2, 0], index, extent)
    flux_bar(figure, grid, image)
    return {"": figure}


def _as_snapshot(data: xr.Dataset, name: str) -> xr.Dataset:
    """A level's flux in the place of a snapshot's."""
    one = data.isel(snapshot=[0])
    flux = one["flux"].copy(data=data[name].values[None])
    return one.assign(flux=flux).assign_coords(snapshot=[name])
