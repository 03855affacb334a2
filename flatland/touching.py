"""Whether a point lies on a wall."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from flatland.facets import vector_area
from flatland.shadow_map.outlines import plane_frame
from flatland.sources import Facet, Segment, Wall, facets_of, segments_of

Array = NDArray[np.float64]


def touches(walls: Sequence[Wall], point: Array, distance: float) -> bool:
    """Whether a point (dimension,) is within a distance [m] of a wall."""
    segments, facets = segments_of(walls), facets_of(walls)
    if segments and _distances(segments, point).min() <= distance:
        return True
    return any(_touches_facet(facet, point, distance) for facet in facets)


def _distances(segments: Sequence[Segment], point: Array) -> Array:
    """Distance (S,) of a point (2,) from each segment [m]."""
    start = np.array([segment.start for segment in segments])
    along = np.array([segment.stop for segment in segments]) - start
    square = np.maximum(np.sum(along**2, axis=1), np.finfo(float).tiny)
    part = np.clip(np.sum((point - start) * along, axis=1) / square, 0.0, 1.0)
    return np.hypot(*(start + part[:, None] * along - point).T)


def _touches_facet(facet: Facet, point: Array, distance: float) -> bool:
    vertices = facet.vertices - point
    if np.any(vertices.min(axis=0) > distance) or np.any(vertices.max(axis=0) < -distance):
        return False
    vector = vector_area(vertices)
    size = np.linalg.norm(vector)
    if size == 0:
        return False
    first, second, normal = plane_frame(vector / size)
    if abs(float(np.mean(vertices @ normal))) > distance:
        return False
    flat = shapely.Polygon(vertices @ np.stack([first, second], axis=1))
    return bool(shapely.distance(flat, shapely.Point(0, 0)) <= distance)
