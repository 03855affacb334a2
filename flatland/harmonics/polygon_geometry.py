"""Spherical polygons: their edges, their solid angle, and the part above a horizon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input

Array = NDArray[np.float64]

#: |a + b| of two unit vectors below which no great circle through them can be told from another.
_OPPOSITE = 1e-9


@dataclass(frozen=True)
class Edges:
    """The great-circle arcs of polygons, each from vertex i to vertex i + 1.

    normals (..., V, 3): unit pole of the arc's plane, on the side of the interior. middles
    (..., V, 3): unit vector to the arc's middle. half_angles (..., V) [rad].
    """

    normals: Array
    middles: Array
    half_angles: Array

    @property
    def tangents(self) -> Array:
        """Direction (..., V, 3) in which the arc is walked at its middle."""
        return np.cross(self.normals, self.middles)


def polygon_vertices(vertices: ArrayLike) -> Array:
    """Vertices (..., V, 3) of any length as unit vectors; raises InputError for what is none."""
    array = np.asarray(vertices, float)
    if array.ndim < 2 or array.shape[-1] != 3 or array.shape[-2] < 3:
        rule = "must be polygons of shape (..., V, 3) with at least 3 vertices"
        raise bad_input("vertices", array.shape, rule)
    largest = np.abs(array).max(axis=-1, keepdims=True)
    if not np.all(np.isfinite(largest) & (largest > 0)):
        raise bad_input("vertices", vertices, "must be finite and not zero")
    return _unit(array / largest)


def edges_of(vertices: Array) -> Edges:
    """The arcs of polygons with unit vertices (..., V, 3).

    Raises InputError where a vertex lies opposite the one before: no arc is the shortest there.
    """
    start, stop = vertices, np.roll(vertices, -1, axis=-2)
    together = start + stop
    if np.any(np.linalg.norm(together, axis=-1) < _OPPOSITE):
        raise bad_input("vertices", vertices, "must not hold opposite neighbours")
    middles = _unit(together)
    # stop - start is exact for short arcs, where start × stop would cancel.
    normals = np.cross(start, stop - start)
    sine = np.linalg.norm(normals, axis=-1)
    normals = np.where(sine[..., None] > 0, normals, _perpendicular(middles))
    half_angles = 0.5 * np.arctan2(sine, np.sum(start * stop, axis=-1))
    return Edges(_unit(normals), middles, half_angles)


def vector_angle(edges: Edges) -> Array:
    """∫ ω dω over polygons, (..., 3): half of Σ angle · normal over their edges (Lambert).

    Its direction is the middle of the cone of directions.
    """
    return np.asarray(np.sum(edges.half_angles[..., None] * edges.normals, axis=-2))


def solid_angle(vertices: Array, edges: Edges) -> Array:
    """Signed solid angle (...) [sr] of polygons with unit vertices (..., V, 3) and their edges.

    Sum over triangles that meet in a point c of the same hemisphere (van Oosterom & Strackee
    1983, eq. 8): tan(Ω/2) = c·(a × b) / (1 + a·b + b·c + c·a). Positive if the vertices run
    counter-clockwise seen from outside the sphere.
    """
    a, c = vertices, _inner_point(vertices, edges)[..., None, :]
    b = np.roll(a, -1, axis=-2)
    # a - c and b - a are exact for small triangles, where c × a would cancel.
    volume = np.sum(np.cross(c, a - c) * (b - a), axis=-1)
    rest = 1 + np.sum(a * b, axis=-1) + np.sum(b * c, axis=-1) + np.sum(c * a, axis=-1)
    return np.asarray(2 * np.arctan2(volume, rest).sum(axis=-1))


def _inner_point(vertices: Array, edges: Edges) -> Array:
    """Unit vectors (..., 3) in the hemispheres that hold polygons: the mean of their vertices.

    It vanishes for a regular polygon on a horizon. The vector angle does not, but points to the
    other side if the polygon is walked clockwise.
    """
    mean, vector = vertices.mean(axis=-2), vector_angle(edges)
    away = np.sum(mean * vector, axis=-1, keepdims=True) < -1e-12
    near = np.linalg.norm(mean, axis=-1, keepdims=True) > 0.25
    centre = np.where(near, mean, np.where(away, -vector, vector))
    length = np.linalg.norm(centre, axis=-1, keepdims=True)
    return np.where(length > 0, centre / np.where(length > 0, length, 1.0), vertices[..., 0, :])


def above_horizon(vertices: ArrayLike, normals: ArrayLike) -> Array:
    """The part with n·ω ≥ 0 of polygons (..., V, 3), for normals (..., 3): (..., 2 V, 3).

    Sutherland & Hodgman 1974, every edge giving its start and its crossing of the horizon; what
    is not there repeats the vertex before, so that all results have one shape. A polygon below
    the horizon shrinks to a point.
    """
    start = polygon_vertices(vertices)
    normal = np.asarray(normals, float)[..., None, :]
    start, normal = np.broadcast_arrays(start, normal)
    height = np.sum(start * normal, axis=-1)
    stop, next_height = np.roll(start, -1, axis=-2), np.roll(height, -1, axis=-1)
    crosses = (height > 0) != (next_height > 0)
    # The chord's point at height zero lies in the plane of the arc; crosses excludes 0 - 0.
    span = np.where(crosses, height - next_height, 1.0)[..., None]
    crossing = (stop * height[..., None] - start * next_height[..., None]) / span
    points = np.stack([start, crossing], axis=-2).reshape(*start.shape[:-2], -1, 3)
    kept = np.stack([height > 0, crosses], axis=-1).reshape(points.shape[:-1])
    return _repeat_last_kept(points, kept)


def _repeat_last_kept(points: Array, kept: NDArray[np.bool_]) -> Array:
    """Points (..., M, 3) with those not kept replaced by the kept one before, round the polygon."""
    place = np.where(kept, np.arange(kept.shape[-1]), -1)
    latest = np.maximum.accumulate(place, axis=-1)
    last = latest[..., -1:]  # -1 where none is kept: all become the last point
    source = np.where(latest >= 0, latest, np.where(last >= 0, last, kept.shape[-1] - 2))
    return np.take_along_axis(points, source[..., None], axis=-2)


def _perpendicular(vectors: Array) -> Array:
    """Any vectors (..., 3) at right angles to unit vectors (..., 3)."""
    axis = np.eye(3)[np.argmin(np.abs(vectors), axis=-1)]
    return np.cross(vectors, axis)


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
