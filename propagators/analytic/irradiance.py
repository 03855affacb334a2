"""Light that falls on surfaces: exact at points, exact means over pieces of wall."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import Scratch, make_scratch
from propagators.analytic.compiling import inner, share_work, shared
from propagators.analytic.geometry import Geometry
from propagators.analytic.rays import is_clear
from propagators.analytic.views import view

Vector = NDArray[np.float64]


class SurfaceLight(NamedTuple):
    """Irradiance of pieces of wall, each on its left, seen from start to stop.

    segments: (K,) place of each in scene.segments(). starts, stops: (K, 2) [m]. irradiance:
    ([colours,] K) [W/m], the mean over the piece. What is sent back is albedo times that.
    """

    segments: NDArray[np.int64]
    starts: Vector
    stops: Vector
    irradiance: Vector


def irradiance_at(
    geometry: Geometry, points: Vector, normals: Vector, emitters: Vector, radiance: Vector
) -> Vector:
    """Irradiance (K, C) [W per cell] at points (K, 2) in cells with unit normals (K, 2).

    E = ∫ L(ω) ⟨n|-ω⟩₊ dω. An arc of radiance L of directions that make the angles a … b with -n
    gives L (sin b - sin a); a point of intensity I at distance r, I cos a / r; parallel light of
    irradiance E⊥, E⊥ cos a. emitters (E, 4), radiance (E, C): lights and elements that reflect.
    """
    result = np.zeros((len(points), radiance.shape[1]))
    share_work(_collect, len(points), points, normals, emitters, radiance, geometry.walls, result)
    return result + _from_points(geometry, points, normals) + _from_beams(geometry, points, normals)


@shared
def _collect(
    party: int,
    parties: int,
    points: Vector,
    normals: Vector,
    emitters: Vector,
    radiance: Vector,
    walls: Vector,
    result: Vector,
) -> None:
    work = make_scratch(walls.shape[0])
    for k in range(party, points.shape[0], parties):
        facing = math.atan2(-normals[k, 1], -normals[k, 0])
        for e in range(emitters.shape[0]):
            seen = view(points[k, 0], points[k, 1], emitters[e], walls, work)
            if seen:
                factor = _projected(facing, emitters[e], seen, work)
                for colour in range(radiance.shape[1]):
                    result[k, colour] += radiance[e, colour] * factor


@inner
def _projected(facing: float, emitter: Vector, seen: int, work: Scratch) -> float:
    """∫ cos over the arcs seen, of angles less than a quarter turn from `facing`."""
    # Light travels from the emitter to the point: half a turn from the direction it is seen in.
    travel = math.atan2(emitter[2] - emitter[0], emitter[1] - emitter[3]) - facing
    travel -= 2 * math.pi * np.round(travel / (2 * math.pi))
    total = 0.0
    for k in range(seen):
        low, high = work.arcs[2 * k + 1], work.arcs[2 * k]
        start = travel + math.atan2(-work.edges[low, 0], work.edges[low, 1])
        stop = travel + math.atan2(-work.edges[high, 0], work.edges[high, 1])
        for turn in (-2 * math.pi, 0.0, 2 * math.pi):
            a, b = max(start + turn, -0.5 * math.pi), min(stop + turn, 0.5 * math.pi)
            if a < b:
                total += math.sin(b) - math.sin(a)
    return total


def _from_points(geometry: Geometry, points: Vector, normals: Vector) -> Vector:
    result = np.zeros((len(points), geometry.spectra.shape[1]))
    for s, position in enumerate(geometry.positions):
        way = points - position
        distance = np.hypot(*way.T)
        apart = np.where(distance > 0, distance, 1.0)[:, None]
        strength = geometry.point_intensity(way / apart)[:, s] / apart
        cosine = np.maximum(0.0, -np.einsum("kd,kd->k", normals, way / apart))
        clear = is_clear(np.broadcast_to(position, points.shape), points, geometry.walls)
        result += (cosine * (clear & (distance > 0)))[:, None] * strength
    return result


def _from_beams(geometry: Geometry, points: Vector, normals: Vector) -> Vector:
    result = np.zeros((len(points), geometry.irradiances.shape[1]))
    walls = geometry.walls[~geometry.gates]
    reach = 2.0 * sum(geometry.grid.shape)
    for direction, strength in zip(geometry.directions, geometry.irradiances):
        clear = is_clear(points - reach * direction, points, walls)
        result += (np.maximum(0.0, -normals @ direction) * clear)[:, None] * strength
    return result
