"""Convex polygons in a plane, for kernels: cut by a line, kept in lists, measured."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Vertices that a working polygon has room for.
ROOM = 64

kernel = njit(cache=True, error_model="numpy", nogil=True)


class Polygons(NamedTuple):
    """Convex polygons (K,), counter-clockwise.

    vertices: (T, 2), of which first[k] … first[k + 1] - 1 are polygon k's. tags: (K, L), whole
    numbers that say what each is.
    """

    vertices: Array
    first: Indices
    tags: Indices

    def split(self) -> list[Array]:
        """Each by itself, (V, 2)."""
        return np.split(self.vertices, self.first[1:-1])[: len(self.tags)]


# Kernels below copy numbers one by one: assigning slices takes seconds more to compile.


@kernel
def split(
    polygon: Array, count: int, line: Array, slack: float, left: Array, right: Array
) -> tuple[int, int]:
    """Cut by a line: vertices of the part with line·(u, v, 1) ≥ 0 and of the rest.

    Vertices within `slack` of the line count as on it; a part that has no others is empty.
    """
    most, least = -np.inf, np.inf
    for i in range(count):
        value = _beside(line, polygon[i], slack)
        most, least = max(most, value), min(least, value)
    m, n = 0, 0
    u, v = polygon[count - 1]
    a = _beside(line, polygon[count - 1], slack)
    for i in range(count):
        b = _beside(line, polygon[i], slack)
        if a * b < 0.0:
            part = a / (a - b)
            left[m, 0] = right[n, 0] = u + part * (polygon[i, 0] - u)
            left[m, 1] = right[n, 1] = v + part * (polygon[i, 1] - v)
            m, n = m + 1, n + 1
        u, v, a = polygon[i, 0], polygon[i, 1], b
        if b >= 0.0:
            left[m, 0], left[m, 1] = u, v
            m += 1
        if b <= 0.0 and least < 0.0:
            right[n, 0], right[n, 1] = u, v
            n += 1
    return (m if most > 0.0 or least == 0.0 else 0), n


@kernel
def _beside(line: Array, point: Array, slack: float) -> float:
    value = linear(line, point)
    return 0.0 if abs(value) <= slack else value


@kernel
def linear(coefficients: Array, point: Array) -> float:
    """Product of (3,) and the ray through a point (2,)."""
    return coefficients[0] * point[0] + coefficients[1] * point[1] + coefficients[2]


@kernel
def copy(source: Array, begin: int, end: int, target: Array, at: int) -> int:
    """Rows begin … end - 1 to rows at …; the row after them."""
    for i in range(begin, end):
        for k in range(source.shape[1]):
            target[at + i - begin, k] = source[i, k]
    return at + end - begin


@kernel
def roomier(table: Array, used: int, needed: int) -> Array:
    """The same table, or one twice as long if that has no room for `needed` rows."""
    if needed <= table.shape[0]:
        return table
    longer = np.empty((2 * needed, table.shape[1]), table.dtype)
    copy(table, 0, used, longer, 0)
    return longer


@kernel
def measure(vertices: Array, first: Indices, angular: bool) -> tuple[Array, Array]:
    """Areas (K,) of polygons and their centroids (K, 2).

    angular: solid angles instead, seen from the origin of space with the plane at z = 1. Summed
    over triangles (van Oosterom & Strackee 1983, eq. 8), whose volume is twice their area here, so
    that small ones lose no digits.
    """
    total = first.size - 1
    sizes, middles = np.zeros(total), np.empty((total, 2))
    for k in range(total):
        a = vertices[first[k]]
        double, across, up = 0.0, 0.0, 0.0
        for i in range(first[k] + 1, first[k + 1] - 1):
            b, c = vertices[i], vertices[i + 1]
            part = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            double += part
            across += part * (b[0] + c[0] - 2.0 * a[0])
            up += part * (b[1] + c[1] - 2.0 * a[1])
            sizes[k] += _solid_angle(a, b, c, part) if angular else 0.5 * part
        scale = 1.0 / (3.0 * double) if double > 0.0 else 0.0
        middles[k, 0], middles[k, 1] = a[0] + scale * across, a[1] + scale * up
    return sizes, middles


@kernel
def _solid_angle(a: Array, b: Array, c: Array, volume: float) -> float:
    to_a, to_b, to_c = _length(a), _length(b), _length(c)
    rest = to_a * to_b * to_c
    rest += (1.0 + a[0] * b[0] + a[1] * b[1]) * to_c
    rest += (1.0 + b[0] * c[0] + b[1] * c[1]) * to_a
    rest += (1.0 + c[0] * a[0] + c[1] * a[1]) * to_b
    return 2.0 * np.arctan2(volume, rest)


@kernel
def _length(point: Array) -> float:
    return np.sqrt(1.0 + point[0] * point[0] + point[1] * point[1])
