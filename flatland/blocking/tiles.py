"""Which beams a wall cuts, in a frame where the beams are unit squares side by side.

Beam (A, B) is the square A ≤ a ≤ A + 1, B ≤ b ≤ B + 1. Its rays run along a; its centre ray is
b = B + 1/2, from the centre of one cell to that of the next.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

#: How walls reach a centre ray: from larger b, from smaller b, lying on it.
ABOVE, BELOW, ALONG = 1, 2, 4

#: Beam lengths. A wall this close to a centre ray touches it. A hundred times the snapping of
#: coordinates, so that a wall that snapping moves to the other side of a centre touches both ways.
TOUCH = 1e-7

_compiled = njit(cache=True, error_model="numpy", nogil=True)
#: For functions that only kernels call: no wrapper for Python to compile.
_inner = njit(cache=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)


@_compiled
def cut_tiles(walls: Array) -> tuple[Numbers, Array, NDArray[np.uint8], Numbers]:
    """What every wall does to every beam that it meets.

    walls: (S, 4), ends a0, b0, a1, b1. Returns tiles (M, 2); spans (M, 2), the part of 0 … 1
    across the beam that the wall covers; sides (M,), how the wall reaches the centre ray: a
    sum of ABOVE, BELOW and ALONG, or 0; and numbers (M,), which wall it is. A wall without length
    does nothing.
    Walks along each wall: work and memory are proportional to M.
    """
    capacity = _capacity(walls)
    tiles = np.empty((capacity, 2), np.int64)
    spans = np.empty((capacity, 2))
    sides = np.empty(capacity, np.uint8)
    numbers = np.empty(capacity, np.int64)
    count = 0
    for wall in range(walls.shape[0]):
        a0, b0, a1, b1 = walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
        if a0 == a1 and b0 == b1:
            continue
        if b0 > b1:
            a0, b0, a1, b1 = a1, b1, a0, b0
        for row in range(math.floor(b0), math.floor(b1) + 1):
            low, high = max(b0, float(row)), min(b1, row + 1.0)
            # The ends themselves, not interpolated: a wall on a grid line stays on it.
            start = a0 if low == b0 else a0 + (low - b0) * (a1 - a0) / (b1 - b0)
            stop = a1 if high == b1 else a0 + (high - b0) * (a1 - a0) / (b1 - b0)
            near, far = min(start, stop) - TOUCH, max(start, stop) + TOUCH
            for column in range(math.floor(near), math.floor(far) + 1):
                lower, upper = _span(start, low, stop, high, column)
                side = _sides(a0, b0, a1, b1, column, row + 0.5)
                if upper > lower or side != 0:
                    tiles[count, 0], tiles[count, 1] = column, row
                    spans[count, 0], spans[count, 1] = lower - row, upper - row
                    sides[count], numbers[count] = side, wall
                    count += 1
    return tiles[:count], spans[:count], sides[:count], numbers[:count]


@_inner
def _capacity(walls: Array) -> int:
    """An upper limit of the beams met: a row of length r along a meets at most r + 2 columns."""
    most = 0
    for wall in range(walls.shape[0]):
        along = abs(walls[wall, 2] - walls[wall, 0])
        across = abs(walls[wall, 3] - walls[wall, 1])
        most += int(along) + 2 * int(across) + 9
    return most


@_inner
def _span(start: float, low: float, stop: float, high: float, column: int) -> tuple[float, float]:
    """Which b a piece of wall, (start, low) to (stop, high), covers while column ≤ a ≤ column + 1.

    Both borders count: a wall on the line through cell centres cuts the beams on either side.
    """
    near, far = min(start, stop), max(start, stop)
    if far < column or near > column + 1:
        return low, low
    if near == far:
        return low, high
    slope = (high - low) / (stop - start)
    one = low + (max(near, float(column)) - start) * slope
    other = low + (min(far, column + 1.0) - start) * slope
    return max(low, min(one, other)), min(high, max(one, other))


@_inner
def _sides(a0: float, b0: float, a1: float, b1: float, column: int, middle: float) -> int:
    """How a wall with b0 ≤ b1 reaches the centre ray b = middle of a column; 0 if it does not."""
    if b0 > middle + TOUCH or b1 < middle - TOUCH:
        return 0
    if not _touches(a0, b0, a1, b1, column, middle):
        return 0
    if b0 == middle and b1 == middle:
        return ALONG
    return (ABOVE if b1 > middle else 0) + (BELOW if b0 < middle else 0)


@_inner
def _touches(a0: float, b0: float, a1: float, b1: float, column: int, middle: float) -> bool:
    """Whether a wall comes as near as TOUCH to the centre ray b = middle of a column.

    The crossing alone will not do: for a wall almost along the ray, rounding moves it far, while
    the distances between ends and lines stay exact.
    """
    if b0 < b1:
        height = min(max(middle, b0), b1)
        if _on_ray(a0 + (height - b0) * (a1 - a0) / (b1 - b0), height, column, middle):
            return True
    if _on_ray(a0, b0, column, middle) or _on_ray(a1, b1, column, middle):
        return True
    start = _distance(float(column), middle, a0, b0, a1, b1)
    return min(start, _distance(column + 1.0, middle, a0, b0, a1, b1)) <= TOUCH


@_inner
def _on_ray(a: float, b: float, column: int, middle: float) -> bool:
    return abs(b - middle) <= TOUCH and column - TOUCH <= a <= column + 1 + TOUCH


@_inner
def _distance(a: float, b: float, a0: float, b0: float, a1: float, b1: float) -> float:
    """Distance of a point from a wall."""
    da, db = a1 - a0, b1 - b0
    length = da * da + db * db
    part = 0.0
    if length > 0.0:
        part = min(max(((a - a0) * da + (b - b0) * db) / length, 0.0), 1.0)
    return math.hypot(a - a0 - part * da, b - b0 - part * db)
