"""Walls cut into elements, on each of which radiosity is taken as constant."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from flatland.grid import Grid
from propagators.analytic_3d.faces import cell_faces
from propagators.analytic_3d.geometry import Geometry
from propagators.analytic_3d.panels import Panels, quads_of
from propagators.analytic_3d.plates import Frame, flat_parts, make_plates
from propagators.analytic_3d.sheets import NOTHING, Sheet, cut_sheets

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class Rasters(NamedTuple):
    """Sheets (S,) for kernels that ask which element lies at a point.

    edges: (T, 2, 3) ends of the edges of all rings, first[s] … first[s + 1] - 1 of sheet s.
    planes: (S, 4). origins: (S, 3) and axes: (S, 2, 3), in elements: column and row of a point p
    are the whole parts of (p - origin) · axes. counts: (S, 2) columns and rows. table: (M,)
    elements, from start[s] on row by row; -1 where there is none.
    """

    edges: Array
    first: Indices
    planes: Array
    origins: Array
    axes: Array
    counts: Indices
    start: Indices
    table: Indices


@dataclass(frozen=True, eq=False)
class Elements:
    """Pieces of walls (N,). Side 2 n is the front of element n, side 2 n + 1 its back.

    owners: (N,) surface of each, as in `Geometry`. areas: (N,) in cell faces. centres, normals:
    (N, 3). parts: (Q, 4, 3) convex quadrilaterals, of elements part_owners (Q,). rasters: where
    they are.
    """

    owners: Indices
    areas: Array
    centres: Array
    normals: Array
    parts: Array
    part_owners: Indices
    rasters: Rasters

    @property
    def side_areas(self) -> Array:
        """Areas (2 N,) of both sides."""
        return np.repeat(self.areas, 2)

    @property
    def side_owners(self) -> Indices:
        return np.repeat(self.owners, 2)

    def panels(self) -> Panels:
        """Both sides as panels that light passes inwards, groups by side."""
        normals = self.normals[self.part_owners]
        return Panels(
            np.concatenate([self.parts[:, ::-1], self.parts]),
            np.concatenate([-normals, normals]),
            np.concatenate([2 * self.part_owners, 2 * self.part_owners + 1]),
        )


def cut_walls(geometry: Geometry, size: float, coarse: float) -> Elements:
    """Elements of at most `size` cells on walls that reflect, of at most `coarse` on others."""
    sheets = cut_sheets(geometry.walls, geometry.surfaces, len(geometry.polygons))
    reflects = np.any(geometry.albedo > 0, axis=1)
    return _elements(sheets, [size if reflects[s.surface] else coarse for s in sheets])


def cut_border(geometry: Geometry) -> Panels:
    """What of the grid's border no wall lies on, as panels that light passes outwards."""
    sides = _border(geometry)
    plates = [geometry.walls.vertices[a:b] for a, b in pairwise(geometry.walls.first)]
    count = len(geometry.polygons)
    surfaces = np.concatenate([geometry.surfaces, count + np.arange(6)])
    sheets = cut_sheets(make_plates([*plates, *sides]), surfaces, count + 6)
    open_sheets = [sheet for sheet in sheets if sheet.surface >= count]
    elements = _elements(open_sheets, [1.0] * len(open_sheets))
    panels = elements.panels()
    outwards = panels.chosen(panels.groups % 2 == 1)
    return outwards._replace(groups=np.zeros_like(outwards.groups))


def _border(geometry: Geometry) -> list[Array]:
    """The six sides of the grid (4, 3), each counter-clockwise seen from outside."""
    size = np.array(geometry.grid.shape, float)
    corners = cell_faces(Grid((1, 1, 1))).corners
    return [corner * size for corner in corners]


class _Cut(NamedTuple):
    """One sheet in elements: its raster, and of each element area, centre and quadrilaterals."""

    sheet: Sheet
    low: Array
    steps: Array
    counts: list[int]
    table: Indices
    areas: Array
    centres: Array
    parts: Array
    part_owners: Indices


def _elements(sheets: list[Sheet], sizes: list[float]) -> Elements:
    cuts = [_cut(sheet, size) for sheet, size in zip(sheets, sizes)]
    lengths = [len(cut.areas) for cut in cuts]
    starts = np.cumsum([0, *lengths])
    normals = np.array([cut.sheet.frame.normal for cut in cuts]).reshape(-1, 3)
    shifted = [cut.part_owners + start for cut, start in zip(cuts, starts)]
    tables = [np.where(cut.table < 0, -1, cut.table + start) for cut, start in zip(cuts, starts)]
    none = np.empty(0, np.int64)
    return Elements(
        np.repeat(np.array([sheet.surface for sheet in sheets], np.int64), lengths),
        np.concatenate([np.empty(0), *(cut.areas for cut in cuts)]),
        np.concatenate([np.empty((0, 3)), *(cut.centres for cut in cuts)]),
        np.repeat(normals, lengths, axis=0),
        np.concatenate([np.empty((0, 4, 3)), *(cut.parts for cut in cuts)]),
        np.concatenate([none, *shifted]),
        _rasters(cuts, np.concatenate([none, *tables])),
    )


def _cut(sheet: Sheet, size: float) -> _Cut:
    bounds = np.array(sheet.shape.bounds).reshape(2, 2)
    extent = bounds[1] - bounds[0]
    counts = [max(1, int(np.ceil(x / size - 1e-9))) for x in extent]
    steps = extent / counts
    v, u = (index.ravel() for index in np.indices(tuple(counts[::-1])))
    start = bounds[0] + np.stack([u, v], axis=1) * steps
    boxes = shapely.box(*start.T, *(start + steps).T)
    shapely.prepare(sheet.shape)
    whole = shapely.contains(sheet.shape, boxes)
    pieces: NDArray[np.object_] = np.array(boxes, object)
    pieces[~whole] = shapely.intersection(sheet.shape, boxes[~whole])
    areas = shapely.area(pieces)
    kept = areas > NOTHING
    parts, owners = _quads(sheet.frame, pieces[kept], whole[kept])
    return _Cut(
        sheet,
        bounds[0],
        steps,
        counts,
        np.where(kept, np.cumsum(kept) - 1, -1),
        areas[kept],
        sheet.frame.solid(shapely.get_coordinates(shapely.centroid(pieces[kept]))),
        parts,
        owners,
    )


def _quads(
    frame: Frame, pieces: NDArray[np.object_], boxes: NDArray[np.bool_]
) -> tuple[Array, Indices]:
    """Pieces as quadrilaterals, counter-clockwise seen from the front, and whose each is."""
    ring = shapely.get_coordinates(shapely.orient_polygons(pieces[boxes])).reshape(-1, 5, 2)
    parts, owners = [frame.solid(ring[:, :4])], [np.flatnonzero(boxes)]
    for place in np.flatnonzero(~boxes):
        quads = [quad for part in flat_parts(frame, pieces[place]) for quad in quads_of(part)]
        parts.append(np.array(quads).reshape(-1, 4, 3))
        owners.append(np.full(len(quads), place))
    return np.concatenate(parts), np.concatenate(owners)


def _rasters(cuts: list[_Cut], table: Indices) -> Rasters:
    frames = [cut.sheet.frame for cut in cuts]
    edges = [
        [_ring_edges(cut.sheet.frame, ring) for ring in _rings(cut.sheet.shape)] for cut in cuts
    ]
    planes = [[*frame.normal, frame.normal @ frame.origin] for frame in frames]
    axes = [cut.sheet.frame.axes / cut.steps[:, None] for cut in cuts]
    return Rasters(
        np.concatenate([np.empty((0, 2, 3)), *(ring for rings in edges for ring in rings)]),
        np.cumsum([0, *(sum(map(len, rings)) for rings in edges)]).astype(np.int64),
        np.array(planes).reshape(-1, 4),
        np.array([cut.sheet.frame.solid(cut.low) for cut in cuts]).reshape(-1, 3),
        np.array(axes).reshape(-1, 2, 3),
        np.array([cut.counts for cut in cuts], np.int64).reshape(-1, 2),
        np.cumsum([0, *(len(cut.table) for cut in cuts)]).astype(np.int64),
        table,
    )


def _rings(shape: shapely.Polygon) -> list[Array]:
    return [shapely.get_coordinates(ring) for ring in (shape.exterior, *shape.interiors)]


def _ring_edges(frame: Frame, ring: Array) -> Array:
    points = frame.solid(ring)
    return np.stack([points[:-1], points[1:]], axis=1)
