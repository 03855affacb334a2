"""Which part of an emitter a target sees, and where along the target that changes.

Works in the target's frame (see `strings`). Seen from a point of the target, everything on the
light's side spans less than half a turn, so directions are ordered by a key without
trigonometry. A blocker hides the directions between its ends; what stays of the emitter is
bounded by the edges (ends) of segments. Which edges bound it changes only where two edges line
up with the point, or where a blocker meets the target: those positions are `breaks`, and between
them the strings are exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner

Vector = NDArray[np.float64]

#: Cells. What is nearer to a line than this lies on it: light arrives there, nothing is hidden.
TOUCH = 1e-10


class Scratch(NamedTuple):
    """Work space of one thread, for S segments: no allocation per target.

    edges: (t, d) of the emitter's two ends (lower key first), then of both ends of each blocker.
    lower, upper: edge at each end of what a blocker hides; key_lower, key_upper: their keys.
    order: blockers by key_lower. arcs, previous: pairs of edges that bound what is seen.
    """

    edges: Vector
    breaks: Vector
    key_lower: Vector
    key_upper: Vector
    lower: NDArray[np.int64]
    upper: NDArray[np.int64]
    order: NDArray[np.int64]
    inside: NDArray[np.int64]
    arcs: NDArray[np.int64]
    previous: NDArray[np.int64]


@inner
def make_scratch(wall_count: int) -> Scratch:
    """Scratch for at most `wall_count` blockers."""
    s = wall_count + 1
    return Scratch(
        np.empty((2 * s, 2)),
        np.empty(64 + 8 * s),
        np.empty(s),
        np.empty(s),
        np.empty(s, np.int64),
        np.empty(s, np.int64),
        np.empty(s, np.int64),
        np.empty(2 * s, np.int64),
        np.empty(2 * s, np.int64),
        np.empty(2 * s, np.int64),
    )


@inner
def front_parts(emitters: Vector, walls: Vector) -> tuple[Vector, NDArray[np.int64]]:
    """What of the walls (S, 4) lies in front of each emitter (E, 4): on its left.

    Returns parts (E, S, 4), of which the first counts (E,) rows are filled. Only what lies there
    can stand between the emitter and a point that it lights; a wall on the emitter's own line,
    such as the emitter itself, cannot.
    """
    parts = np.empty((emitters.shape[0], walls.shape[0], 4))
    counts = np.zeros(emitters.shape[0], np.int64)
    for e in range(emitters.shape[0]):
        ax, ay = emitters[e, 0], emitters[e, 1]
        ex, ey = emitters[e, 2] - ax, emitters[e, 3] - ay
        length = np.sqrt(ex * ex + ey * ey)
        for s in range(walls.shape[0]):
            x0, y0, x1, y1 = walls[s, 0], walls[s, 1], walls[s, 2], walls[s, 3]
            f0 = (ex * (y0 - ay) - ey * (x0 - ax)) / length
            f1 = (ex * (y1 - ay) - ey * (x1 - ax)) / length
            if max(f0, f1) <= TOUCH:
                continue
            row = parts[e, counts[e]]
            row[0], row[1], row[2], row[3] = clip(x0, y0, x1, y1, f0, f1)
            counts[e] += 1
    return parts, counts


@inner
def clip(
    x0: float, y0: float, x1: float, y1: float, f0: float, f1: float
) -> tuple[float, float, float, float]:
    """The part of a segment where a function that is linear along it, f0 to f1, is not negative.

    The larger of f0 and f1 must be positive.
    """
    if f0 < 0.0:
        s = f0 / (f0 - f1)
        return x0 + s * (x1 - x0), y0 + s * (y1 - y0), x1, y1
    if f1 < 0.0:
        s = f1 / (f1 - f0)
        return x0, y0, x1 + s * (x0 - x1), y1 + s * (y0 - y1)
    return x0, y0, x1, y1


@inner
def side(t: float, edges: Vector, v: int, w: int) -> float:
    """Positive if edge v is seen at a larger key than edge w from the target's point t."""
    return (edges[v, 0] - t) * edges[w, 1] - (edges[w, 0] - t) * edges[v, 1]


@inner
def key(t: float, edges: Vector, v: int) -> float:
    """Grows from -1 (towards -t) to 1 (towards +t) with the direction in which v is seen."""
    along = edges[v, 0] - t
    total = abs(along) + edges[v, 1]
    return along / total if total > 0.0 else 0.0


@inner
def collect_blockers(
    x: float,
    y: float,
    nx: float,
    ny: float,
    t0: float,
    t1: float,
    parts: Vector,
    count: int,
    work: Scratch,
) -> int:
    """Blockers between the emitter and [t0, t1] to work.edges; their number, -1 if all is dark.

    x, y and nx, ny: origin and normal of the target's frame. work.edges holds the emitter's ends
    already. A blocker that lies on the target's line hides nothing from it.
    """
    edges = work.edges
    found = 0
    for k in range(count):
        x0, y0, x1, y1 = parts[k, 0], parts[k, 1], parts[k, 2], parts[k, 3]
        d0 = -((x0 - x) * nx + (y0 - y) * ny)
        d1 = -((x1 - x) * nx + (y1 - y) * ny)
        if max(d0, d1) <= TOUCH:
            continue
        ta = (y0 - y) * nx - (x0 - x) * ny
        tb = (y1 - y) * nx - (x1 - x) * ny
        v, w = 2 + 2 * found, 3 + 2 * found
        edges[v, 0], edges[v, 1], edges[w, 0], edges[w, 1] = clip(ta, d0, tb, d1, d0, d1)
        edges[v, 1], edges[w, 1] = max(edges[v, 1], 0.0), max(edges[w, 1], 0.0)
        # Beside the hull of emitter and target; 0 also means an emitter that touches the target.
        if max(side(t0, edges, v, 0), side(t0, edges, w, 0)) < -TOUCH:
            continue
        if min(side(t1, edges, v, 1), side(t1, edges, w, 1)) > TOUCH:
            continue
        if hides_all(t0, t1, edges, v, w) or hides_all(t0, t1, edges, w, v):
            return -1
        found += 1
    return found


@inner
def hides_all(t0: float, t1: float, edges: Vector, v: int, w: int) -> bool:
    """Whether the emitter (edges 0 and 1) lies between v and w as seen from all of [t0, t1].

    An end on the target's own line is seen along it: which way depends on the point.
    """
    if edges[v, 1] <= TOUCH and edges[v, 0] > t0:
        return False
    if edges[w, 1] <= TOUCH and edges[w, 0] < t1:
        return False
    return (
        side(t0, edges, v, 0) <= 0.0
        and side(t1, edges, v, 0) <= 0.0
        and side(t0, edges, w, 1) >= 0.0
        and side(t1, edges, w, 1) >= 0.0
    )


@inner
def collect_breaks(t0: float, t1: float, blockers: int, work: Scratch, breaks: Vector) -> int:
    """Positions in (t0, t1) where what is seen changes its edges, unsorted, some harmless extra.

    Returns how many there are; those beyond the size of `breaks` are not stored.
    """
    edges, inside = work.edges, work.inside
    inside[0], inside[1], visible = 0, 1, 2
    count = 0
    for v in range(2, 2 + 2 * blockers):
        if edges[v, 1] <= TOUCH and t0 < edges[v, 0] < t1:
            if count < breaks.size:
                breaks[count] = edges[v, 0]
            count += 1
        if side(t0, edges, v, 0) >= -TOUCH and side(t1, edges, v, 1) <= TOUCH:
            inside[visible] = v
            visible += 1
    for i in range(2, visible):
        for j in range(i):
            v, w = inside[i], inside[j]
            at_start, at_end = side(t0, edges, v, w), side(t1, edges, v, w)
            if at_start * at_end >= 0.0:
                continue
            t = t0 + (t1 - t0) * (at_start / (at_start - at_end))
            if is_seen(t, v, w, blockers, edges):
                if count < breaks.size:
                    breaks[count] = t
                count += 1
    return count


@inner
def is_seen(t: float, v: int, w: int, blockers: int, edges: Vector) -> bool:
    """Whether the sight line from t through the edges v and w can reach the emitter.

    In doubt (within TOUCH) yes: a break too many changes nothing.
    """
    far = v if edges[v, 1] > edges[w, 1] else w
    if side(t, edges, far, 0) < -TOUCH or side(t, edges, far, 1) > TOUCH:
        return False
    for k in range(blockers):
        a, b = 2 + 2 * k, 3 + 2 * k
        if a in (v, w) or b in (v, w):
            continue
        side_a, side_b = side(t, edges, a, far), side(t, edges, b, far)
        if (side_a < -TOUCH and side_b > TOUCH) or (side_b < -TOUCH and side_a > TOUCH):
            return False
    return True


@inner
def collect_arcs(t: float, blockers: int, work: Scratch) -> int:
    """Pairs of edges between which the emitter is seen from t, to work.arcs; their number.

    work.order must hold a permutation of the blockers; it is kept sorted from call to call, so
    that the next position finds it nearly sorted.
    """
    edges, order = work.edges, work.order
    for k in range(blockers):
        a, b = 2 + 2 * k, 3 + 2 * k
        key_a, key_b = key(t, edges, a), key(t, edges, b)
        if key_a > key_b:
            a, b, key_a, key_b = b, a, key_b, key_a
        work.lower[k], work.upper[k] = a, b
        work.key_lower[k], work.key_upper[k] = key_a, key_b
    for k in range(1, blockers):
        moved, place = order[k], k
        while place > 0 and work.key_lower[order[place - 1]] > work.key_lower[moved]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = moved
    return _gaps(key(t, edges, 0), key(t, edges, 1), blockers, work)


@inner
def _gaps(start: float, stop: float, blockers: int, work: Scratch) -> int:
    """What the blockers, in order, leave of the keys from start to stop (edges 0 and 1)."""
    reached, edge, count = start, 0, 0
    for position in range(blockers):
        k = work.order[position]
        if work.key_lower[k] >= stop:
            break
        if work.key_lower[k] > reached:
            work.arcs[2 * count], work.arcs[2 * count + 1] = edge, work.lower[k]
            count += 1
        if work.key_upper[k] > reached:
            reached, edge = work.key_upper[k], work.upper[k]
    if reached < stop:
        work.arcs[2 * count], work.arcs[2 * count + 1] = edge, 1
        count += 1
    return count
