"""Facets cut where they pass from cell to cell: what moved_segments does, in 3D.

No sampling: a facet is clipped to the slabs of cells along each axis in turn (Sutherland & Hodgman
1974), and areas are those of the pieces. A facet need not be convex: clipping then joins pieces by
edges of no width, which have no area.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.grid import Grid
from flatland.moved_segments import ON_BORDER
from flatland.sources import Facet, PolygonSource

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

_kernel = njit(cache=True, error_model="numpy")


class Pieces(NamedTuple):
    """Pieces of facets (K,): which facet each is of, its cell (K, 3), area (K,) in cell sides².

    middles: centroids (K, 3) in cell units. Where a facet that is not convex leaves several parts
    in one cell, they are one piece, and its middle may lie beside them.
    """

    facets: Cells
    cells: Cells
    areas: Array
    middles: Array


class FacetTable(NamedTuple):
    """Facets (F,) as arrays in cell units, for kernels.

    vertices: (T, 3), of which first[f] … first[f + 1] - 1 are facet f's. normals: (F, 3), unit
    vectors, from whose tip vertices run counter-clockwise; zero for a facet without area.
    """

    vertices: Array
    first: Cells
    normals: Array

    def moved(self, distance: float) -> FacetTable:
        """Every facet moved along its normal [cells]."""
        counts = np.diff(self.first)
        shift = distance * np.repeat(self.normals, counts, axis=0)
        return self._replace(vertices=self.vertices + shift)

    def turned(self) -> FacetTable:
        """The same facets with their other side to the front; vertices stay in order."""
        return self._replace(normals=-self.normals)

    @property
    def areas(self) -> Array:
        """Areas (F,) in cell sides²."""
        vectors = [vector_area(part) for part in np.split(self.vertices, self.first[1:-1])]
        return np.linalg.norm(np.reshape(vectors, (-1, 3)), axis=1)[: len(self.normals)]


def facet_table(grid: Grid, facets: Sequence[Facet | PolygonSource]) -> FacetTable:
    """Facets of a scene in cell units."""
    parts = [grid.to_cells(facet.vertices) for facet in facets]
    first = np.cumsum([0, *map(len, parts)]).astype(np.int64)
    vectors = np.array([vector_area(part) for part in parts]).reshape(-1, 3)
    sizes = np.linalg.norm(vectors, axis=1, keepdims=True)
    normals = vectors / np.where(sizes > 0, sizes, 1.0)
    return FacetTable(np.concatenate([np.empty((0, 3)), *parts]), first, normals)


def vector_area(vertices: Array) -> Array:
    """½ Σ v_i x v_{i+1} (3,): the area along the normal round which vertices (V, 3) run."""
    arms = vertices - vertices[0]
    return np.asarray(0.5 * np.cross(arms[1:-1], arms[2:]).sum(axis=0))


def cut_by_cells(table: FacetTable, shape: tuple[int, ...]) -> Pieces:
    """The pieces of facets in each cell of a grid; what lies outside the grid is left out.

    A facet that lies on a border between cells belongs to the cell in front of it.
    """
    return Pieces(*_cut(*table, np.array(shape, np.int64), ON_BORDER))


@_kernel
def _cut(
    vertices: Array, first: Cells, normals: Array, shape: Cells, slack: float
) -> tuple[Cells, Cells, Array, Array]:
    room = 64
    places, found = np.empty((room, 4), np.int64), np.empty((room, 4))
    count = 0
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    piece = np.empty(4)
    for f in range(first.size - 1):
        own = vertices[first[f] : first[f + 1]]
        # Each of six clips adds at most half as many vertices again.
        work = np.empty((4, 12 * own.shape[0] + 16, 3))
        flat = _slab_range(own, normals[f], shape, slack, low, high)
        _measure(own, own.shape[0], normals[f], piece)
        least = 1e-15 * min(1.0, piece[0])
        for i in range(low[0], high[0]):
            n0 = _slab(own, own.shape[0], 0, i, flat, work[3], work[0])
            for j in range(low[1], high[1]):
                n1 = _slab(work[0], n0, 1, j, flat, work[3], work[1])
                for k in range(low[2], high[2]) if n1 > 2 else range(0):
                    n2 = _slab(work[1], n1, 2, k, flat, work[3], work[2])
                    _measure(work[2], n2, normals[f], piece)
                    if piece[0] <= least:
                        continue
                    if count == room:
                        room *= 2
                        places, found = _grown(places, room), _grown(found, room)
                    places[count, 0], found[count] = f, piece
                    places[count, 1], places[count, 2], places[count, 3] = i, j, k
                    count += 1
    places, found = places[:count], found[:count]
    return places[:, 0].copy(), places[:, 1:].copy(), found[:, 0].copy(), found[:, 1:].copy()


@_kernel
def _grown(array: Array, room: int) -> Array:
    wider = np.empty((room, array.shape[1]), array.dtype)
    wider[: array.shape[0]] = array
    return wider


@_kernel
def _slab_range(
    own: Array, normal: Array, shape: Cells, slack: float, low: Cells, high: Cells
) -> int:
    """Cells low … high - 1 that a facet may meet per axis; the axis of the border it lies on."""
    flat = -1
    for axis in range(3):
        least, most = own[:, axis].min(), own[:, axis].max()
        border = np.rint(least)
        on_border = max(abs(least - border), abs(most - border)) <= slack
        if on_border and abs(normal[axis]) > 0.5:
            flat = axis
            low[axis] = int(border) if normal[axis] > 0 else int(border) - 1
            high[axis] = low[axis] + 1
            if low[axis] < 0 or high[axis] > shape[axis]:
                high[axis] = low[axis]
        else:
            low[axis] = max(0, int(np.floor(max(least, -1.0))))
            high[axis] = min(shape[axis], int(np.ceil(min(most, shape[axis] + 1.0))))
    return flat


@_kernel
def _slab(
    source: Array, count: int, axis: int, cell: int, flat: int, between: Array, target: Array
) -> int:
    """Clip `count` vertices to cell <= x <= cell + 1; the number left, in target."""
    if axis == flat:
        target[:count] = source[:count]
        return count
    left = _clip(source, count, axis, 1.0, float(cell), between)
    return _clip(between, left, axis, -1.0, -float(cell + 1), target)


@_kernel
def _clip(source: Array, count: int, axis: int, sign: float, limit: float, target: Array) -> int:
    """Keep the part of a polygon with sign · x >= limit."""
    kept = 0
    for i in range(count):
        here, there = source[i], source[(i + 1) % count]
        a, b = sign * here[axis] - limit, sign * there[axis] - limit
        if a >= 0:
            target[kept] = here
            kept += 1
        if (a > 0 and b < 0) or (a < 0 and b > 0):
            target[kept] = here + a / (a - b) * (there - here)
            kept += 1
    return kept


@_kernel
def _measure(polygon: Array, count: int, normal: Array, result: Array) -> None:
    """Area and centroid (4,) of a planar polygon, whichever way its vertices run."""
    result[:] = 0.0
    for i in range(1, count - 1):
        a, b = polygon[i] - polygon[0], polygon[i + 1] - polygon[0]
        twice = normal[0] * (a[1] * b[2] - a[2] * b[1])
        twice += normal[1] * (a[2] * b[0] - a[0] * b[2])
        twice += normal[2] * (a[0] * b[1] - a[1] * b[0])
        result[0] += 0.5 * twice
        result[1:] += twice / 6.0 * (a + b)
    if result[0] != 0.0:
        result[1:] = polygon[0] + result[1:] / result[0]
    result[0] = abs(result[0])
