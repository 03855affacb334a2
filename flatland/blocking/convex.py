"""Facets as convex parts near the grid: what kernels that clip can read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.sources import Facet

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

#: In cells. A facet lower than this has no area.
_FLAT = 1e-9
#: Cells around the grid that beams out of it reach into, and one more.
_MARGIN = 2.0
#: Of a unit vector: a corner that turns back by less than this turns forward or not at all.
_REFLEX = 1e-9


class Parts(NamedTuple):
    """Convex planar polygons (P,) as arrays, in cell units.

    vertices: (T, 3), of which first[p] … first[p + 1] − 1 are part p's. normals: (P, 3), unit
    vectors. facets: (P,), the facet that each is a part of.
    """

    vertices: Array
    first: Numbers
    normals: Array
    facets: Numbers


def convex_parts(grid: Grid, facets: Sequence[Facet]) -> Parts:
    """Facets in cell units, cut into convex parts and to the surroundings of the grid.

    Facets without area are left out. Vertices far away cost work and digits. Raises InputError for
    facets without finite vertices, and for those whose edges cross.
    """
    polygons = [_checked(facet) for facet in facets]
    sizes = np.array([len(polygon) for polygon in polygons], np.int64)
    first = np.concatenate([[0], np.cumsum(sizes)])
    vertices = grid.to_cells(np.concatenate([np.empty((0, 3)), *polygons]))
    normals, whole = _normals(vertices, first)
    convex = whole & _convex(vertices, first, normals)
    outside = np.any((vertices < -_MARGIN) | (vertices > np.array(grid.shape) + _MARGIN), axis=1)
    reaches_out = np.bincount(np.repeat(np.arange(len(sizes)), sizes), outside, len(sizes)) > 0
    parts: list[tuple[int, Array]] = []
    for facet in np.flatnonzero(whole).tolist():
        corners = vertices[first[facet] : first[facet + 1]]
        pieces = [corners] if convex[facet] else _triangles(corners, normals[facet])
        if reaches_out[facet]:
            pieces = [_near(piece, grid.shape) for piece in pieces]
        parts += [(facet, piece) for piece in pieces if len(piece) > 2]
    owners = np.array([facet for facet, _ in parts], np.int64)
    counts = np.array([len(piece) for _, piece in parts], np.int64)
    return Parts(
        np.concatenate([np.empty((0, 3)), *(piece for _, piece in parts)]),
        np.concatenate([[0], np.cumsum(counts)]),
        normals[owners],
        owners,
    )


def _checked(facet: Facet) -> Array:
    vertices = np.asarray(facet.vertices, float)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
        raise bad_input("facets", vertices, "must have three finite coordinates at each vertex")
    return vertices[np.any(vertices != np.roll(vertices, 1, axis=0), axis=1)]


def _normals(vertices: Array, first: Numbers) -> tuple[Array, NDArray[np.bool_]]:
    """Unit normals (F, 3) and which facets have an area (F,)."""
    start = np.repeat(first[:-1], np.diff(first))
    arms = vertices - vertices[start]
    vectors = np.zeros((len(first) - 1, 3))
    owners = np.repeat(np.arange(len(vectors)), np.diff(first))
    np.add.at(vectors, owners, np.cross(arms, arms[_following(first)]))
    sizes = np.linalg.norm(vectors, axis=1)
    reach = np.zeros(len(vectors))
    np.maximum.at(reach, owners, np.linalg.norm(arms, axis=1))
    whole = sizes > _FLAT * reach
    return vectors / np.where(whole, sizes, 1.0)[:, None], whole


def _following(first: Numbers) -> Numbers:
    """The number of the vertex after each vertex (T,)."""
    following = np.arange(1, first[-1] + 1)
    filled = first[1:] > first[:-1]
    following[first[1:][filled] - 1] = first[:-1][filled]
    return following


def _convex(vertices: Array, first: Numbers, normals: Array) -> NDArray[np.bool_]:
    """Which facets have no reflex corner (F,)."""
    owners = np.repeat(np.arange(len(normals)), np.diff(first))
    edges = vertices[_following(first)] - vertices
    lengths = np.linalg.norm(edges, axis=1, keepdims=True)
    edges /= np.where(lengths > 0, lengths, 1.0)
    turns = np.sum(np.cross(edges, edges[_following(first)]) * normals[owners], axis=1)
    convex = np.ones(len(normals), bool)
    np.logical_and.at(convex, owners, turns > -_REFLEX)
    return convex


def _triangles(corners: Array, normal: Array) -> list[Array]:
    """A facet with reflex corners as triangles between its own vertices."""
    across = np.argsort(np.abs(normal))[:2]
    flat = corners[:, across]
    polygon = shapely.Polygon(flat)
    if not polygon.is_valid:
        raise bad_input("facets", corners, "must have edges that do not cross")
    number = {tuple(place): i for i, place in enumerate(flat.tolist())}
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    return [
        corners[[number[tuple(place)] for place in triangle.exterior.coords[:-1]]]
        for triangle in triangles
    ]


def _near(polygon: Array, shape: tuple[int, ...]) -> Array:
    """The part of a convex polygon in the surroundings of the grid."""
    for axis, size in enumerate(shape):
        polygon = _above(polygon, polygon[:, axis] + _MARGIN)
        polygon = _above(polygon, size + _MARGIN - polygon[:, axis])
    return polygon


def _above(polygon: Array, heights: Array) -> Array:
    """The part of a convex polygon whose heights (V,) are not negative."""
    if not len(polygon) or heights.min() >= 0:
        return polygon
    kept = []
    for i, j in enumerate(np.roll(np.arange(len(polygon)), -1)):
        if heights[i] >= 0:
            kept.append(polygon[i])
        if heights[i] * heights[j] < 0:
            part = heights[i] / (heights[i] - heights[j])
            kept.append(polygon[i] + part * (polygon[j] - polygon[i]))
    return np.array(kept).reshape(-1, 3)
