"""The grid's border, face by face: where light comes in from outside."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.blocking import exact_transmittance
from flatland.grid import Grid
from flatland.moved_segments import ON_BORDER
from flatland.sources import Wall, segments_of

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


def open_stretches(grid: Grid, walls: Sequence[Wall], side: Side) -> list[tuple[Array, Array]]:
    """The parts of a side in 2D that no wall lies on, as start and stop [m], inside on the left."""
    place, along = (grid.shape[side.axis] if side.upper else 0), 1 - side.axis
    ends = np.array([(wall.start, wall.stop) for wall in segments_of(walls)], float).reshape(
        -1, 2, 2
    )
    cells = grid.to_cells(ends)
    lying = np.all(np.abs(cells[..., side.axis] - place) <= ON_BORDER, axis=1)
    covers = np.sort(np.clip(cells[lying][..., along], 0, grid.shape[along]), axis=1)
    stretches, reached = [], 0.0
    for low, high in [*sorted(covers.tolist()), [float(grid.shape[along])] * 2]:
        if low - reached > ON_BORDER:
            stretches.append((reached, low))
        reached = max(reached, high)
    corners = np.full((len(stretches), 2, 2), float(place))
    corners[..., along] = np.reshape(stretches, (-1, 2))
    # Counter-clockwise round the grid: up the right side, down the left one.
    backwards = side.upper == (side.axis == 1)
    return [(b, a) if backwards else (a, b) for a, b in grid.to_world(corners)]
