"""The parts of the grid's border that no wall lies on, as surfaces that shine inwards."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from flatland.facets import vector_area
from flatland.grid import Grid
from flatland.injectors.border import Side
from flatland.moved_segments import ON_BORDER
from flatland.sources import PolygonSource, SegmentSource, Wall, facets_of, segments_of

Array = NDArray[np.float64]


def open_sources(
    grid: Grid, walls: Sequence[Wall], side: Side, radiance: Array
) -> list[SegmentSource] | list[PolygonSource]:
    """The open parts of a side as Lambertian surfaces of a radiance (colours,)."""
    if grid.dimension == 2:
        return [
            SegmentSource(start, stop, 2 * float(np.hypot(*(stop - start))) * radiance)
            for start, stop in open_stretches(grid, walls, side)
        ]
    return [
        PolygonSource(loop, np.pi * float(np.linalg.norm(vector_area(loop))) * radiance)
        for loop in open_polygons(grid, walls, side)
    ]


def open_stretches(grid: Grid, walls: Sequence[Wall], side: Side) -> list[tuple[Array, Array]]:
    """The parts of a side in 2D that no wall lies on, as start and stop [m], inside on the left."""
    place, along = (grid.shape[side.axis] if side.upper else 0), 1 - side.axis
    ends = np.array([(wall.start, wall.stop) for wall in segments_of(walls)], float).reshape(
        -1, 2, 2
    )
    cells = grid.to_cells(ends)
    lying = np.all(np.abs(cells[..., side.axis] - place) <= ON_BORDER, axis=1)
    covers = np.sort(np.clip(cells[lying][..., along], 0, grid.shape[along]), axis=1)
    stretches, reached = [], 0.0
    for low, high in [*sorted(covers.tolist()), [float(grid.shape[along])] * 2]:
        if low - reached > ON_BORDER:
            stretches.append((reached, low))
        reached = max(reached, high)
    corners = np.full((len(stretches), 2, 2), float(place))
    corners[..., along] = np.reshape(stretches, (-1, 2))
    # Counter-clockwise round the grid: up the right side, down the left one.
    backwards = side.upper == (side.axis == 1)
    return [(b, a) if backwards else (a, b) for a, b in grid.to_world(corners)]


def open_polygons(grid: Grid, walls: Sequence[Wall], side: Side) -> list[Array]:
    """The parts of a side in 3D that no wall lies on, vertices (V, 3) [m], the front inwards.

    A part with holes is cut into triangles.
    """
    place = float(grid.shape[side.axis] if side.upper else 0)
    across = [(side.axis + 1) % 3, (side.axis + 2) % 3]
    facets = [grid.to_cells(facet.vertices) for facet in facets_of(walls)]
    lying = [f for f in facets if np.all(np.abs(f[:, side.axis] - place) <= ON_BORDER)]
    covers = [shapely.make_valid(shapely.Polygon(facet[:, across])) for facet in lying]
    face = shapely.box(0, 0, *(grid.shape[axis] for axis in across))
    left = shapely.difference(face, shapely.union_all(covers))
    loops = []
    for part in shapely.get_parts(shapely.orient_polygons(left)):
        if part.area <= ON_BORDER * part.length:
            continue  # rounding has moved an edge off the border's
        for flat in _without_holes(part):
            corners = np.full((len(flat), 3), place)
            corners[:, across] = flat
            loops.append(grid.to_world(corners[::-1] if side.upper else corners))
    return loops


def _without_holes(polygon: shapely.Polygon) -> list[Array]:
    """Corners (V, 2), counter-clockwise, of a polygon or, where it has holes, of parts of it."""
    if not polygon.interiors:
        return [shapely.get_coordinates(polygon.exterior)[:-1]]
    parts = shapely.constrained_delaunay_triangles(polygon)
    return [shapely.get_coordinates(part)[:-1] for part in shapely.orient_polygons(parts).geoms]
