"""What is seen of a convex window from a centre, past all walls, as convex pieces.

The window is an area light seen from a point of a face, or a face seen from a point light. A centre
(4,) is homogeneous: (x, y, z, 1), or (-ω, 0) for parallel light that travels along ω. It lies on
the positive side of the window's plane, and only walls on that side hide anything. A wall hides the
cone (or prism) that its edges span with the centre. Walls whose plane holds the centre are seen
edge-on and hide nothing: a point on a wall sees both its sides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner
from propagators.analytic_3d.cuts import ROOM, height, keep_inside, subtract
from propagators.analytic_3d.plates import TOUCH, Plates

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]

#: A plane that keeps everything.
EVERYWHERE = np.array([0.0, 0.0, 0.0, -1.0])


class Work(NamedTuple):
    """Work space of one thread, for W walls: no allocation per point.

    window, between: (ROOM, 3) polygons. rest: (3, ROOM, 3). blockers: (W, ROOM, 3) with counts and
    planes (W, 4). edges: (ROOM, 4) planes of a shadow. bounds: (2, 3).
    """

    window: Vector
    between: Vector
    rest: Vector
    blockers: Vector
    counts: Counts
    planes: Vector
    edges: Vector
    bounds: Vector


@inner
def make_work(walls: int) -> Work:
    """Work space for at most `walls` blockers."""
    return Work(
        np.empty((ROOM, 3)),
        np.empty((ROOM, 3)),
        np.empty((3, ROOM, 3)),
        np.empty((walls, ROOM, 3)),
        np.empty(walls, np.int64),
        np.empty((walls, 4)),
        np.empty((ROOM, 4)),
        np.empty((2, 3)),
    )


@inner
def collect_blockers(
    centres: Vector,
    window: Vector,
    count: int,
    plane: Vector,
    extra: Vector,
    walls: Plates,
    work: Work,
) -> int:
    """Walls that may stand between any of the centres (K, 4) and a window, to `work`; their number.

    plane: the window's. extra: another plane inside which walls must lie. Walls are cut by both;
    those kept in vain cost time only.
    """
    _bound(centres, window, count, work.bounds)
    found = 0
    for p in range(walls.planes.shape[0]):
        if not _may_stand_between(p, centres, window, count, walls, work.bounds):
            continue
        first = walls.first[p]
        own = walls.vertices[first : walls.first[p + 1]]
        size = keep_inside(own, own.shape[0], plane, work.between)
        if size < 3:
            continue
        size = keep_inside(work.between, size, extra, work.blockers[found])
        if size < 3:
            continue
        work.counts[found] = size
        for i in range(4):
            work.planes[found, i] = walls.planes[p, i]
        found += 1
    return found


@inner
def _bound(centres: Vector, window: Vector, count: int, bounds: Vector) -> None:
    """The box of the hull of window and centres; without end towards centres at infinity."""
    for axis in range(3):
        low, high = math.inf, -math.inf
        for i in range(count):
            low, high = min(low, window[i, axis]), max(high, window[i, axis])
        for k in range(centres.shape[0]):
            place = centres[k, axis]
            if centres[k, 3] == 0.0:
                place = math.copysign(math.inf, place) if place != 0.0 else low
            low, high = min(low, place), max(high, place)
        bounds[0, axis], bounds[1, axis] = low - TOUCH, high + TOUCH


@inner
def _may_stand_between(
    p: int, centres: Vector, window: Vector, count: int, walls: Plates, bounds: Vector
) -> bool:
    for axis in range(3):
        if walls.high[p, axis] < bounds[0, axis] or walls.low[p, axis] > bounds[1, axis]:
            return False
    plane = walls.planes[p]
    lowest, highest = math.inf, -math.inf
    for i in range(count):
        here = height(window[i], plane)
        lowest, highest = min(lowest, here), max(highest, here)
    for k in range(centres.shape[0]):
        here = side_of(centres[k], plane)
        lowest, highest = min(lowest, here), max(highest, here)
    return lowest < -TOUCH and highest > TOUCH


@inner
def side_of(centre: Vector, plane: Vector) -> float:
    """How far a centre lies in front of a plane; the cosine to its normal at infinity."""
    along = centre[0] * plane[0] + centre[1] * plane[1] + centre[2] * plane[2]
    return along - centre[3] * plane[3]


@inner
def see(
    centre: Vector,
    window: Vector,
    count: int,
    found: int,
    work: Work,
    pieces: Vector,
    sizes: Counts,
) -> tuple[Vector, Counts, int, bool]:
    """What of a window the first `found` blockers in `work` leave to be seen from a centre.

    Returns the pieces, their number and whether anything is hidden.
    """
    pieces[0, :count] = window[:count]
    sizes[0] = count
    left, hidden = 1, False
    for b in range(found):
        side = side_of(centre, work.planes[b])
        if abs(side) <= TOUCH:
            continue
        edges = _shadow(centre, work.blockers[b], work.counts[b], side, work.edges)
        pieces, sizes, left, cut = subtract(pieces, sizes, left, work.edges, edges, work.rest)
        hidden |= cut
        if left == 0:
            break
    return pieces, sizes, left, hidden


@inner
def _shadow(centre: Vector, blocker: Vector, count: int, side: float, planes: Vector) -> int:
    """The planes through the centre and a blocker's edges, inside towards its shadow."""
    edges = 0
    for i in range(count):
        a, b = blocker[i], blocker[i + 1 if i + 1 < count else 0]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = (
            centre[3] * a[0] - centre[0],
            centre[3] * a[1] - centre[1],
            centre[3] * a[2] - centre[2],
        )
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        size = math.sqrt(nx * nx + ny * ny + nz * nz)
        if size == 0.0:
            continue
        scale = math.copysign(1.0 / size, side)
        nx, ny, nz = nx * scale, ny * scale, nz * scale
        planes[edges, 0], planes[edges, 1], planes[edges, 2] = nx, ny, nz
        planes[edges, 3] = nx * a[0] + ny * a[1] + nz * a[2]
        edges += 1
    return edges
