"""Which wall a light sees first: a depth buffer whose cells are cut where walls begin and cross."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.shadow_map.views import Array, Indices, View

#: Relative difference in nearness below which two walls lie on one another: the first listed wins.
SAME = 1e-12
#: Rounds of cutting at crossings. Each round settles at least the middle of every interval, so
#: only walls that cross again and again in front of one another would need more.
MOST_ROUNDS = 64

_compiled = njit(cache=True, error_model="numpy", nogil=True)


class Intervals(NamedTuple):
    """Keys low < high (K,), in order, and the row of the view that is seen (K,), or -1."""

    low: Array
    high: Array
    row: Indices


def nearest_walls(view: View) -> Intervals:
    """Intervals of keys in each of which one wall, or none, is seen first.

    Cut at the borders of texels, at the ends of walls, and where walls that are seen cross. In an
    interval that no wall begins or ends in, the nearness of two walls differs by a linear function
    of the ray, with at most one zero: who is nearest in the middle and at both ends is nearest
    all over.
    """
    events = np.unique(np.concatenate([view.borders, view.spans.ravel()]))
    finest = SAME * np.abs(view.borders).max()
    for _ in range(MOST_ROUNDS):
        low, high = events[:-1], events[1:]
        rays = np.stack([view.rays(keys) for keys in (low, 0.5 * (low + high), high)], axis=1)
        first, last = np.searchsorted(events, view.spans).T
        row = _seen_first(rays, view.nearness, first, last)
        ways = _ways_to_crossings(rays, view.nearness, first, last, row)[..., None]
        # A difference that is linear in the ray is zero on the mix of rays with these parts.
        keys = view.keys((1 - ways) * rays[:, ::2] + ways * rays[:, 1:2])
        inside = (keys > low[:, None] + finest) & (keys < high[:, None] - finest)
        crossed = keys[inside & (ways[..., 0] > 0)]
        if not crossed.size:
            break
        events = np.union1d(events, crossed)
    return Intervals(low, high, row)


@_compiled
def _seen_first(rays: Array, nearness: Array, first: Indices, last: Indices) -> Indices:
    """The wall nearest on the middle ray of each interval (K,); -1 where there is none.

    rays: (K, 3, 2), at the lower end, the middle and the upper end. first, last: (R,), the
    intervals that each wall spans.
    """
    best = np.zeros(rays.shape[0])
    row = np.full(rays.shape[0], -1)
    for wall in range(nearness.shape[0]):
        for k in range(first[wall], last[wall]):
            near = nearness[wall, 0] * rays[k, 1, 0] + nearness[wall, 1] * rays[k, 1, 1]
            if near > best[k] * (1.0 + SAME):
                best[k], row[k] = near, wall
    return row


@_compiled
def _ways_to_crossings(
    rays: Array, nearness: Array, first: Indices, last: Indices, row: Indices
) -> NDArray[np.float64]:
    """Where the wall seen in the middle of an interval stops being the nearest, (K, 2).

    As part of the way from the lower and from the upper end to the middle ray; the crossing that
    is closest to the middle. 0 where there is none.
    """
    ways = np.zeros((rays.shape[0], 2))
    for wall in range(nearness.shape[0]):
        for k in range(first[wall], last[wall]):
            other = row[k]
            a = nearness[wall, 0] - nearness[other, 0]
            b = nearness[wall, 1] - nearness[other, 1]
            middle = min(a * rays[k, 1, 0] + b * rays[k, 1, 1], 0.0)
            for side in range(2):
                u, v = rays[k, 2 * side]
                size = abs(nearness[wall, 0] * u) + abs(nearness[wall, 1] * v)
                size += abs(nearness[other, 0] * u) + abs(nearness[other, 1] * v)
                nearer = a * u + b * v
                if nearer > SAME * size:
                    ways[k, side] = max(ways[k, side], nearer / (nearer - middle))
    return ways
