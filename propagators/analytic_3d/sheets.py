"""Walls without overlaps: each point of a wall is on one sheet, and nothing passes through one.

Where walls lie on one another the earlier one counts, and where one passes through another, or
stands on it, both are cut: a box on a floor leaves a floor with a hole and a piece under the box,
so that no element is half in the dark.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.ops import polygonize

from propagators.analytic_3d.plates import TOUCH, Frame, Plates, frame_of, polygons_in

Array = NDArray[np.float64]

#: Cells. Coordinates in a wall's plane are rounded to this: shapely then closes all gaps.
GRID = 1e-9
#: Square cells. Smaller pieces are rounding.
NOTHING = 1e-12


@dataclass(frozen=True, eq=False)
class Sheet:
    """A piece of a wall. surface: whose. shape: in the coordinates of the frame; may have holes."""

    surface: int
    frame: Frame
    shape: shapely.Polygon


def cut_sheets(walls: Plates, surfaces: NDArray[np.int64], count: int) -> list[Sheet]:
    """The sheets of `count` surfaces, from the convex plates (P,) of walls that they consist of."""
    plates = [walls.vertices[a:b] for a, b in zip(walls.first[:-1], walls.first[1:])]
    sheets = []
    for surface in range(count):
        own = np.flatnonzero(surfaces == surface)
        if not len(own):
            continue
        frame = frame_of(max((plates[p] for p in own), key=_extent))
        near = _near(walls, own)
        near = near[surfaces[near] != surface]
        shape = shapely.union_all([_flat(frame, plates[p]) for p in own], grid_size=GRID)
        lines = []
        for p in near:
            heights = frame.heights(plates[p])
            if np.all(np.abs(heights) <= TOUCH):
                if surfaces[p] < surface:
                    shape = shapely.difference(shape, _flat(frame, plates[p]), grid_size=GRID)
            elif (line := _section(frame, plates[p], heights)) is not None:
                lines.append(line)
        sheets += [Sheet(surface, frame, piece) for piece in _pieces(shape, lines)]
    return sheets


def _extent(vertices: Array) -> float:
    return float(np.ptp(vertices, axis=0).max())


def _near(walls: Plates, own: NDArray[np.int64]) -> NDArray[np.int64]:
    """Plates whose boxes touch that of some."""
    low, high = walls.low[own].min(axis=0) - TOUCH, walls.high[own].max(axis=0) + TOUCH
    return np.flatnonzero(np.all((walls.low <= high) & (walls.high >= low), axis=1))


def _flat(frame: Frame, vertices: Array) -> shapely.Polygon:
    return shapely.Polygon(frame.flat(vertices))


def _section(frame: Frame, vertices: Array, heights: Array) -> shapely.LineString | None:
    """What a convex plate has in common with the frame's plane, if it has length."""
    heights = np.where(np.abs(heights) <= TOUCH, 0.0, heights)
    if heights.min() > 0 or heights.max() < 0:
        return None
    points = []
    for i, here in enumerate(heights):
        before = heights[i - 1]
        if before * here < 0:
            share = before / (before - here)
            points.append(vertices[i - 1] + share * (vertices[i] - vertices[i - 1]))
        if here == 0:
            points.append(vertices[i])
    if len(points) < 2:
        return None
    flat = frame.flat(np.array(points))
    order = np.argsort(flat[:, int(np.argmax(np.ptp(flat, axis=0)))])
    line = shapely.LineString(flat[order[[0, -1]]])
    return line if line.length > GRID else None


def _pieces(shape: shapely.Geometry, lines: list[shapely.LineString]) -> list[shapely.Polygon]:
    """A shape cut along lines."""
    inner = shapely.buffer(shape, -2 * GRID, join_style="mitre") if lines else None
    crossing = [line for line in lines if shapely.intersects(line, inner)]
    if not crossing:
        return [piece for piece in polygons_in(shape) if piece.area > NOTHING]
    crossing = [_lengthened(place, crossing, shape) for place in range(len(crossing))]
    network = shapely.union_all([shapely.boundary(shape), *crossing], grid_size=GRID)
    return [
        piece
        for piece in polygonize(shapely.get_parts(network))
        if piece.area > NOTHING and shapely.contains(shape, piece.representative_point())
    ]


def _lengthened(
    place: int, lines: list[shapely.LineString], shape: shapely.Geometry
) -> shapely.LineString:
    """One of several lines, drawn on where it ends inside the shape and at no other line.

    It would cut nothing otherwise; what is cut in vain does no harm.
    """
    ends = shapely.get_coordinates(lines[place])
    low_u, low_v, high_u, high_v = shape.bounds
    way = (ends[1] - ends[0]) / lines[place].length * (high_u - low_u + high_v - low_v)
    others = shapely.union_all([line for k, line in enumerate(lines) if k != place])
    for end, step in ((0, -way), (1, way)):
        here = shapely.Point(ends[end])
        meets = shapely.distance(here, others) <= 2 * GRID if not others.is_empty else False
        if not meets and shapely.contains(shape, here):
            ends[end] = ends[end] + step
    return shapely.LineString(ends)
