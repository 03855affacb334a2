"""Light that falls on surfaces: exact at points, means over elements of walls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import SphericalHarmonics
from flatland.sources import PointSource
from propagators.analytic.compiling import share_work, shared
from propagators.analytic_3d.cuts import ROOM, height, keep_inside
from propagators.analytic_3d.flow import FlowTables, flow_tables
from propagators.analytic_3d.geometry import Geometry
from propagators.analytic_3d.maps import cosine_maps
from propagators.analytic_3d.panels import add_arriving
from propagators.analytic_3d.plates import TOUCH, Plates
from propagators.analytic_3d.radiosity import Bounced
from propagators.analytic_3d.rays import clear_ways
from propagators.analytic_3d.shadows import collect_blockers, make_work, see

Vector = NDArray[np.float64]


class FacetLight(NamedTuple):
    """Irradiance of pieces of walls, each on one side.

    facets: (K,) place of each in scene.facets(). centres: (K, 3) [m]. normals: (K, 3), towards the
    light. areas: (K,) [m²]. irradiance: ([colours,] K) [W/m²], the mean over the piece. What is
    sent back is albedo times that.
    """

    facets: NDArray[np.int64]
    centres: Vector
    normals: Vector
    areas: Vector
    irradiance: Vector


def irradiance_at(
    geometry: Geometry, points: Vector, normals: Vector, bounced: Bounced | None
) -> Vector:
    """Irradiance (K, C) per cell face at points (K, 3) in cells with unit normals (K, 3).

    E = ∫ L(ω) ⟨n|-ω⟩₊ dω over what is seen of area lights, and of elements as if they were such
    (Lambert's formula); a point of intensity I at distance r gives I cos a / r².
    """
    result = polygon_irradiance(points, normals, geometry.lights, geometry.radiance, geometry.walls)
    if bounced is not None:
        lights = _lit_sides(bounced)
        result += polygon_irradiance(points, normals, *lights, geometry.walls)
    for point, position in zip(geometry.points, geometry.positions):
        way = points - position
        result += _point_irradiance(point, way, normals, geometry.walls, position)
    reach = 2.0 * sum(geometry.grid.shape)
    for beam, strength in zip(geometry.beams, geometry.irradiances):
        starts = points - reach * beam.direction
        ways = np.broadcast_to(beam.direction, points.shape).copy()
        clear = clear_ways(starts, ways, np.full(len(points), reach), geometry.shading)
        result += (np.maximum(0.0, -normals @ beam.direction) * clear)[:, None] * strength
    return result


def polygon_irradiance(
    points: Vector, normals: Vector, lights: Plates, radiance: Vector, walls: Plates
) -> Vector:
    """Irradiance (K, C) at points from the fronts of lights with radiance (L, C), past walls."""
    result = np.zeros((len(points), radiance.shape[1]))
    tables, maps = flow_tables(1), cosine_maps(1)[:, 0] * np.sqrt(4 * np.pi)
    share_work(
        _collect, 64 * len(points), points, normals, lights, radiance, walls, tables, maps, result
    )
    return result


@shared
def _collect(
    party: int,
    parties: int,
    points: Vector,
    normals: Vector,
    lights: Plates,
    radiance: Vector,
    walls: Plates,
    tables: FlowTables,
    maps: Vector,
    result: Vector,
) -> None:
    work = make_work(walls.planes.shape[0])
    pieces, sizes = np.empty((64, ROOM, 3)), np.empty(64, np.int64)
    flow, harmonics = np.empty(maps.shape[1]), np.empty(1)
    front, centres = np.empty(4), np.ones((1, 4))
    for k in range(party, points.shape[0], parties):
        for axis in range(3):
            front[axis] = normals[k, axis]
            centres[0, axis] = points[k, axis]
        front[3] = 0.0
        front[3] = height(points[k], front)
        for e in range(lights.planes.shape[0]):
            plane = lights.planes[e]
            if height(points[k], plane) <= TOUCH:
                continue
            own = lights.vertices[lights.first[e] : lights.first[e + 1]]
            count = keep_inside(own, own.shape[0], front, work.window)
            if count < 3:
                continue
            found = collect_blockers(centres, work.window, count, plane, front, walls, work)
            pieces, sizes, left, _ = see(centres[0], work.window, count, found, work, pieces, sizes)
            flow.fill(0.0)
            add_arriving(points[k], pieces, sizes, left, tables, harmonics, flow)
            for colour in range(radiance.shape[1]):
                for axis in range(3):
                    for j in range(flow.size):
                        # Light travels against the surface's normal.
                        term = normals[k, axis] * maps[axis, j] * flow[j]
                        result[k, colour] -= radiance[e, colour] * term


def _lit_sides(bounced: Bounced) -> tuple[Plates, Vector]:
    """The parts of all sides that send light, as area lights, and their radiance."""
    elements = bounced.elements
    panels = elements.panels()
    lit = np.any(bounced.radiosity[panels.groups] > 0, axis=1)
    corners, normals = panels.corners[lit][:, ::-1], -panels.normals[lit]
    offsets = np.sum(corners.mean(axis=1) * normals, axis=1)
    plates = Plates(
        np.ascontiguousarray(corners.reshape(-1, 3)),
        np.arange(len(corners) + 1) * 4,
        np.column_stack([normals, offsets]),
        corners.min(axis=1),
        corners.max(axis=1),
    )
    return plates, bounced.radiosity[panels.groups[lit]] / np.pi


def _point_irradiance(
    point: PointSource, ways: Vector, normals: Vector, walls: Plates, position: Vector
) -> Vector:
    distance = np.linalg.norm(ways, axis=1)
    apart = np.where(distance > 0, distance, 1.0)
    unit = ways / apart[:, None]
    cosine = np.maximum(0.0, -np.sum(normals * unit, axis=1))
    starts = np.broadcast_to(position, ways.shape).copy()
    clear = clear_ways(starts, unit, distance, walls) & (distance > 0)
    strength = point_intensity(point, unit) * cosine * clear / apart**2
    return strength[:, None] * point.spectrum


def point_intensity(point: PointSource, directions: Vector) -> Vector:
    """Intensity (K,) [W/sr] of a point of unit spectrum in directions (K, 3)."""
    series = np.asarray(point.coefficients, float)
    basis = SphericalHarmonics(round(np.sqrt(len(series))))
    result = basis.evaluate(directions) @ series
    if point.lobe_direction is not None:
        cosine = directions @ np.asarray(point.lobe_direction, float)
        result = result + np.maximum(0.0, cosine) * point.lobe_flux / np.pi
    return np.asarray(result)
