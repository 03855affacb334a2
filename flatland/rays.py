"""How far rays get among walls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.facets import FacetTable, facet_table
from flatland.grid import Grid
from flatland.moved_segments import ON_BORDER
from flatland.sources import Facet, Wall, facets_of, segments_of

Array = NDArray[np.float64]

_kernel = njit(cache=True, error_model="numpy", nogil=True)


def free_lengths(grid: Grid, walls: Sequence[Wall], origins: Array, directions: Array) -> Array:
    """Length (M,) [m] of rays up to the first wall, or to the grid's border.

    origins: (M, dimension) [m], in the grid. directions: unit vectors (M, dimension). A wall that a
    ray starts on does not stop it: hits within 1e-9 cells of the start are left out. Walls are that
    much wider than they are, so that no ray slips through between two that share an edge.
    """
    starts = grid.to_cells(origins)
    lengths = _to_border(starts, directions, np.array(grid.shape, float))
    if walls:
        table = _table(grid, walls)
        flat = np.zeros((len(starts), 3 - grid.dimension))
        # In 2D everything lies in the plane z = 0.
        rays = (np.column_stack([part, flat]) for part in (starts, directions))
        _shorten(*(np.ascontiguousarray(r) for r in rays), *table, ON_BORDER, lengths)
    return np.asarray(lengths * grid.spacing)


def _table(grid: Grid, walls: Sequence[Wall]) -> FacetTable:
    """Facets in cell units; segments stand upright."""
    if grid.dimension == 3:
        return facet_table(grid, facets_of(walls))
    ends = np.array([(wall.start, wall.stop) for wall in segments_of(walls)])
    upright = Grid((*grid.shape, 1), grid.spacing, (*grid.origin, 0.0))
    side = np.full((len(ends), 2, 1), grid.spacing)
    lower, upper = (np.concatenate([ends, height], axis=2) for height in (-side, side))
    quads = np.concatenate([lower, upper[:, ::-1]], axis=1)
    return facet_table(upright, [Facet(quad, np.zeros(1)) for quad in quads])


def _to_border(starts: Array, directions: Array, shape: Array) -> Array:
    """Ways (M,) to the grid's border [cells]; zero for rays that leave it at once."""
    moves = directions != 0
    speed = np.where(moves, directions, 1.0)
    ways = (np.where(directions > 0, shape, 0.0) - starts) / speed
    return np.maximum(0.0, np.where(moves, ways, np.inf).min(axis=1))


@_kernel
def _shorten(
    starts: Array,
    directions: Array,
    corners: Array,
    first: NDArray[np.int64],
    normals: Array,
    slack: float,
    lengths: Array,
) -> None:
    """Cut rays off at the first facet; all in cells."""
    point = np.empty(3)
    for f in range(normals.shape[0]):
        n, origin = normals[f], corners[first[f]]
        # The two axes that the facet is widest along.
        across = 0 if abs(n[0]) >= max(abs(n[1]), abs(n[2])) else 1 if abs(n[1]) >= abs(n[2]) else 2
        u, v = (across + 1) % 3, (across + 2) % 3
        for m in range(starts.shape[0]):
            slope, height = 0.0, 0.0
            for i in range(3):
                slope += n[i] * directions[m, i]
                height += n[i] * (origin[i] - starts[m, i])
            if slope == 0.0:
                continue
            way = height / slope
            if not slack < way < lengths[m]:
                continue
            for i in range(3):
                point[i] = starts[m, i] + way * directions[m, i]
            if _within(corners, first[f], first[f + 1], u, v, point[u], point[v], slack):
                lengths[m] = way


@_kernel
def _within(
    corners: Array, begin: int, end: int, u: int, v: int, x: float, y: float, slack: float
) -> bool:
    """Whether a loop runs round (x, y), by counting crossings, or comes within slack of it."""
    inside = False
    for k in range(begin, end):
        following = k + 1 if k + 1 < end else begin
        ax, ay = corners[k, u] - x, corners[k, v] - y
        bx, by = corners[following, u] - x, corners[following, v] - y
        dx, dy = bx - ax, by - ay
        square = dx * dx + dy * dy
        part = min(max(-(ax * dx + ay * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
        if (ax + part * dx) ** 2 + (ay + part * dy) ** 2 <= slack * slack:
            return True
        if (ay > 0.0) != (by > 0.0) and (ax * dy - ay * dx) * dy > 0.0:
            inside = not inside
    return inside
