"""Convex planar polygons cut by planes: all that visibility needs.

A convex polygon minus the shadow of another one falls into convex pieces, one per edge of the
shadow. Each cut is a plane, so that nothing has to be projected and no vertex lies at infinity.
Polygons are rows of arrays with more room than they use, planes (4,) normal and offset; what has
normal · v >= offset is inside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Vertices that one polygon may have. Plates have at most 8, and a cut adds one; no scene of the
#: tests came near it. A vertex too many is left out, which loses a corner.
ROOM = 32
#: Cells. A vertex nearer to a cutting plane than this lies on it and leaves no sliver.
ON_PLANE = 1e-12


@inner
def height(vertex: Vector, plane: Vector) -> float:
    """How far a vertex lies inside a plane."""
    return vertex[0] * plane[0] + vertex[1] * plane[1] + vertex[2] * plane[2] - plane[3]


@inner
def keep_inside(source: Vector, count: int, plane: Vector, target: Vector) -> int:
    """The part of a convex polygon inside a plane, to target; its number of vertices, 0 if none.

    Sutherland & Hodgman 1974.
    """
    kept, before = 0, height(source[count - 1], plane)
    largest = 0.0
    for i in range(count):
        here = height(source[i], plane)
        largest = max(largest, here)
        if (before > ON_PLANE and here < -ON_PLANE) or (before < -ON_PLANE and here > ON_PLANE):
            kept = _add_crossing(
                source[i - 1 if i else count - 1], source[i], before, here, target, kept
            )
        if here >= -ON_PLANE:
            kept = _add(source[i], target, kept)
        before = here
    return kept if largest > ON_PLANE else 0


@inner
def split(
    polygon: Vector, count: int, plane: Vector, inside: Vector, outside: Vector
) -> tuple[int, int]:
    """Both parts of a convex polygon; numbers of vertices, 0 for a part that is not there."""
    kept, left, before = 0, 0, height(polygon[count - 1], plane)
    highest, lowest = 0.0, 0.0
    for i in range(count):
        here = height(polygon[i], plane)
        highest, lowest = max(highest, here), min(lowest, here)
        if (before > ON_PLANE and here < -ON_PLANE) or (before < -ON_PLANE and here > ON_PLANE):
            last = polygon[i - 1 if i else count - 1]
            kept = _add_crossing(last, polygon[i], before, here, inside, kept)
            left = _add_crossing(last, polygon[i], before, here, outside, left)
        if here >= -ON_PLANE:
            kept = _add(polygon[i], inside, kept)
        if here <= ON_PLANE:
            left = _add(polygon[i], outside, left)
        before = here
    return kept if highest > ON_PLANE else 0, left if lowest < -ON_PLANE else 0


@inner
def subtract(
    pieces: Vector, sizes: Counts, count: int, planes: Vector, edges: int, work: Vector
) -> tuple[Vector, Counts, int, bool]:
    """Take what lies inside all planes (edges, 4) out of convex pieces (count, ROOM, 3).

    Returns the pieces, in arrays that may have grown, their number, and whether anything was
    taken. work: (3, ROOM, 3).
    """
    k, stop, cut = 0, count, False
    while k < stop:
        if not _overlaps(pieces[k], sizes[k], planes, edges, work):
            k += 1
            continue
        cut = True
        if count + edges > sizes.size:
            pieces, sizes = _grown(pieces, sizes, count)
        rest, other = work[0], work[1]
        rest[: sizes[k]] = pieces[k, : sizes[k]]
        size = sizes[k]
        for e in range(edges):
            size, left = split(rest, size, planes[e], other, pieces[count])
            rest, other = other, rest
            if left > 2:
                sizes[count] = left
                count += 1
        # The rest is hidden. The last old piece takes its place, the last new one that one's.
        stop, count = stop - 1, count - 1
        _move(pieces, sizes, stop, k)
        _move(pieces, sizes, count, stop)
    return pieces, sizes, count, cut


@inner
def _overlaps(piece: Vector, size: int, planes: Vector, edges: int, work: Vector) -> bool:
    """Whether anything of a piece lies inside all planes."""
    for e in range(edges):
        highest = 0.0
        for i in range(size):
            highest = max(highest, height(piece[i], planes[e]))
        if highest <= ON_PLANE:
            return False
    rest, other = work[0], work[1]
    rest[:size] = piece[:size]
    for e in range(edges):
        size = keep_inside(rest, size, planes[e], other)
        if size < 3:
            return False
        rest, other = other, rest
    return True


@inner
def _move(pieces: Vector, sizes: Counts, source: int, target: int) -> None:
    if source != target:
        sizes[target] = sizes[source]
        pieces[target, : sizes[source]] = pieces[source, : sizes[source]]


@inner
def _grown(pieces: Vector, sizes: Counts, count: int) -> tuple[Vector, Counts]:
    wider, longer = np.empty((2 * sizes.size, ROOM, 3)), np.empty(2 * sizes.size, np.int64)
    wider[:count], longer[:count] = pieces[:count], sizes[:count]
    return wider, longer


@inner
def _add(vertex: Vector, target: Vector, count: int) -> int:
    if count == ROOM:
        return count
    target[count, 0], target[count, 1], target[count, 2] = vertex[0], vertex[1], vertex[2]
    return count + 1


@inner
def _add_crossing(
    start: Vector, stop: Vector, before: float, here: float, target: Vector, count: int
) -> int:
    """Append where the edge from start to stop, at these heights, meets the plane."""
    if count == ROOM:
        return count
    share = before / (before - here)
    for axis in range(3):
        target[count, axis] = start[axis] + share * (stop[axis] - start[axis])
    return count + 1
