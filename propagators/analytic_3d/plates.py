"""Planar polygons as convex plates, in arrays for kernels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from flatland.facets import vector_area

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Cells. What is nearer to a plane than this lies on it: light arrives there, nothing is hidden.
TOUCH = 1e-10
#: Vertices of one plate; kernels keep room for those that cuts add.
MOST_VERTICES = 8


class Plates(NamedTuple):
    """Convex planar polygons (P,).

    vertices: (T, 3), of which first[p] … first[p + 1] - 1 are plate p's, counter-clockwise seen
    from its front. planes: (P, 4) unit normal to the front, and its offset. low, high: (P, 3).
    """

    vertices: Array
    first: Counts
    planes: Array
    low: Array
    high: Array


class Frame(NamedTuple):
    """A plane with axes: points are origin + coordinates @ axes; normal is axes[0] x axes[1]."""

    origin: Array
    axes: Array
    normal: Array

    def flat(self, points: Array) -> Array:
        """Coordinates (..., 2) of points (..., 3)."""
        return np.asarray((points - self.origin) @ self.axes.T)

    def solid(self, coordinates: Array) -> Array:
        """Points (..., 3) at coordinates (..., 2)."""
        return np.asarray(self.origin + np.asarray(coordinates) @ self.axes)

    def heights(self, points: Array) -> Array:
        """How far points (..., 3) lie in front."""
        return np.asarray((points - self.origin) @ self.normal)


def frame_of(vertices: Array) -> Frame:
    """The plane of a polygon (V, 3) with area, its first axis along the longest edge."""
    normal = vector_area(vertices)
    normal = normal / np.linalg.norm(normal)
    edges = np.roll(vertices, -1, axis=0) - vertices
    along = edges[np.argmax(np.sum(edges**2, axis=1))]
    along = along - (along @ normal) * normal
    along = along / np.linalg.norm(along)
    # Axes of the grid stay exact: rounding must not tilt a wall that lies on a grid plane.
    normal, along = _cleaned(normal), _cleaned(along)
    return Frame(vertices[0], np.stack([along, np.cross(normal, along)]), normal)


def make_plates(polygons: Iterable[Array]) -> Plates:
    """Plates from convex polygons (V, 3) with area."""
    parts = list(polygons)
    frames = [frame_of(part) for part in parts]
    first = np.cumsum([0, *map(len, parts)]).astype(np.int64)
    normals = np.array([frame.normal for frame in frames]).reshape(-1, 3)
    offsets = [float(np.mean(part @ frame.normal)) for part, frame in zip(parts, frames)]
    return Plates(
        np.concatenate([np.empty((0, 3)), *parts]),
        first,
        np.column_stack([normals, np.array(offsets).reshape(-1, 1)]),
        np.array([part.min(axis=0) for part in parts]).reshape(-1, 3),
        np.array([part.max(axis=0) for part in parts]).reshape(-1, 3),
    )


def convex_parts(vertices: Array) -> list[Array]:
    """A planar polygon (V, 3) as convex ones; itself where it is one, else triangles."""
    if _is_convex(vertices):
        return _short_parts(vertices)
    frame = frame_of(vertices)
    return flat_parts(frame, shapely.Polygon(frame.flat(vertices)))


def flat_parts(frame: Frame, shape: shapely.Geometry) -> list[Array]:
    """A plane shape, holes and several parts included, as convex polygons (V, 3)."""
    parts = []
    for polygon in polygons_in(shape):
        ring = frame.solid(shapely.get_coordinates(shapely.orient_polygons(polygon).exterior)[:-1])
        if not polygon.interiors and _is_convex(ring):
            parts += _short_parts(ring)
            continue
        for triangle in polygons_in(shapely.constrained_delaunay_triangles(polygon)):
            ring = shapely.orient_polygons(triangle).exterior
            parts.append(frame.solid(shapely.get_coordinates(ring)[:-1]))
    return parts


def polygons_in(shape: shapely.Geometry) -> list[shapely.Polygon]:
    """The polygons with area of any shape."""
    parts: Sequence[shapely.Geometry] = shapely.get_parts(shape)
    nested = [p for part in parts for p in (polygons_in(part) if _is_nested(part) else [part])]
    return [part for part in nested if part.geom_type == "Polygon" and part.area > 0]


def polygon_area(vertices: Array) -> float:
    """Area of a planar polygon (V, 3)."""
    return float(np.linalg.norm(vector_area(vertices)))


def clip_to_box(vertices: Array, shape: Sequence[int]) -> Array:
    """The part (V, 3) of a convex polygon in the grid, perhaps empty."""
    part = vertices
    for axis, size in enumerate(shape):
        for sign, offset in ((1.0, 0.0), (-1.0, float(size))):
            part = part_above(part, sign * part[:, axis] + offset)
    return part


def part_above(polygon: Array, heights: Array) -> Array:
    """The part (V, 3) of a convex polygon whose vertices have heights (V,) >= 0."""
    kept = []
    for i, (point, here) in enumerate(zip(polygon, heights)):
        before = heights[i - 1]
        if before * here < 0:
            kept.append(polygon[i - 1] + before / (before - here) * (point - polygon[i - 1]))
        if here >= 0:
            kept.append(point)
    return np.array(kept).reshape(-1, 3)


def _is_convex(vertices: Array) -> bool:
    if len(vertices) == 3:
        return True
    edges = np.roll(vertices, -1, axis=0) - vertices
    turns = np.cross(edges, np.roll(edges, -1, axis=0)) @ vector_area(vertices)
    if np.any(turns < 0):
        return False
    # All turns to the left and only once round: what a star does not.
    return bool(_turning(edges, vector_area(vertices)) < 3 * np.pi)


def _turning(edges: Array, normal: Array) -> float:
    following = np.roll(edges, -1, axis=0)
    sine = np.cross(edges, following) @ (normal / np.linalg.norm(normal))
    return float(np.sum(np.arctan2(sine, np.sum(edges * following, axis=1))))


def _short_parts(ring: Array) -> list[Array]:
    """A convex polygon in parts of at most MOST_VERTICES."""
    step = MOST_VERTICES - 2
    stops = range(1, max(2, len(ring) - 1), step)
    return [ring[[0, *range(k, min(k + step + 1, len(ring)))]] for k in stops]


def _is_nested(shape: shapely.Geometry) -> bool:
    return bool(shape.geom_type.startswith("Multi") or shape.geom_type == "GeometryCollection")


def _cleaned(unit: Array) -> Array:
    """A unit vector whose tiny components are zero."""
    clean = np.where(np.abs(unit) < 1e-14, 0.0, unit)
    return np.asarray(clean / np.linalg.norm(clean))
