"""The faces of cells as panels, cut where walls meet them.

Light jumps on a face where a wall passes through it, or stands on it: there quadrature would
converge slowly, so there faces are split. A wall that lies in a face needs no cut: light that
arrives on it counts, and none starts from it.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from flatland.grid import Grid
from propagators.analytic_3d.panels import Panels, quads_of
from propagators.analytic_3d.plates import TOUCH, Plates

Array = NDArray[np.float64]
#: Axis, plane and place of a face, counted in cells along the other two axes in cyclic order.
Face = tuple[int, int, int, int]
#: Segments (4,) in a face's plane, by face.
Cuts = dict[Face, list[Array]]

#: Cells. A cut this close to a corner leaves it where it is.
_CLOSE = 1e-9


def cell_faces(grid: Grid) -> Panels:
    """The six faces of every cell, its outward normals, cells in order."""
    cells = np.moveaxis(np.indices(grid.shape), 0, -1).reshape(-1, 3)
    squares, normals = [], []
    for axis in range(3):
        for side in (0, 1):
            squares.append(_square(axis, side))
            normals.append((2 * side - 1) * np.eye(3)[axis])
    corners = cells[:, None, None] + np.array(squares)[None]
    count = len(cells)
    return Panels(
        corners.reshape(-1, 4, 3).astype(float),
        np.tile(normals, (count, 1)).astype(float),
        np.repeat(np.arange(count), 6),
    )


def cut_faces(grid: Grid, walls: Plates) -> Panels:
    """The same, with faces in parts where walls pass through them."""
    whole = cell_faces(grid)
    cuts = _all_cuts(grid, walls)
    if not cuts:
        return whole
    index = np.arange(grid.cell_count).reshape(grid.shape)
    kept = np.ones(len(whole.groups), bool)
    corners, normals, groups = [], [], []
    for (axis, plane, i, j), segments in cuts.items():
        parts = _split_square(np.array([i, j], float), segments)
        for side in (0, 1):
            cell = np.empty(3, int)
            cell[[axis, (axis + 1) % 3, (axis + 2) % 3]] = plane - side, i, j
            if not 0 <= cell[axis] < grid.shape[axis]:
                continue
            group = int(index[tuple(cell)])
            kept[6 * group + 2 * axis + side] = False
            for quad in (quad for part in parts for quad in quads_of(part)):
                corners.append(_in_space(quad if side else quad[::-1], axis, plane))
                normals.append((2 * side - 1) * np.eye(3)[axis])
                groups.append(group)
    rest = whole.chosen(kept)
    return Panels(
        np.concatenate([rest.corners, np.array(corners)]),
        np.concatenate([rest.normals, np.array(normals)]),
        np.concatenate([rest.groups, np.array(groups)]),
    )


def _square(axis: int, side: int) -> Array:
    flat = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    return _in_space(flat if side else flat[::-1], axis, side)


def _in_space(flat: Array, axis: int, plane: int) -> Array:
    """Points (..., 2) along the axes after `axis`, in its plane."""
    result = np.empty((*flat.shape[:-1], 3))
    result[..., axis] = plane
    result[..., (axis + 1) % 3], result[..., (axis + 2) % 3] = flat[..., 0], flat[..., 1]
    return result


def _all_cuts(grid: Grid, walls: Plates) -> Cuts:
    cuts: Cuts = defaultdict(list)
    for p in range(len(walls.planes)):
        vertices = walls.vertices[walls.first[p] : walls.first[p + 1]]
        for axis in range(3):
            low, high = walls.low[p, axis], walls.high[p, axis]
            if high - low <= TOUCH:
                continue
            planes = np.arange(np.ceil(low - TOUCH), np.floor(high + TOUCH) + 1).astype(int)
            for plane in planes[(planes >= 0) & (planes <= grid.shape[axis])]:
                segment = _section(vertices, axis, float(plane))
                if segment is not None:
                    _add_cuts(cuts, axis, int(plane), segment, grid)
    return cuts


def _section(vertices: Array, axis: int, plane: float) -> Array | None:
    """The segment (4,) that a convex polygon has in common with a grid plane, if it has length."""
    heights = vertices[:, axis] - plane
    heights = np.where(np.abs(heights) <= TOUCH, 0.0, heights)
    after, following = np.roll(heights, -1), np.roll(vertices, -1, axis=0)
    crosses = heights * after < 0
    share = np.where(crosses, heights / np.where(crosses, heights - after, 1.0), 0.0)[:, None]
    points = (vertices + share * (following - vertices))[crosses | (heights == 0)]
    flat = points[:, [(axis + 1) % 3, (axis + 2) % 3]]
    if len(flat) < 2:
        return None
    extent = np.ptp(flat, axis=0)
    order = np.argsort(flat[:, int(np.argmax(extent))])
    return np.concatenate([flat[order[0]], flat[order[-1]]]) if extent.max() > _CLOSE else None


def _add_cuts(cuts: Cuts, axis: int, plane: int, segment: Array, grid: Grid) -> None:
    """Adds a segment to each face whose inside it crosses."""
    start, extent = segment[:2], segment[2:] - segment[:2]
    stops = [0.0, 1.0]
    for i in range(2):
        if abs(extent[i]) > TOUCH:
            low, high = sorted((start[i], start[i] + extent[i]))
            lines = np.arange(np.ceil(low), np.floor(high) + 1)
            stops += ((lines - start[i]) / extent[i]).tolist()
    inner = np.unique(np.clip(stops, 0.0, 1.0))
    middles = start + 0.5 * (inner[1:] + inner[:-1])[:, None] * extent
    limits = grid.shape[(axis + 1) % 3], grid.shape[(axis + 2) % 3]
    for middle, length in zip(middles, np.diff(inner) * np.linalg.norm(extent)):
        place = np.floor(middle)
        # Along the border between two faces it cuts neither.
        inside = np.all(np.abs(middle - np.rint(middle)) > TOUCH) and length > _CLOSE
        if inside and np.all((place >= 0) & (place < limits)):
            cuts[axis, plane, int(place[0]), int(place[1])].append(segment)


def _split_square(corner: Array, segments: list[Array]) -> list[Array]:
    """A unit square in convex parts that no segment passes through."""
    parts = [corner + np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)]
    for segment in segments:
        normal = np.array([segment[1] - segment[3], segment[2] - segment[0]])
        normal = normal / np.linalg.norm(normal)
        parts = [new for part in parts for new in _split(part, segment, normal)]
    return parts


def _split(part: Array, segment: Array, normal: Array) -> list[Array]:
    """A convex polygon split along a segment's line, if the segment passes through it."""
    heights = (part - segment[:2]) @ normal
    heights = np.where(np.abs(heights) <= _CLOSE, 0.0, heights)
    if heights.min() >= 0 or heights.max() <= 0:
        return [part]
    halves: tuple[list[Array], list[Array]] = ([], [])
    crossings = []
    for i, (point, here) in enumerate(zip(part, heights)):
        before = heights[i - 1]
        if before * here < 0:
            crossings.append(part[i - 1] + before / (before - here) * (point - part[i - 1]))
            halves[0].append(crossings[-1])
            halves[1].append(crossings[-1])
        if here == 0:
            crossings.append(point)
        if here >= 0:
            halves[0].append(point)
        if here <= 0:
            halves[1].append(point)
    along = np.array([normal[1], -normal[0]])
    ends = np.sort([segment[:2] @ along, segment[2:] @ along])
    reach = np.sort(np.array(crossings) @ along)
    if min(ends[1], reach[-1]) - max(ends[0], reach[0]) <= _CLOSE:
        return [part]
    return [np.array(half) for half in halves]
