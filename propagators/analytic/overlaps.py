"""Where segments lie on one another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH

Array = NDArray[np.float64]


def uncovered(segment: Array, others: Array) -> Array:
    """The parts (K, 4) of a segment (4,) that no other (M, 4) lies on."""
    start, extent = segment[:2], segment[2:] - segment[:2]
    length = np.hypot(*extent)
    ends = others.reshape(-1, 2, 2) - start
    distance = np.abs(ends @ [-extent[1], extent[0]]) / length
    places = np.sort(ends @ extent / length**2, axis=1)[np.all(distance <= TOUCH, axis=1)]
    parts, reached = [], 0.0
    for first, last in [*sorted(places.tolist()), [1.0, 1.0]]:
        if min(first, 1.0) - reached > TOUCH / length:
            parts.append([reached, min(first, 1.0)])
        reached = max(reached, last)
    cuts = np.array(parts).reshape(-1, 2, 1)
    return (start + cuts * extent).reshape(-1, 4)
