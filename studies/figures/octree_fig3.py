"""Figure 3 of the octree thesis: one lit cell, the light of four iterations, and their sum.

LPV with 2 bands in free space, the lit cell of the scene `back-bleeding`, walls without effect.
S_i is the light that iteration i moved; S_A, what is used, is the sum of all.
"""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from flatland.field import Field
from flatland.scene import load_scene, parse_scene
from propagators import create
from studies.figures.snapshots import draw_snapshot, snapshot_data
from studies.figures.workshop import Workshop
from studies.running import Method
from studies.style import COLUMN

PARTS = ("snapshots",)
SCENE, STEPS = "back-bleeding", 4
#: Cells shown on each side of the lit one.
REACH = 4
_COMMAND = "flatland run {} --propagator lpv --bands 2 --blocking none --iterations {}"


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene = load_scene(SCENE)
    simulation = Method(create("lpv"), 2, STEPS, blocking="none").simulation(scene)
    simulation.inject()
    fields: dict[str, Field] = {"S0": simulation.target}
    for step in range(1, STEPS + 1):
        simulation.step()
        fields[f"S{step}"] = simulation.target
    fields["SA"] = simulation.accumulated
    commands = [_COMMAND.format(SCENE, step) for step in (*range(STEPS + 1), STEPS)]
    return {"snapshots": snapshot_data(scene, fields, commands)}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    snapshots = without_walls(data["snapshots"])
    figure = Figure(figsize=(COLUMN, 0.78 * COLUMN), layout="constrained")
    for axes, name in zip(figure.subplots(2, 3).flat, snapshots["snapshot"].values):
        draw_snapshot(axes, snapshots, str(name), window_of(snapshots, REACH))
        axes.set_title(f"$S_{{{str(name)[1:]}}}$")
    return {"": figure}


def window_of(data: xr.Dataset, reach: int) -> tuple[float, float, float, float]:
    """Left, right, bottom and top [m] of the cells within `reach` of the scene's lit one."""
    scene = parse_scene(data.attrs["scene"])
    x, y = scene.grid.cell_center(scene.lights[0].cell)  # type: ignore[attr-defined]
    half = (reach + 0.5) * scene.grid.spacing
    return x - half, x + half, y - half, y + half


def without_walls(data: xr.Dataset) -> xr.Dataset:
    """The same data, of a scene that has lost its walls: they had no effect, and are not drawn."""
    scene = str(data.attrs["scene"]).partition("[[occluder]]")[0]
    return data.assign_attrs(scene=scene)
