"""The grid's border, face by face: where light comes in from outside."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.blocking import exact_transmittance
from flatland.grid import Grid
from flatland.sources import Wall

Array = NDArray[np.float64]


class Side(NamedTuple):
    """A side of the grid. inward: unit vector (dimension,). cells: (dimension, K) along it.

    open_shares: (K,), how much of the light from outside gets past walls into each cell.
    """

    axis: int
    upper: bool
    inward: Array
    cells: NDArray[np.int64]
    open_shares: Array


def border_sides(grid: Grid, walls: Sequence[Wall] = ()) -> list[Side]:
    """All sides, lower before upper.

    The open share of a border cell is that of its link to the cell outside, the same both ways
    (flatland.blocking): it counts the walls on the border and in the outer half of the cell, and
    the links between cells count the rest, so that every wall is met once. What it gets wrong: it
    looks along the axis, whatever the direction of the light.
    """
    inward = (
        np.repeat(np.eye(grid.dimension), 2, axis=0) * np.tile([1, -1], grid.dimension)[:, None]
    )
    shares = exact_transmittance(grid, walls, -inward.astype(int)) if walls else None
    sides = []
    for number, direction in enumerate(inward):
        axis, upper = number // 2, bool(number % 2)
        ranges = [np.arange(n) for n in grid.shape]
        ranges[axis] = ranges[axis][-1:] if upper else ranges[axis][:1]
        cells = np.stack([index.ravel() for index in np.meshgrid(*ranges, indexing="ij")])
        open_ = np.ones(cells.shape[1]) if shares is None else shares[(number, *cells)]
        sides.append(Side(axis, upper, direction, cells, open_))
    return sides
