"""Where segments touch or cross."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH
from propagators.analytic.compiling import inner, shared

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]


def find_meetings(segments: Vector) -> tuple[Counts, Vector]:
    """Where to cut segments (S, 4), so that what is left meets in ends only.

    Returns the segment (K,) and the point (K, 2) of each cut. An end that lies on another segment
    is the point itself, so that both share it to the last digit.
    """
    rows = np.empty((0, 3))
    count = _find(segments, rows)
    if count:
        rows = np.empty((count, 3))
        _find(segments, rows)
    return rows[:, 0].astype(np.int64), rows[:, 1:]


@shared
def _find(segments: Vector, rows: Vector) -> int:
    """Rows (segment, x, y) of all cuts as far as there is room; how many there are."""
    count = 0
    for i in range(segments.shape[0]):
        low_x = min(segments[i, 0], segments[i, 2]) - TOUCH
        high_x = max(segments[i, 0], segments[i, 2]) + TOUCH
        low_y = min(segments[i, 1], segments[i, 3]) - TOUCH
        high_y = max(segments[i, 1], segments[i, 3]) + TOUCH
        for j in range(i):
            if max(segments[j, 0], segments[j, 2]) < low_x:
                continue
            if min(segments[j, 0], segments[j, 2]) > high_x:
                continue
            if max(segments[j, 1], segments[j, 3]) < low_y:
                continue
            if min(segments[j, 1], segments[j, 3]) > high_y:
                continue
            count = _meet(segments, i, j, rows, count)
    return count


@inner
def _meet(segments: Vector, i: int, j: int, rows: Vector, count: int) -> int:
    first, second = segments[i], segments[j]
    c0, c1 = _distance(first, second[0], second[1]), _distance(first, second[2], second[3])
    d0, d1 = _distance(second, first[0], first[1]), _distance(second, first[2], first[3])
    before = count
    count = _touch(first, i, second, c0, c1, rows, count)
    count = _touch(second, j, first, d0, d1, rows, count)
    apart = min(abs(c0), abs(c1), abs(d0), abs(d1)) > TOUCH
    if count == before and apart and c0 * c1 < 0.0 and d0 * d1 < 0.0:
        share = c0 / (c0 - c1)
        x = second[0] + share * (second[2] - second[0])
        y = second[1] + share * (second[3] - second[1])
        count = _store(rows, count, i, x, y)
        count = _store(rows, count, j, x, y)
    return count


@inner
def _touch(
    cut: Vector, place: int, other: Vector, d0: float, d1: float, rows: Vector, count: int
) -> int:
    """Cuts a segment where the ends of another, at distances d0 and d1 from its line, lie on it."""
    for end in range(2):
        if abs(d0 if end == 0 else d1) <= TOUCH:
            x, y = other[2 * end], other[2 * end + 1]
            length = math.hypot(cut[2] - cut[0], cut[3] - cut[1])
            along = (x - cut[0]) * (cut[2] - cut[0]) + (y - cut[1]) * (cut[3] - cut[1])
            if TOUCH < along / length < length - TOUCH:
                count = _store(rows, count, place, x, y)
    return count


@inner
def _store(rows: Vector, count: int, place: int, x: float, y: float) -> int:
    if count < rows.shape[0]:
        rows[count, 0], rows[count, 1], rows[count, 2] = place, x, y
    return count + 1


@inner
def _distance(segment: Vector, x: float, y: float) -> float:
    """How far a point lies to the left of a segment's line."""
    ex, ey = segment[2] - segment[0], segment[3] - segment[1]
    return (ex * (y - segment[1]) - ey * (x - segment[0])) / math.hypot(ex, ey)
