"""Facets as the convex parts of them that lie in the grid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from flatland.facets import FacetTable, facet_table
from flatland.grid import Grid
from flatland.shadow_map.clipping import SLACK
from flatland.shadow_map.convex import copy, kernel, roomier
from flatland.sources import Facet

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Most sides of an outline; what has more is cut in two. Bounds the size of what is cut by it.
MOST_SIDES = 8
#: Sine of the angle by which an outline may turn inwards and still count as convex.
STRAIGHT = 1e-12


class Outlines(NamedTuple):
    """Convex planar polygons (R,) in cell units.

    vertices: (T, 3), of which first[r] … first[r + 1] - 1 are outline r's. facets: (R,) place of
    the facet that each is a part of. normals: (R, 3), unit vectors, of either sign.
    """

    vertices: Array
    first: Indices
    facets: Indices
    normals: Array

    def clipped(self, planes: Array) -> Outlines:
        """The parts on the side x·p₀₁₂ + p₃ ≥ 0 of all planes (P, 4)."""
        vertices, tags = _clipped(self.vertices, self.first, planes, MOST_SIDES)
        first, source = np.concatenate([[0], tags[:, 0]]), tags[:, 1]
        return Outlines(vertices, first, self.facets[source], self.normals[source])


def outlines_in(grid: Grid, facets: Sequence[Facet]) -> Outlines:
    """The parts of facets inside the grid; facets without area are dropped."""
    table = facet_table(grid, facets)
    outlines = _convex(table)
    axes, size = np.eye(3), np.array(grid.shape, float)
    lower = np.column_stack([axes, np.full(3, SLACK)])
    upper = np.column_stack([-axes, size + SLACK])
    return outlines.clipped(np.concatenate([lower, upper]))


def _convex(table: FacetTable) -> Outlines:
    """Convex facets as they are, others as triangles, in order."""
    flat = ~np.any(table.normals != 0, axis=1)
    hollow = _turns_inwards(table)
    parts, owner = [np.empty((0, 3))], []
    for facet, (low, high) in enumerate(zip(table.first, table.first[1:])):
        if flat[facet]:
            continue
        own = table.vertices[low:high]
        pieces = triangles(own, table.normals[facet]) if hollow[facet] else [own]
        parts += pieces
        owner += [facet] * len(pieces)
    first = np.cumsum([0, *map(len, parts[1:])]).astype(np.int64)
    facets = np.array(owner, np.int64)
    return Outlines(np.concatenate(parts), first, facets, table.normals[facets])


def _turns_inwards(table: FacetTable) -> NDArray[np.bool_]:
    """Which facets (F,) are not convex."""
    counts = np.diff(table.first)
    facet = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(facet))
    following = np.where(place + 1 < table.first[facet + 1], place + 1, table.first[facet])
    edges = table.vertices[following] - table.vertices
    turn = np.sum(np.cross(edges, edges[following]) * table.normals[facet], axis=1)
    size = np.linalg.norm(edges, axis=1)
    inwards = turn < -STRAIGHT * size * size[following]
    return np.bincount(facet, inwards, len(counts)) > 0


def triangles(vertices: Array, normal: Array) -> list[Array]:
    """A planar polygon (V, 3) as triangles (3, 3)."""
    frame = plane_frame(normal)
    polygon = shapely.make_valid(shapely.Polygon(vertices @ frame[:2].T))
    height = float(np.mean(vertices @ normal))
    found = shapely.constrained_delaunay_triangles(polygon)
    return [lifted(shapely.get_coordinates(part)[:3], frame, height) for part in found.geoms]


def lifted(points: Array, frame: Array, height: float) -> Array:
    """Points (V, 2) of a plane at a height along its normal, in space (V, 3)."""
    return np.asarray(points @ frame[:2] + height * frame[2])


def plane_frame(normal: Array) -> Array:
    """Right-handed unit vectors (3, 3): two across a unit vector, and itself."""
    first = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first), normal])


@kernel
def _clipped(
    vertices: Array, first: Indices, planes: Array, most_sides: int
) -> tuple[Array, Indices]:
    """Outlines cut by planes: vertices, and per part its end in them and the outline it is of."""
    longest = 3
    for r in range(first.size - 1):
        longest = max(longest, first[r + 1] - first[r])
    work = np.empty((2, 2 * (longest + planes.shape[0]) + 8, 3))
    found, tags = np.empty((2 * vertices.shape[0] + 8, 3)), np.empty((first.size, 2), np.int64)
    used, corners = 0, 0
    for r in range(first.size - 1):
        count = copy(vertices, first[r], first[r + 1], work[0], 0)
        for p in range(planes.shape[0]):
            count = _cut_by_plane(work[0], count, planes[p], work[1])
            copy(work[1], 0, count, work[0], 0)
        # A fan of outlines with few sides.
        begin = 1
        while begin + 1 < count:
            end = min(begin + most_sides - 1, count)
            found = roomier(found, corners, corners + most_sides)
            tags = roomier(tags, used, used + 1)
            corners = copy(work[0], 0, 1, found, corners)
            corners = copy(work[0], begin, end, found, corners)
            tags[used, 0], tags[used, 1] = corners, r
            used, begin = used + 1, end - 1
    return found[:corners], tags[:used]


@kernel
def _cut_by_plane(polygon: Array, count: int, plane: Array, target: Array) -> int:
    """Sutherland & Hodgman 1974 for one plane; the number of vertices left."""
    kept = 0
    for i in range(count):
        j = (i + 1) % count
        a, b = _above(plane, polygon[i]), _above(plane, polygon[j])
        if a >= 0:
            kept = copy(polygon, i, i + 1, target, kept)
        if (a > 0 and b < 0) or (a < 0 and b > 0):
            for k in range(3):
                target[kept, k] = polygon[i, k] + a / (a - b) * (polygon[j, k] - polygon[i, k])
            kept += 1
    return kept


@kernel
def _above(plane: Array, point: Array) -> float:
    return plane[0] * point[0] + plane[1] * point[1] + plane[2] * point[2] + plane[3]
