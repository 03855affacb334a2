"""Segments cut at grid lines: which parts lie in which cell, and which on which face."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Cells; parts shorter than this are left out.
SPECK = 1e-13


class Items(NamedTuple):
    """Parts of segments by place; those at place k are first[k] … first[k + 1] - 1.

    segments: (K,), which one each is a part of. ends: (K, 4), start and stop in the segment's
    direction, in cells.
    """

    first: Counts
    segments: Counts
    ends: Array


class CellItems(NamedTuple):
    """Parts inside cells (i, j), place i ny + j, and on faces.

    x_faces: on the line x = i in row j, place i ny + j, i = 0 … nx. y_faces: on the line y = j in
    column i, place i (ny + 1) + j, j = 0 … ny.
    """

    cells: Items
    x_faces: Items
    y_faces: Items


def items_in_cells(segments: Array, shape: tuple[int, int]) -> CellItems:
    """Cut segments (S, 4), which lie in the grid, at all grid lines.

    What lies on a grid line belongs to its faces, and to no cell.
    """
    owners, ends = _cut_at_lines(segments)
    nx, ny = shape
    middle = 0.5 * (ends[:, :2] + ends[:, 2:])
    i, j = (
        np.clip(np.floor(middle[:, axis]).astype(np.int64), 0, shape[axis] - 1) for axis in (0, 1)
    )
    # A segment on a grid line has the same whole number at both ends.
    whole = segments == np.rint(segments)
    on_x = (whole[:, 0] & (segments[:, 0] == segments[:, 2]))[owners]
    on_y = (whole[:, 1] & (segments[:, 1] == segments[:, 3]))[owners]
    inside = ~(on_x | on_y)
    lines = np.rint(middle).astype(np.int64)
    return CellItems(
        _by_place(i * ny + j, nx * ny, owners, ends, inside),
        _by_place(lines[:, 0] * ny + j, (nx + 1) * ny, owners, ends, on_x),
        _by_place(i * (ny + 1) + lines[:, 1], nx * (ny + 1), owners, ends, on_y),
    )


def _cut_at_lines(segments: Array) -> tuple[Counts, Array]:
    """Parts (K,) of which segment, and their ends (K, 4)."""
    count = len(segments)
    places = [np.zeros(count), np.ones(count)]
    owners = [np.arange(count), np.arange(count)]
    exact = [np.full((2 * count, 2), np.nan)]
    for axis in (0, 1):
        start, stop = segments[:, axis], segments[:, 2 + axis]
        first = np.floor(np.minimum(start, stop)).astype(np.int64) + 1
        last = np.ceil(np.maximum(start, stop)).astype(np.int64) - 1
        crossed = np.maximum(last - first + 1, 0)
        owner = np.repeat(np.arange(count), crossed)
        step = np.arange(len(owner)) - np.repeat(np.cumsum(crossed) - crossed, crossed)
        line = (first[owner] + step).astype(float)
        places.append((line - start[owner]) / (stop - start)[owner])
        owners.append(owner)
        on_line = np.full((len(owner), 2), np.nan)
        on_line[:, axis] = line
        exact.append(on_line)
    place, owner = np.concatenate(places), np.concatenate(owners)
    order = np.lexsort((place, owner))
    place, owner = place[order], owner[order]
    extent = segments[owner, 2:] - segments[owner, :2]
    points = np.where(place[:, None] == 1.0, segments[owner, 2:], np.nan)
    points = np.where(np.isnan(points), segments[owner, :2] + place[:, None] * extent, points)
    known = np.concatenate(exact)[order]
    points = np.where(np.isnan(known), points, known)
    same = owner[1:] == owner[:-1]
    length = np.hypot(*(points[1:] - points[:-1]).T)
    kept = np.flatnonzero(same & (length > SPECK))
    return owner[kept], np.hstack([points[kept], points[kept + 1]])


def _by_place(
    places: Counts, count: int, owners: Counts, ends: Array, chosen: NDArray[np.bool_]
) -> Items:
    rows = np.flatnonzero(chosen)
    rows = rows[np.argsort(places[rows], kind="stable")]
    first = np.searchsorted(places[rows], np.arange(count + 1))
    return Items(first, owners[rows], np.ascontiguousarray(ends[rows]))
