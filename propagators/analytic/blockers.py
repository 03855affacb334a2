"""The walls that stand between an emitter and a target, in the target's frame (see `strings`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner, shared

Vector = NDArray[np.float64]

#: Cells. What is nearer to a line than this lies on it: light arrives there, nothing is hidden.
TOUCH = 1e-10


class Scratch(NamedTuple):
    """Work space of one thread, for S segments: no allocation per target.

    edges: (t, d) of the emitter's two ends (lower key first), then of both ends of each blocker.
    lower, upper: edge at each end of what a blocker hides; key_lower, key_upper: their keys.
    order: blockers by key_lower. inside: edges between the lines of sight to the emitter's ends.
    arcs, previous: pairs of edges that bound what is seen, here and at the last position.
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


@shared
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
