"""Convex polygons in beam coordinates, clipped and measured: for kernels only.

A polygon is the first `count` rows of a buffer, its corners in order. The first two columns are
the coordinates across a beam, in which areas are taken. Loops are written out: array expressions
would take most of the time that these kernels compile.
"""

from __future__ import annotations

import math

from numba import njit

compiled = njit(cache=True, error_model="numpy", nogil=True)
#: For functions that only kernels call: no wrapper for Python to compile.
inner = njit(
    cache=True, error_model="numpy", nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True
)


@inner
def copy(source, count, target):  # type: ignore[no-untyped-def]
    for i in range(count):
        for k in range(source.shape[1]):
            target[i, k] = source[i, k]


@inner
def clip_to_slab(polygon, count, column, low, high, between):  # type: ignore[no-untyped-def]
    """Keep low ≤ x ≤ high of a column, in place; the number of corners left.

    `between`: a buffer of the same size.
    """
    count = clip(polygon, count, column, 1.0, low, between)
    return clip(polygon, count, column, -1.0, -high, between)


@inner
def clip(polygon, count, column, sign, limit, between):  # type: ignore[no-untyped-def]
    """Keep sign · x ≥ limit of a column, in place (Sutherland & Hodgman 1974)."""
    least = math.inf
    for i in range(count):
        least = min(least, sign * polygon[i, column])
    if least >= limit:
        return count
    copy(polygon, count, between)
    kept = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        a, b = sign * between[i, column] - limit, sign * between[j, column] - limit
        if a >= 0:
            for k in range(polygon.shape[1]):
                polygon[kept, k] = between[i, k]
            kept += 1
        if (a > 0 and b < 0) or (a < 0 and b > 0):
            part = a / (a - b)
            for k in range(polygon.shape[1]):
                polygon[kept, k] = between[i, k] + part * (between[j, k] - between[i, k])
            kept += 1
    return kept


@inner
def signed_area(polygon, count):  # type: ignore[no-untyped-def]
    """Of the projection to the first two columns; positive if corners run counter-clockwise."""
    total = 0.0
    for i in range(1, count - 1):
        ax, ay = polygon[i, 0] - polygon[0, 0], polygon[i, 1] - polygon[0, 1]
        bx, by = polygon[i + 1, 0] - polygon[0, 0], polygon[i + 1, 1] - polygon[0, 1]
        total += ax * by - ay * bx
    return 0.5 * total
