"""Figure 14 of the octree thesis: intensity jumps where levels meet.

The scene `level-jump`, LPV with 2 bands, all levels after 2 iterations: filled with the mean (the
thesis), with the flux, and blended; and the converged uniform grid. The titles give the mean step
of the flux between neighbours across a border, |Φ₁ − Φ₂| over their mean (`studies.level_jumps`);
of the uniform grid, that across the same borders.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flatland.octree import most_levels
from flatland.scene import load_scene
from propagators import create
from studies.figures.level_borders import draw_level_borders
from studies.figures.octree_index import octree_data
from studies.figures.slices import extent_of
from studies.figures.snapshots import draw_maps
from studies.figures.workshop import Workshop
from studies.level_jumps import level_jumps
from studies.running import Method

PARTS = ("fields",)
SCENE, STEPS, TOLERANCE = "level-jump", 2, 1e-8
#: Panel: normalization and blend.
WAYS: dict[str, tuple[str, float | None]] = {
    "mean (thesis)": ("mean", None),
    "flux": ("flux", None),
    "flux, blended": ("flux", 1.0),
}
_UNIFORM = "uniform grid"
_COMMAND = "flatland run {} --bands 2"


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    scene = load_scene(SCENE)
    levels = most_levels(scene.grid.shape)
    runs, commands, jumps = {}, [], []
    for name, (normalization, blend) in WAYS.items():
        method = Method(
            create("lpv"), 2, STEPS, levels=levels, normalization=normalization, blend=blend
        )
        simulation = method.simulation(scene)
        simulation.run(STEPS)
        runs[name] = simulation, blend
        jumps.append(level_jumps(simulation.merge(blend), simulation.index).mean)
        command = f" --iterations {STEPS} --levels {levels} --normalization {normalization}"
        commands.append(_COMMAND.format(SCENE) + command + (f" --blend {blend}" if blend else ""))
    uniform = Method(create("lpv"), 2, converge=TOLERANCE).simulation(scene)
    uniform.solve(TOLERANCE)
    runs[_UNIFORM] = uniform, None
    commands.append(_COMMAND.format(SCENE) + f" --converge {TOLERANCE}")
    borders = runs["flux"][0].index
    jumps.append(level_jumps(uniform.accumulated, borders).mean)
    meaning = "mean relative step of the flux across borders between levels"
    data = octree_data(scene, runs, commands, jump=(jumps, meaning))
    return {"fields": data}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    fields = data["fields"]

    def title(name: str) -> str:
        return f"mean jump {float(fields['jump'].sel(snapshot=name)):.2f}"

    figure, maps = draw_maps(fields, 2, 2, 1.12, title)
    for name, axes in maps.items():
        index = fields["index"].sel(snapshot=name).values
        if np.ptp(index):
            draw_level_borders(axes, index, extent_of(fields))
    return {"": figure}
