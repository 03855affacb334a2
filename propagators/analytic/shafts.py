"""What may stand between a target and an emitter, by the shaft that they span together."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH, clip
from propagators.analytic.compiling import inner

Vector = NDArray[np.float64]


@inner
def distance_to(segment: Vector, x: float, y: float) -> float:
    """How far a point lies to the left of a segment's line."""
    ex, ey = segment[2] - segment[0], segment[3] - segment[1]
    return (ex * (y - segment[1]) - ey * (x - segment[0])) / math.sqrt(ex * ex + ey * ey)


@inner
def keep_between(target: Vector, emitter: Vector, parts: Vector, count: int, kept: Vector) -> int:
    """Those of `parts` (front of the emitter) that may hide it from the target; their number.

    -1 if nothing of the emitter reaches the target's left. The shaft is the hull of what the two
    have in front of one another (Haines and Wallace 1991); its four sides are, counter-clockwise,
    the target, a string, the emitter, a string. Every wall outside one side is left out; one that
    reaches from string to string hides everything. Parts kept in vain cost time only.
    """
    a, b = distance_to(target, emitter[0], emitter[1]), distance_to(target, emitter[2], emitter[3])
    f, g = distance_to(emitter, target[0], target[1]), distance_to(emitter, target[2], target[3])
    if max(a, b) <= TOUCH or max(f, g) <= TOUCH:
        return -1
    e0x, e0y, e1x, e1y = clip(emitter[0], emitter[1], emitter[2], emitter[3], a, b)
    t0x, t0y, t1x, t1y = clip(target[0], target[1], target[2], target[3], f, g)
    ux, uy, vx, vy = e0x - t1x, e0y - t1y, t0x - e1x, t0y - e1y
    u, v = math.sqrt(ux * ux + uy * uy), math.sqrt(vx * vx + vy * vy)
    # Strings without length: target and emitter touch, and nothing lies beside them.
    open_u, open_v = u > TOUCH, v > TOUCH
    found = 0
    for k in range(count):
        x0, y0, x1, y1 = parts[k, 0], parts[k, 1], parts[k, 2], parts[k, 3]
        u0, u1 = ux * (y0 - t1y) - uy * (x0 - t1x), ux * (y1 - t1y) - uy * (x1 - t1x)
        v0, v1 = vx * (y0 - e1y) - vy * (x0 - e1x), vx * (y1 - e1y) - vy * (x1 - e1x)
        if (open_u and max(u0, u1) <= TOUCH * u) or (open_v and max(v0, v1) <= TOUCH * v):
            continue
        d0, d1 = distance_to(target, x0, y0), distance_to(target, x1, y1)
        if max(d0, d1) <= TOUCH:
            continue
        g0, g1 = distance_to(emitter, x0, y0), distance_to(emitter, x1, y1)
        closes = _closes(u0, u1, v0, v1, d0, d1, g0, g1) or _closes(u1, u0, v1, v0, d1, d0, g1, g0)
        if open_u and open_v and closes:
            return -1
        for i in range(4):
            kept[found, i] = parts[k, i]
        found += 1
    return found


@inner
def _closes(
    u0: float, u1: float, v0: float, v1: float, d0: float, d1: float, g0: float, g1: float
) -> bool:
    """Whether a wall reaches from string u, at its end 0, to string v between target and emitter.

    u, v, d, g: distances of its ends from the strings, the target's line and the emitter's. What
    meets a string on one of these two lines may do so beside the string: it is not judged here.
    """
    if u0 > 0.0 or v1 > 0.0 or u1 <= u0 or v0 <= v1:
        return False
    at_u, at_v = u0 / (u0 - u1), v1 / (v1 - v0)
    from_target = min(d0 + at_u * (d1 - d0), d1 + at_v * (d0 - d1))
    return min(from_target, g0 + at_u * (g1 - g0), g1 + at_v * (g0 - g1)) > TOUCH
