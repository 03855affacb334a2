"""Lines where an octree's levels meet (the octree thesis draws them bolder in its figure 14)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

Array = NDArray[np.float64]


def level_borders(index: NDArray[np.integer]) -> Array:
    """Sides of cells between neighbours of different levels, (M, 2, 2) in cells; index (nx, ny)."""
    right = np.argwhere(index[:-1] != index[1:]) + np.array([1, 0])
    above = np.argwhere(index[:, :-1] != index[:, 1:]) + np.array([0, 1])
    upright = np.stack([right, right + np.array([0, 1])], axis=1)
    level = np.stack([above, above + np.array([1, 0])], axis=1)
    return np.concatenate([upright, level]).astype(float)


def draw_level_borders(
    axes: Axes, index: NDArray[np.integer], extent: tuple[float, float, float, float]
) -> None:
    """Draw them into axes; extent: left, right, bottom and top of the grid."""
    left, right, bottom, top = extent
    size = np.array([right - left, top - bottom]) / index.shape
    lines = level_borders(index) * size + np.array([left, bottom])
    # Two lines, so that they show on bright and on dark cells.
    for colour, width in (("white", 1.4), ("black", 0.7)):
        axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=width))
