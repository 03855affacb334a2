"""Which part of an emitter a target sees, and where along the target that changes.

Seen from a point of the target, everything on the light's side spans less than half a turn, so
directions are ordered by a key without trigonometry. A blocker hides the directions between its
ends; what stays of the emitter is bounded by the edges (ends) of segments. Which edges bound it
changes only where two edges line up with the point, or where a blocker meets the target: those
positions are the breaks, and between them the strings are exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH, Scratch, side
from propagators.analytic.compiling import inner

Vector = NDArray[np.float64]


@inner
def collect_breaks(t0: float, t1: float, blockers: int, work: Scratch, breaks: Vector) -> int:
    """Positions in (t0, t1) where what is seen changes its edges, unsorted, some harmless extra.

    Returns how many there are; those beyond the size of `breaks` are not stored.
    """
    edges, inside = work.edges, work.inside
    inside[0], inside[1], visible = 0, 1, 2
    count = 0
    for v in range(2, 2 + 2 * blockers):
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


@inner
def key(t: float, edges: Vector, v: int) -> float:
    """Grows from -1 (towards -t) to 1 (towards +t) with the direction in which v is seen."""
    along = edges[v, 0] - t
    total = abs(along) + edges[v, 1]
    return along / total if total > 0.0 else 0.0
