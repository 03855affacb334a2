"""What figures of an octree's index volume share: its numbers, drawn into the cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from flatland.scene import Scene
from flatland.simulation import Simulation
from studies.figures.level_borders import draw_level_borders
from studies.figures.snapshots import snapshot_data

Index = NDArray[np.integer]
#: Left, right, bottom and top [m].
Extent = tuple[float, float, float, float]


def octree_data(
    scene: Scene,
    runs: Mapping[str, tuple[Simulation, float | None]],
    commands: Sequence[str],
    **extra: Any,
) -> xr.Dataset:
    """Merged fields of simulations, each with its blend, and the level each cell is read from."""
    fields = {name: run.merge(blend) for name, (run, blend) in runs.items()}
    data = snapshot_data(scene, fields, commands, **extra)
    index = np.array([run.index for run, _ in runs.values()])
    meaning = {"long_name": "level that a cell is read from"}
    data["index"] = (("snapshot", "x", "y"), index, meaning)
    return data


def draw_index(axes: Axes, index: Index, extent: Extent, size: float = 4) -> None:
    """Numbers of levels in cells, darker for coarser ones, with bold borders."""
    top = max(1, int(index.max()))
    axes.imshow(index.T, origin="lower", extent=extent, cmap="Greys", vmin=-0.5, vmax=2 * top)
    left, right, bottom, upper = extent
    wide, high = (right - left) / index.shape[0], (upper - bottom) / index.shape[1]
    for (x, y), level in np.ndenumerate(index):
        where = left + (x + 0.5) * wide, bottom + (y + 0.5) * high
        axes.text(*where, str(level), ha="center", va="center", fontsize=size)
    draw_level_borders(axes, index, extent)
    axes.tick_params(labelsize=5)
