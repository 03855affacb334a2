"""Reading light from a cascade: the finest grid first, faded into the next at its border."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flatland.grid import Grid
from flatland.octree.sampling import sampled

Array = NDArray[np.float64]
#: A border that lies on another to this part of a cell is the same.
_SAME = 1e-6


def looked_up(
    levels: Sequence[Array], grids: Sequence[Grid], scene: Grid, points: Array, width: float
) -> Array:
    """Light (..., size, *points.shape[:-1]) at world points (..., dimension).

    levels: per grid (..., size, *shape), finest first, in units that compare. A level has the
    weight w = clip(d / width, 0, 1), d its own cells between the point and its border, and leaves
    1 − w to the coarser ones; within a level light is interpolated (bi/tri)linearly. So it is
    continuous everywhere in the scene. A side that no coarser grid goes beyond, or that lies on the
    scene's border, has nothing to fade into and counts as far away. What it gets wrong:
    light that only the coarser grid has got is cut off over the width (Kaplanyan & Dachsbacher
    2010, 4.1). Dark outside of the coarsest grid.
    """
    leading = levels[0].shape[: levels[0].ndim - scene.dimension]
    flat = points.reshape(-1, scene.dimension)
    result = np.zeros((*leading, len(flat)))
    rest = np.ones(len(flat))
    for number, (values, grid) in enumerate(zip(levels, grids)):
        coarsest = grids[-1] if number + 1 < len(grids) else None
        share = rest * _weight(grid, coarsest, scene, flat, width)
        used = np.flatnonzero(share)
        places = grid.to_cells(flat[used]).T
        result[..., used] += share[used] * sampled(values, places)
        rest = rest - share
    return result.reshape(*leading, *points.shape[:-1])


def _weight(grid: Grid, coarsest: Grid | None, scene: Grid, points: Array, width: float) -> Array:
    """Share of a level at points (M, dimension), before finer ones have taken theirs."""
    places = grid.to_cells(points)
    size = np.array(grid.shape)
    inside = np.all((places >= 0) & (places <= size), axis=1)
    if coarsest is None:
        return inside.astype(float)
    if width == 0:
        return np.all((places >= 0) & (places < size), axis=1).astype(float)
    depth = np.full(len(points), np.inf)
    for axis in range(grid.dimension):
        if _fades(grid.origin[axis], coarsest.origin[axis], scene.origin[axis], grid.spacing):
            depth = np.minimum(depth, places[:, axis])
        if _fades(-grid.upper[axis], -coarsest.upper[axis], -scene.upper[axis], grid.spacing):
            depth = np.minimum(depth, size[axis] - places[:, axis])
    return np.where(inside, np.clip(depth / width, 0.0, 1.0), 0.0)


def _fades(own: float, coarsest: float, scene: float, cell: float) -> bool:
    """Whether light goes on beyond a lower side: in the coarsest grid, and in the scene."""
    return own - coarsest > _SAME * cell and own - scene > _SAME * cell
