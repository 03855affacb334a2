"""The hull between centres and a window: walls outside it hide nothing.

Its sides are planes through an edge of one end and a corner of the other that have everything else
on one side (Haines and Wallace 1991).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner
from propagators.analytic_3d.cuts import height
from propagators.analytic_3d.plates import TOUCH

Vector = NDArray[np.float64]

#: Planes of one shaft that are kept; others would only let more walls pass.
MOST_PLANES = 32


@inner
def find_shaft(centres: Vector, window: Vector, count: int, planes: Vector) -> int:
    """Planes (MOST_PLANES, 4) round centres (K, 4) and a convex window, inside in; their number."""
    found = 0
    for i in range(count):
        a, b = window[i], window[i + 1 if i + 1 < count else 0]
        for k in range(centres.shape[0]):
            if found < MOST_PLANES and _span(a, b, centres[k], planes[found]):
                found += _settle(centres, window, count, planes[found])
    if centres.shape[0] < 3:
        return found
    apex = np.ones(4)
    for k in range(centres.shape[0]):
        a, b = centres[k], centres[k + 1 if k + 1 < centres.shape[0] else 0]
        for i in range(count):
            apex[:3] = window[i]
            if found < MOST_PLANES and _span(a, b, apex, planes[found]):
                found += _settle(centres, window, count, planes[found])
    return found


@inner
def is_outside(polygon: Vector, count: int, planes: Vector, found: int) -> bool:
    """Whether a polygon lies on the outer side of one of the planes."""
    for s in range(found):
        highest = -math.inf
        for i in range(count):
            highest = max(highest, height(polygon[i], planes[s]))
        if highest <= TOUCH:
            return True
    return False


@inner
def side_of(centre: Vector, plane: Vector) -> float:
    """How far a centre lies in front of a plane; the cosine to its normal at infinity."""
    along = centre[0] * plane[0] + centre[1] * plane[1] + centre[2] * plane[2]
    return along - centre[3] * plane[3]


@inner
def _span(a: Vector, b: Vector, apex: Vector, plane: Vector) -> bool:
    """The plane through two points and a centre (4,), if there is one."""
    size = 0.0
    for axis in range(3):
        j, k = (axis + 1) % 3, (axis + 2) % 3
        ux, uy = b[j] - a[j], b[k] - a[k]
        vx, vy = apex[3] * a[j] - apex[j], apex[3] * a[k] - apex[k]
        plane[axis] = ux * vy - uy * vx
        size += plane[axis] * plane[axis]
    if size < 1e-18:
        return False
    size, plane[3] = math.sqrt(size), 0.0
    for axis in range(3):
        plane[axis] /= size
    plane[3] = height(a, plane)
    return True


@inner
def _settle(centres: Vector, window: Vector, count: int, plane: Vector) -> int:
    """1 if everything lies on one side of a plane, which is turned to have it inside; else 0."""
    lowest, highest = 0.0, 0.0
    for i in range(count):
        here = height(window[i], plane)
        lowest, highest = min(lowest, here), max(highest, here)
    for k in range(centres.shape[0]):
        here = side_of(centres[k], plane)
        lowest, highest = min(lowest, here), max(highest, here)
    if (lowest < -TOUCH) == (highest > TOUCH):
        return 0
    if lowest < -TOUCH:
        for i in range(4):
            plane[i] = -plane[i]
    return 1
