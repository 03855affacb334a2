"""Light of points and parallel beams through windows: exact, nothing to refine.

A point sees of a window what walls leave of it, and so do parallel rays: convex pieces, over which
harmonics times the source's intensity are integrated in closed form.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import SphericalHarmonics
from flatland.sources import PointSource
from propagators.analytic.compiling import inner, share_work, shared
from propagators.analytic_3d.cuts import ROOM, height, keep_inside
from propagators.analytic_3d.flow import FlowTables, add_polygon, flow_tables
from propagators.analytic_3d.geometry import Geometry
from propagators.analytic_3d.maps import cosine_maps, series_bands, series_map
from propagators.analytic_3d.panels import Panels
from propagators.analytic_3d.plates import TOUCH, Plates
from propagators.analytic_3d.shadows import (
    EVERYWHERE,
    collect_blockers,
    make_work,
    see,
)
from propagators.analytic_3d.shafts import side_of

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]


def add_point_light(result: Vector, geometry: Geometry, panels: Panels, bands: int) -> None:
    """result (groups, C, size) += ∫ I(ω) y dω over the directions in which points see panels.

    Of a series the integrand is one of harmonics; a lobe's part ends at the lobe's horizon.
    """
    for point, position in zip(geometry.points, geometry.positions):
        for values in _point_values(point, position, geometry.walls, panels, bands):
            np.add.at(result, panels.groups, values[:, None] * point.spectrum[:, None])


def add_parallel_light(result: Vector, geometry: Geometry, panels: Panels, bands: int) -> None:
    """result (groups, C, size) += flux through panels times y of the beam's one direction."""
    for beam, irradiance in zip(geometry.beams, geometry.irradiances):
        centre = np.append(-beam.direction, 0.0)
        flux = seen_flows(panels, centre, EVERYWHERE, geometry.shading, 1)[:, 0]
        values = np.outer(irradiance, SphericalHarmonics(bands).evaluate(beam.direction))
        np.add.at(result, panels.groups, flux[:, None, None] * values)


def _point_values(
    point: PointSource, position: Vector, walls: Plates, panels: Panels, bands: int
) -> list[Vector]:
    """Coefficients (K, size) of unit spectrum, of the series and of the lobe, if they are there."""
    centre, values = np.append(position, 1.0), []
    if np.any(point.coefficients):
        series = np.asarray(point.coefficients, float)
        flows = seen_flows(panels, centre, EVERYWHERE, walls, series_bands(bands, series))
        values.append(flows @ series_map(bands, series).T)
    if point.lobe_direction is not None and point.lobe_flux != 0:
        axis = np.asarray(point.lobe_direction, float)
        flows = seen_flows(panels, centre, np.append(axis, axis @ position), walls, bands)
        lobe = np.tensordot(axis * point.lobe_flux / np.pi, cosine_maps(bands), 1)
        values.append(flows @ lobe.T)
    return values


def seen_flows(
    panels: Panels, centre: Vector, horizon: Vector, walls: Plates, bands: int
) -> Vector:
    """Flows (K, flow) of what a centre sees of panels inside a horizon plane.

    Of parallel light (a centre at infinity): the area seen across its direction, (K, ...) first.
    """
    tables = flow_tables(bands)
    flows = np.zeros((len(panels.corners), tables.size))
    share_work(
        _collect, len(flows), panels.corners, panels.normals, centre, horizon, walls, tables, flows
    )
    return flows


@shared
def _collect(
    party: int,
    parties: int,
    corners: Vector,
    normals: Vector,
    centre: Vector,
    horizon: Vector,
    walls: Plates,
    tables: FlowTables,
    flows: Vector,
) -> None:
    work = make_work(walls.planes.shape[0])
    pieces, sizes = np.empty((64, ROOM, 3)), np.empty(64, np.int64)
    harmonics = np.empty(tables.diagonal.size**2)
    plane, centres = np.empty(4), np.empty((1, 4))
    centres[0] = centre
    for k in range(party, corners.shape[0], parties):
        for axis in range(3):
            plane[axis] = -normals[k, axis]
        plane[3] = 0.0
        plane[3] = height(corners[k, 0], plane)
        if side_of(centre, plane) <= TOUCH:
            continue
        count = keep_inside(corners[k], 4, horizon, work.window)
        if count < 3:
            continue
        found = collect_blockers(centres, work.window, count, plane, EVERYWHERE, walls, work)
        pieces, sizes, left, _ = see(centre, work.window, count, found, work, pieces, sizes)
        for p in range(left):
            if centre[3] == 0.0:
                flows[k, 0] += area_across(pieces[p], sizes[p], centre)
                continue
            for i in range(sizes[p]):
                for axis in range(3):
                    pieces[p, i, axis] -= centre[axis]
            add_polygon(pieces[p], sizes[p], tables, harmonics, flows[k])


@inner
def area_across(polygon: Vector, count: int, centre: Vector) -> float:
    """Area of a polygon's projection along parallel rays that come from a centre at infinity."""
    total = 0.0
    for i in range(1, count - 1):
        for axis in range(3):
            j, k = (axis + 1) % 3, (axis + 2) % 3
            a, b = polygon[i, j] - polygon[0, j], polygon[i, k] - polygon[0, k]
            c, d = polygon[i + 1, j] - polygon[0, j], polygon[i + 1, k] - polygon[0, k]
            total += centre[axis] * (a * d - b * c)
    return math.fabs(0.5 * total)
