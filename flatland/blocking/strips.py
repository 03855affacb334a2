"""Beams in 2D: strips one cell, or the diagonal of one, wide, and what segments do to them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flatland.blocking.covers import Covers
from flatland.blocking.intervals import open_shares
from flatland.blocking.tiles import cut_tiles
from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.sources import Segment

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

#: Coordinates this close (in beam sizes: cells, or their diagonals) to a multiple of 1/2 are
#: rounding: walls on grid lines and through centres lie exactly there.
SNAP = 1e-9
#: Cells around the grid that links out of it reach into, and one more.
_MARGIN = 2.0


class Strips:
    """What segments do to the beams of a grid in 2D."""

    def __init__(self, grid: Grid, segments: Sequence[Segment]) -> None:
        self.shape = grid.shape
        self._walls, self._origin = clipped_walls(grid, segments)

    def links(self, direction: Cells) -> tuple[Cells, Array]:
        """Links along a forward direction that walls meet: source cells (U, 2), open shares (U,).

        Sources lie in the grid or in the ring of cells around it.
        """
        cells, spans, sides, _ = _records(self._walls, direction)
        near = np.all((cells >= -1) & (cells <= self.shape), axis=1)
        padded = (self.shape[0] + 2, self.shape[1] + 2)
        numbers = np.ravel_multi_index(tuple(cells[near].T + 1), padded).astype(np.int64)
        links, shares = open_shares(numbers, spans[near], sides[near])
        return np.stack(np.unravel_index(links, padded), axis=1) - 1, shares

    def covers(self, direction: Cells) -> Covers:
        """What each wall does to each beam along a forward direction."""
        cells, spans, _, numbers = _records(self._walls, direction)
        along = np.diff(self._walls, axis=1)[:, 0]
        normals = np.stack([-along[:, 1], along[:, 0]], axis=1)
        # A wall without length stops nothing.
        normals /= np.maximum(np.hypot(*normals.T), np.finfo(float).tiny)[:, None]
        return Covers(cells, np.diff(spans)[:, 0], self._origin[numbers], normals[numbers])


def _walls(grid: Grid, segments: Sequence[Segment]) -> Array:
    """Ends (S, 2, 2) in cell units."""
    if len(segments) == 0:
        return np.empty((0, 2, 2))
    ends = np.array([(segment.start, segment.stop) for segment in segments], float)
    if ends.shape[1:] != (2, 2) or not np.all(np.isfinite(ends)):
        raise bad_input("segments", segments, "must have two finite coordinates at each end")
    return grid.to_cells(ends)


def clipped_walls(grid: Grid, segments: Sequence[Segment]) -> tuple[Array, Cells]:
    """The parts of walls near the grid (S, 2, 2) in cell units, and which segments they are (S,).

    Ends far away cost work and digits.
    """
    walls, shape = _walls(grid, segments), grid.shape
    start, stop = walls[:, 0], walls[:, 1]
    with np.errstate(all="ignore"):
        one = (-_MARGIN - start) / (stop - start)
        other = (np.array(shape) + _MARGIN - start) / (stop - start)
    # fmin and fmax: 0/0 where a wall runs along the border, which limits nothing.
    first = np.maximum(np.fmin(one, other).max(axis=1), 0.0)
    last = np.minimum(np.fmax(one, other).min(axis=1), 1.0)
    near = first < last
    start, stop, first, last = start[near], stop[near], first[near, None], last[near, None]
    # Ends that stay are kept to the last bit.
    enter = np.where(first > 0, start + first * (stop - start), start)
    leave = np.where(last < 1, start + last * (stop - start), stop)
    return np.stack([enter, leave], axis=1), np.flatnonzero(near)


def _records(walls: Array, direction: Cells) -> tuple[Cells, Array, NDArray[np.uint8], Cells]:
    """What each wall does to each beam along a forward direction.

    Returns source cells (M, 2), spans (M, 2), sides (M,) and numbers of walls (M,), see
    `cut_tiles`. Axial beams tile the plane. Diagonal ones are twice as dense: those that start on
    cells of one colour of a chessboard tile it, and those of the other colour do so again.
    """
    side = np.array([-direction[1], direction[0]])
    axes = np.stack([direction, side])
    size = int(direction @ direction)
    parts = []
    for first in np.array([(0, 0), (0, 1)])[:size]:
        # In this frame the first cell's centre lies at (0, 1/2).
        frame = (walls - first - 0.5) @ axes.T / size + (0.0, 0.5)
        tiles, *rest = cut_tiles(_snapped(frame).reshape(-1, 4))
        parts.append((first + tiles @ axes, *rest))
    cells, spans, sides, numbers = (np.concatenate(column) for column in zip(*parts))
    return cells, spans, sides, numbers


def _snapped(coordinates: Array) -> Array:
    nearest = np.round(2 * coordinates) / 2
    return np.where(np.abs(coordinates - nearest) <= SNAP, nearest, coordinates)
