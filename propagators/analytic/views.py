"""What is seen of a segment from one point, and the arcs of directions that it fills."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH, Scratch, clip
from propagators.analytic.compiling import inner
from propagators.analytic.visibility import collect_arcs

Vector = NDArray[np.float64]


@inner
def view(x: float, y: float, target: Vector, walls: Vector, work: Scratch) -> int:
    """How many parts of a segment are seen from (x, y), which must be on its left; 0 otherwise.

    work.arcs holds the edges that bound each part, work.edges where these are from (x, y): along
    the segment, from its stop to its start, and towards it. Walls through (x, y) or on the
    segment's line hide nothing: a point on a wall sees both its sides.
    """
    ax, ay, bx, by = target[0], target[1], target[2], target[3]
    size = math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
    ex, ey = (bx - ax) / size, (by - ay) / size
    depth = (ax - x) * ey - (ay - y) * ex
    if depth <= TOUCH:
        return 0
    edges = work.edges
    edges[0, 0], edges[0, 1] = -(bx - x) * ex - (by - y) * ey, depth
    edges[1, 0], edges[1, 1] = -(ax - x) * ex - (ay - y) * ey, depth
    blockers = 0
    for s in range(walls.shape[0]):
        x0, y0, x1, y1 = walls[s, 0] - x, walls[s, 1] - y, walls[s, 2] - x, walls[s, 3] - y
        if abs(x0 * y1 - y0 * x1) <= TOUCH * math.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2):
            continue
        d0, d1 = x0 * ey - y0 * ex, x1 * ey - y1 * ex
        if max(d0, d1) <= TOUCH or min(d0, d1) >= depth - TOUCH:
            continue
        t0, d0, t1, d1 = clip(-x0 * ex - y0 * ey, d0, -x1 * ex - y1 * ey, d1, d0, d1)
        t0, d0, t1, d1 = clip(t0, d0, t1, d1, depth - d0, depth - d1)
        v, w = 2 + 2 * blockers, 3 + 2 * blockers
        edges[v, 0], edges[v, 1], edges[w, 0], edges[w, 1] = t0, max(d0, 0.0), t1, max(d1, 0.0)
        work.order[blockers] = blockers
        blockers += 1
    return collect_arcs(0.0, blockers, work)


@inner
def add_arc(moments: Vector, low: float, high: float) -> None:
    """moments (2 order + 1,) += ∫ e^{ikθ} dθ from angle low to high, k = 0 … order.

    As products, sin(k half)/k and e^{ik middle}: short arcs lose no digits.
    """
    half, middle = 0.5 * (high - low), 0.5 * (high + low)
    moments[0] += high - low
    turn_real, turn_imaginary = math.cos(middle), math.sin(middle)
    real, imaginary = 1.0, 0.0
    for k in range(1, moments.size // 2 + 1):
        real, imaginary = (
            real * turn_real - imaginary * turn_imaginary,
            real * turn_imaginary + imaginary * turn_real,
        )
        chord = 2.0 * math.sin(k * half) / k
        moments[2 * k - 1] += chord * real
        moments[2 * k] += chord * imaginary


@inner
def add_view(
    x: float,
    y: float,
    target: Vector,
    walls: Vector,
    lobe: Vector,
    work: Scratch,
    arcs: Vector,
    lobe_arcs: Vector,
) -> None:
    """Adds the moments of the directions in which (x, y) sees the target to `arcs`.

    The part of them less than a quarter turn from the lobe's axis, (flux, x, y), to `lobe_arcs`.
    """
    seen = view(x, y, target, walls, work)
    if seen == 0:
        return
    ahead = math.atan2(target[0] - target[2], target[3] - target[1])
    offset = math.atan2(lobe[2], lobe[1]) - ahead
    offset -= 2 * math.pi * np.round(offset / (2 * math.pi))
    for k in range(seen):
        v, w = work.arcs[2 * k], work.arcs[2 * k + 1]
        high = math.atan2(-work.edges[v, 0], work.edges[v, 1])
        low = math.atan2(-work.edges[w, 0], work.edges[w, 1])
        add_arc(arcs, ahead + low, ahead + high)
        low, high = max(low, offset - 0.5 * math.pi), min(high, offset + 0.5 * math.pi)
        if lobe[0] != 0.0 and low < high:
            add_arc(lobe_arcs, ahead + low, ahead + high)
