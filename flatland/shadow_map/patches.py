"""Lit parts of a map cut where the surface, moved half a cell, passes from cell to cell."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.moved_segments import ON_BORDER
from flatland.shadow_map.convex import ROOM, Polygons, copy, kernel, linear, roomier, split
from flatland.shadow_map.facet_views import ANY_CELL, FacetView
from flatland.shadow_map.visible import slack_of

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Parts that may wait to be cut: each cut halves a range of cells along one of three axes.
MOST_WAITING = 256


def cut_by_cells(polygons: Polygons, view: FacetView, parts: int = 1) -> Polygons:
    """Lit parts, cut; tags: row, tile, and the cell before it along each axis.

    parts: per side of a cell; other than 1, cells are counted in these parts.
    """
    vertices, tags = _cut(
        polygons.vertices,
        polygons.first,
        polygons.tags,
        view.places,
        view.scales,
        view.front,
        parts,
        slack_of(view),
    )
    return Polygons(vertices, np.concatenate([[0], tags[:, 0]]), np.ascontiguousarray(tags[:, 1:]))


@kernel
def _cut(
    vertices: Array,
    first: Indices,
    tags: Indices,
    places: Array,
    scales: Array,
    front: Indices,
    parts: int,
    slack: float,
) -> tuple[Array, Indices]:
    room = tags.shape[0] + 1
    found, labels = np.empty((vertices.shape[0] + ROOM, 2)), np.empty((room, 6), np.int64)
    used, corners = 0, 0
    # What waits: vertices; their number, the axis to cut along next, the cell along those before.
    shapes, state = np.empty((MOST_WAITING * ROOM, 2)), np.empty((MOST_WAITING, 5), np.int64)
    work, line = np.empty((3, ROOM, 2)), np.empty(3)
    for k in range(tags.shape[0]):
        row = tags[k, 0]
        copy(vertices, first[k], first[k + 1], shapes, 0)
        state[0, 0], state[0, 1], waiting = first[k + 1] - first[k], 0, 1
        while waiting:
            top = waiting - 1
            count, axis = state[top, 0], state[top, 1]
            copy(shapes, top * ROOM, top * ROOM + count, work[0], 0)
            if axis == 3:
                found = roomier(found, corners, corners + ROOM)
                labels = roomier(labels, used, used + 1)
                corners = copy(work[0], 0, count, found, corners)
                labels[used, 0], labels[used, 1], labels[used, 2] = corners, row, tags[k, 1]
                for i in range(3):
                    labels[used, 3 + i] = state[top, 2 + i]
                used, waiting = used + 1, top
                continue
            low, high = front[row, axis], front[row, axis]
            if low == ANY_CELL:
                low, high = _cells_over(work[0], count, places[row, axis], scales[row], parts)
            middle = low + (high - low + 1) // 2
            m, n = 0, 0
            if high > low:
                for i in range(3):
                    line[i] = places[row, axis, i] - middle / parts * scales[row, i]
                size = max(np.hypot(line[0], line[1]), 1e-300)
                for i in range(3):
                    line[i] /= size
                m, n = split(work[0], count, line, slack, work[1], work[2])
            if m and n:
                copy(work[2], 0, n, shapes, top * ROOM)
                copy(work[1], 0, m, shapes, waiting * ROOM)
                copy(state, top, waiting, state, waiting)
                state[top, 0], state[waiting, 0] = n, m
                waiting += 1
            else:
                # One cell, or the rest of it is too thin to be cut off.
                state[top, 2 + axis] = middle - 1 if n else middle
                state[top, 1] += 1
    return found[:corners], labels[:used]


@kernel
def _cells_over(
    polygon: Array, count: int, place: Array, scale: Array, parts: int
) -> tuple[int, int]:
    """First and last cell along an axis; what ends on a border belongs to the cell inside."""
    low, high = np.inf, -np.inf
    for i in range(count):
        x = parts * linear(place, polygon[i]) / linear(scale, polygon[i])
        low, high = min(low, x), max(high, x)
    least = int(np.floor(low + ON_BORDER))
    return least, max(least, int(np.ceil(high - ON_BORDER)) - 1)
