"""The first surface that a finite ray meets, cell by cell."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inlined, inner
from propagators.transport.cell_items import CellItems, Items

Vector = NDArray[np.float64]

#: Cells. A ray does not meet what it starts on, but meets what it ends on: where one ray ends and
#: the next begins, nothing is skipped or seen twice.
TOUCH = 1e-9
#: Of a part's length, so that no ray slips through between two parts that share an end.
_SLACK = 1e-12


def parts_by_cell(items: CellItems, shape: tuple[int, int]) -> Items:
    """What a ray in a cell can meet: the parts in it and on its faces."""
    nx, ny = shape
    cell = np.repeat(np.arange(nx * ny), np.diff(items.cells.first))
    places, rows = [cell], [np.arange(len(cell))]
    segments = [items.cells.segments, items.x_faces.segments, items.y_faces.segments]
    ends = [items.cells.ends, items.x_faces.ends, items.y_faces.ends]
    offset = len(cell)
    for axis, faces in enumerate((items.x_faces, items.y_faces)):
        face = np.repeat(np.arange(len(faces.first) - 1), np.diff(faces.first))
        i, j = np.divmod(face, ny + axis)
        for back in (1, 0):
            a, b = (i - back, j) if axis == 0 else (i, j - back)
            inside = (a >= 0) & (a < nx) & (b >= 0) & (b < ny)
            places.append((a * ny + b)[inside])
            rows.append(offset + np.flatnonzero(inside))
        offset += len(face)
    place, row = np.concatenate(places), np.concatenate(rows)
    order = np.argsort(place, kind="stable")
    first = np.searchsorted(place[order], np.arange(nx * ny + 1))
    chosen = row[order]
    return Items(first, np.concatenate(segments)[chosen], np.concatenate(ends)[chosen])


@inner
def cast(x0: float, y0: float, x1: float, y1: float, nx: int, ny: int, parts: Items) -> int:
    """2 e + side of the first segment that the ray from (x0, y0) to (x1, y1) meets, or -1.

    side: the one that the ray comes to, 0 for left. parts: as from `parts_by_cell`.
    """
    dx, dy = x1 - x0, y1 - y0
    length = math.sqrt(dx * dx + dy * dy)
    if length <= TOUCH:
        return -1
    low, high = _clip(x0, dx, nx, 0.0, 1.0)
    low, high = _clip(y0, dy, ny, low, high)
    if low > high:
        return -1
    i = min(max(math.floor(x0 + low * dx), 0), nx - 1)
    j = min(max(math.floor(y0 + low * dy), 0), ny - 1)
    step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    pace_x = abs(1.0 / dx) if dx != 0.0 else math.inf
    pace_y = abs(1.0 / dy) if dy != 0.0 else math.inf
    next_x = (i + (1 if dx > 0.0 else 0) - x0) / dx if dx != 0.0 else math.inf
    next_y = (j + (1 if dy > 0.0 else 0) - y0) / dy if dy != 0.0 else math.inf
    start, stop = TOUCH / length, 1.0 + TOUCH / length
    while True:
        cell = i * ny + j
        if parts.first[cell] != parts.first[cell + 1]:
            found = _nearest(x0, y0, dx, dy, start, stop, cell, parts)
            if found >= 0:
                return found
        if next_x < next_y:
            if next_x > high:
                return -1
            i += step_x
            next_x += pace_x
            if i < 0 or i >= nx:
                return -1
        else:
            if next_y > high:
                return -1
            j += step_y
            next_y += pace_y
            if j < 0 or j >= ny:
                return -1


@inlined
def _clip(origin: float, way: float, size: int, low: float, high: float) -> tuple[float, float]:
    """The part of [low, high] along a ray that lies between 0 and size."""
    if way == 0.0:
        return (low, high) if 0.0 <= origin <= size else (1.0, 0.0)
    a, b = -origin / way, (size - origin) / way
    return max(low, min(a, b)), min(high, max(a, b))


@inlined
def _nearest(
    x: float, y: float, dx: float, dy: float, start: float, stop: float, cell: int, parts: Items
) -> int:
    found = -1
    for k in range(parts.first[cell], parts.first[cell + 1]):
        part = parts.ends[k]
        ex, ey = part[2] - part[0], part[3] - part[1]
        across = dx * ey - dy * ex
        if across == 0.0:
            continue
        ox, oy = part[0] - x, part[1] - y
        way = (ox * ey - oy * ex) / across
        share = (ox * dy - oy * dx) / across
        if start < way <= stop and -_SLACK <= share <= 1.0 + _SLACK:
            stop = way
            # The ray comes to the left side if it goes to the right of start -> stop.
            found = 2 * parts.segments[k] + (0 if across > 0.0 else 1)
    return found
