"""The area that several convex polygons cover together."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flatland.blocking.clipping import compiled, inner

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


@compiled
def union_area(points: Array, first: Numbers) -> float:
    """Area of the union of convex polygons.

    points: (T, 2), corners in order; polygon p has first[p] … first[p + 1] − 1. Between neighbours
    among all x of corners and crossings, the length that a line of constant x has in the union is
    linear in x, so that its value in the middle tells the area. No case distinctions: what rounding
    does to a corner or a crossing, it does to the area, and no more.
    """
    count = first.size - 1
    least, most = np.full(count, math.inf), np.full(count, -math.inf)
    for p in range(count):
        for i in range(first[p], first[p + 1]):
            least[p], most[p] = min(least[p], points[i, 0]), max(most[p], points[i, 0])
    breaks = _breaks(points, first, least, most)
    breaks.sort()
    lows, highs = np.empty(count), np.empty(count)
    total = 0.0
    for i in range(breaks.size - 1):
        x, met = 0.5 * (breaks[i] + breaks[i + 1]), 0
        for p in range(count):
            if least[p] < x < most[p]:
                lows[met], highs[met] = _chord(points, first[p], first[p + 1], x)
                met += 1
        if met > 0:
            total += (breaks[i + 1] - breaks[i]) * _union_length(lows, highs, met)
    return total


@inner
def _breaks(points, first, least, most):  # type: ignore[no-untyped-def]
    """x of all corners, and of the points where edges of two polygons cross."""
    count = first[first.size - 1]
    found = np.empty(2 * count + 16)
    for i in range(count):
        found[i] = points[i, 0]
    for p in range(first.size - 1):
        for q in range(p):
            if least[p] >= most[q] or least[q] >= most[p]:
                continue
            for i in range(first[p], first[p + 1]):
                after = i + 1 if i + 1 < first[p + 1] else first[p]
                for j in range(first[q], first[q + 1]):
                    then = j + 1 if j + 1 < first[q + 1] else first[q]
                    a, b = _turn(points, j, then, i), _turn(points, j, then, after)
                    if a * b >= 0.0:
                        continue
                    if _turn(points, i, after, j) * _turn(points, i, after, then) >= 0.0:
                        continue
                    if count == found.size:
                        found = _longer(found)
                    x = points[i, 0]
                    found[count] = x + a / (a - b) * (points[after, 0] - x)
                    count += 1
    return found[:count]


@inner
def _longer(found):  # type: ignore[no-untyped-def]
    longer = np.empty(2 * found.size)
    for i in range(found.size):
        longer[i] = found[i]
    return longer


@inner
def _turn(points, a, b, c):  # type: ignore[no-untyped-def]
    """Positive if a, b, c turn to the left."""
    x, y = points[a, 0], points[a, 1]
    return (points[b, 0] - x) * (points[c, 1] - y) - (points[b, 1] - y) * (points[c, 0] - x)


@inner
def _chord(points, start, stop, x):  # type: ignore[no-untyped-def]
    """Where a line of constant x enters and leaves a convex polygon."""
    low, high = math.inf, -math.inf
    for i in range(start, stop):
        j = i + 1 if i + 1 < stop else start
        here, there = points[i, 0], points[j, 0]
        if min(here, there) <= x <= max(here, there) and here != there:
            part = (x - here) / (there - here)
            y = points[i, 1] + part * (points[j, 1] - points[i, 1])
            low, high = min(low, y), max(high, y)
    return low, high


@inner
def _union_length(lows, highs, count):  # type: ignore[no-untyped-def]
    """Length of the union of intervals; sorts them."""
    total, reached = 0.0, -math.inf
    for i in range(count):
        smallest = i
        for j in range(i + 1, count):
            if lows[j] < lows[smallest]:
                smallest = j
        low, high = lows[smallest], highs[smallest]
        lows[smallest], highs[smallest] = lows[i], highs[i]
        total += max(high - max(low, reached), 0.0)
        reached = max(reached, high)
    return total
