"""Single rays: sight between points, and the cells that a point's light crosses."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner, shared
from propagators.analytic_3d.cuts import height
from propagators.analytic_3d.plates import TOUCH, Plates

Vector = NDArray[np.float64]


@shared
def clear_ways(starts: Vector, ways: Vector, lengths: Vector, walls: Plates) -> NDArray[np.bool_]:
    """Whether nothing stands on each way (K, 3), unit vectors of given lengths (K,) from starts.

    Walls that only touch the ends do not count, nor do those that the way runs along.
    """
    result = np.empty(len(starts), np.bool_)
    for k in range(len(starts)):
        reach = nearest_wall(starts[k], ways[k], walls)
        result[k] = reach >= lengths[k] - TOUCH
    return result


@inner
def nearest_wall(start: Vector, way: Vector, walls: Plates) -> float:
    """Distance to the first wall on a ray, beyond its start."""
    reach, point = math.inf, np.empty(3)
    for p in range(walls.planes.shape[0]):
        plane = walls.planes[p]
        slope = way[0] * plane[0] + way[1] * plane[1] + way[2] * plane[2]
        if abs(slope) <= TOUCH:
            continue
        distance = -height(start, plane) / slope
        if TOUCH < distance < reach:
            for axis in range(3):
                point[axis] = start[axis] + distance * way[axis]
            if _holds(point, plane, walls.vertices[walls.first[p] : walls.first[p + 1]]):
                reach = distance
    return reach


@inner
def _holds(point: Vector, plane: Vector, plate: Vector) -> bool:
    """Whether a point of a convex plate's plane lies on the plate."""
    count = plate.shape[0]
    for i in range(count):
        a, b = plate[i], plate[i + 1 if i + 1 < count else 0]
        turn = 0.0
        for axis in range(3):
            j, k = (axis + 1) % 3, (axis + 2) % 3
            ux, uy = b[j] - a[j], b[k] - a[k]
            turn += plane[axis] * (ux * (point[k] - a[k]) - uy * (point[j] - a[j]))
        if turn < 0.0:
            return False
    return True


@shared
def ray_intensity(
    shape: tuple[int, int, int],
    directions: Vector,
    positions: Vector,
    strength: Vector,
    walls: Plates,
) -> Vector:
    """Intensity (K, C, nx, ny, nz) from points: each ray counts in every cell that it leaves.

    strength: (K, Q, C) intensity of the points (Q, 3) in each direction.
    """
    colours = strength.shape[2]
    result = np.zeros((len(directions), colours, shape[0], shape[1], shape[2]))
    cell = np.empty(3, np.int64)
    for k in range(len(directions)):
        for q in range(len(positions)):
            reach = nearest_wall(positions[q], directions[k], walls)
            for axis in range(3):
                speed = directions[k, axis]
                for plane in range(shape[axis] + 1) if abs(speed) > TOUCH else range(0):
                    way = (plane - positions[q, axis]) / speed
                    if not TOUCH < way <= reach + TOUCH:
                        continue
                    for other in range(3):
                        place = positions[q, other] + way * directions[k, other]
                        cell[other] = math.floor(place)
                    cell[axis] = plane - 1 if speed > 0.0 else plane
                    if _inside(cell, shape):
                        for colour in range(colours):
                            result[k, colour, cell[0], cell[1], cell[2]] += strength[k, q, colour]
    return result


@inner
def _inside(cell: NDArray[np.int64], shape: tuple[int, int, int]) -> bool:
    low = min(cell[0], cell[1], cell[2])
    return low >= 0 and cell[0] < shape[0] and cell[1] < shape[1] and cell[2] < shape[2]
