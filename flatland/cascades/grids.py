"""Where the grids of a cascade lie."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral

import numpy as np

from flatland.errors import bad_input
from flatland.grid import Grid

#: Fewer cells a side leave no room for the next finer grid and a border to fade over.
LEAST_CELLS = 4


def most_cascade_levels(grid: Grid, cells: int) -> int:
    """Grids of so many cells a side until one covers the whole grid, and no more."""
    most = 1
    while cells * 2 ** (most - 1) < max(grid.shape):
        most += 1
    return most


def cascade_grids(grid: Grid, levels: int, cells: int, focus: Sequence[float]) -> tuple[Grid, ...]:
    """Grids of `cells` along every axis, finest first, whose spacing doubles from the given one's.

    grid: of the scene; its cells are the finest level's. focus: world position [m] that all grids
    lie round. Each of them begins on a cell of the next coarser one, so that it moves by two of
    its own cells at a time (Kaplanyan & Dachsbacher 2010, 4.2, move by one, which lets borders
    cut coarse cells), and is shifted by as little as it takes to stay within the next coarser one
    and, as far as it fits, within the scene's grid.
    Raises InputError for numbers of levels or cells that cannot be, and for a focus outside.
    """
    _check(grid, levels, cells, focus)
    centre = grid.to_cells(focus)
    shape, grids = np.array(grid.shape), []
    # A focus on the upper border belongs to the last cell: there is none beyond.
    inner_start = np.minimum(np.floor(centre).astype(np.int64), shape - 1)
    inner_stop = inner_start + 1
    for level in range(levels):
        size, snap = cells * 2**level, 2 ** (level + 1)
        start = np.round((centre - size / 2) / snap) * snap
        # Within the scene, or round it if it is smaller.
        room = shape - size
        start = np.clip(start, np.ceil(np.minimum(room, 0) / snap) * snap, None)
        start = np.minimum(start, np.floor(np.maximum(room, 0) / snap) * snap)
        # Round the next finer one, which is more.
        start = np.maximum(start, np.ceil((inner_stop - size) / snap) * snap)
        start = np.minimum(start, np.floor(inner_start / snap) * snap).astype(np.int64)
        inner_start, inner_stop = start, start + size
        corner = tuple(grid.to_world(start.astype(float)).tolist())
        grids.append(Grid((cells,) * grid.dimension, grid.spacing * 2**level, corner))
    return tuple(grids)


def _check(grid: Grid, levels: int, cells: int, focus: Sequence[float]) -> None:
    whole = isinstance(cells, Integral) and not isinstance(cells, bool)
    if not whole or cells < LEAST_CELLS or cells % 2:
        raise bad_input("cells", cells, f"must be an even number, at least {LEAST_CELLS}")
    most = most_cascade_levels(grid, int(cells))
    whole = isinstance(levels, Integral) and not isinstance(levels, bool)
    if not whole or not 1 <= levels <= most:
        rule = f"must be a whole number, 1 to {most}: {cells * 2 ** (most - 1)} cells of the finest"
        raise bad_input("levels", levels, f"{rule} grid cover the scene")
    place = np.asarray(focus, float)
    if place.shape != (grid.dimension,) or not np.all(np.isfinite(place)):
        raise bad_input("focus", focus, f"must be {grid.dimension} finite numbers")
    if not grid.contains(place):
        raise bad_input("focus", focus, "must lie in the scene's grid")
