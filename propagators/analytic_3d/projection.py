"""Intensity of every cell in one direction: exact in space, by parallel projection."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner, share_work, shared
from propagators.analytic_3d.cuts import ROOM, height, keep_inside
from propagators.analytic_3d.plates import TOUCH, Plates
from propagators.analytic_3d.shadows import Work, collect_blockers, make_work, see
from propagators.analytic_3d.shafts import side_of
from propagators.analytic_3d.windows import area_across

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]

#: A light or a face with a smaller cosine to the direction is seen edge-on.
EDGE_ON = 1e-12


def projected_intensity(
    shape: tuple[int, ...], directions: Vector, lights: Plates, radiance: Vector, walls: Plates
) -> Vector:
    """Intensity (K, C, nx, ny, nz) at directions (K, 3) of lights with radiance (L, C), past walls.

    Flux per solid angle through a face is radiance times the area, across the direction, of what
    the light sends through it.
    """
    result = np.zeros((len(directions), radiance.shape[1], *shape))
    share_work(_project, len(directions) * 64, directions, lights, radiance, walls, result)
    return result


@shared
def _project(
    party: int,
    parties: int,
    directions: Vector,
    lights: Plates,
    radiance: Vector,
    walls: Plates,
    result: Vector,
) -> None:
    work = make_work(walls.planes.shape[0])
    shadow, face = np.empty((2, ROOM, 3)), np.empty((2, ROOM, 3))
    for k in range(party, directions.shape[0], parties):
        for e in range(lights.planes.shape[0]):
            own = lights.vertices[lights.first[e] : lights.first[e + 1]]
            for axis in range(3):
                _through(
                    directions[k],
                    own,
                    lights.planes[e],
                    axis,
                    radiance[e],
                    walls,
                    work,
                    shadow,
                    face,
                    result[k],
                )


@inner
def _through(
    direction: Vector,
    light: Vector,
    light_plane: Vector,
    axis: int,
    radiance: Vector,
    walls: Plates,
    work: Work,
    shadow: Vector,
    face: Vector,
    result: Vector,
) -> None:
    """Adds a light's flux through all faces across one axis."""
    centre = np.array([-direction[0], -direction[1], -direction[2], 0.0])
    if -side_of(centre, light_plane) <= EDGE_ON or abs(direction[axis]) <= EDGE_ON:
        return
    sign, plane = math.copysign(1.0, direction[axis]), np.zeros(4)
    plane[axis] = -sign
    b, c = (axis + 1) % 3, (axis + 2) % 3
    for k in range(result.shape[1 + axis] + 1):
        cell = k - 1 if sign > 0.0 else k
        if not 0 <= cell < result.shape[1 + axis]:
            continue
        plane[3] = -sign * k
        count = keep_inside(light, light.shape[0], plane, shadow[0])
        if count < 3:
            continue
        for i in range(count):
            way = height(shadow[0, i], plane) / abs(direction[axis])
            for j in range(3):
                shadow[0, i, j] += way * direction[j]
            shadow[0, i, axis] = k
        low, high = _cells(shadow[0], count, b, result.shape[1 + b])
        for i in range(low, high):
            strip = _between(shadow[0], count, b, i, shadow[1], face[0])
            if strip < 3:
                continue
            first, last = _cells(face[0], strip, c, result.shape[1 + c])
            for j in range(first, last):
                size = _between(face[0], strip, c, j, shadow[1], face[1])
                if size < 3:
                    continue
                area = _visible(centre, face[1], size, plane, light_plane, walls, work)
                place = np.empty(3, np.int64)
                place[axis], place[b], place[c] = cell, i, j
                for colour in range(radiance.size):
                    result[colour, place[0], place[1], place[2]] += area * radiance[colour]


@inner
def _visible(
    centre: Vector,
    window: Vector,
    size: int,
    plane: Vector,
    light_plane: Vector,
    walls: Plates,
    work: Work,
) -> float:
    """Area, across the direction, of what walls leave of a window."""
    centres = np.empty((1, 4))
    centres[0] = centre
    found = collect_blockers(centres, window, size, plane, light_plane, walls, work)
    pieces, sizes = np.empty((64, ROOM, 3)), np.empty(64, np.int64)
    pieces, sizes, left, _ = see(centre, window, size, found, work, pieces, sizes)
    area = 0.0
    for p in range(left):
        area += area_across(pieces[p], sizes[p], centre)
    return area


@inner
def _cells(polygon: Vector, count: int, axis: int, cells: int) -> tuple[int, int]:
    """Cells that a polygon may meet along an axis, from and to."""
    low, high = math.inf, -math.inf
    for i in range(count):
        low, high = min(low, polygon[i, axis]), max(high, polygon[i, axis])
    return max(0, math.floor(low + TOUCH)), min(cells, math.ceil(high - TOUCH))


@inner
def _between(
    polygon: Vector, count: int, axis: int, cell: int, half: Vector, target: Vector
) -> int:
    """The part of a polygon in one row of cells."""
    plane = np.zeros(4)
    plane[axis], plane[3] = 1.0, cell
    count = keep_inside(polygon, count, plane, half)
    if count < 3:
        return 0
    plane[axis], plane[3] = -1.0, -(cell + 1)
    return keep_inside(half, count, plane, target)
