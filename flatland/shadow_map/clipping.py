"""What of the walls lies in the grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Cells beyond the grid's border that still belong to it: a wall put onto the border by decimal
#: fractions may lie beyond it by rounding.
SLACK = 1e-9


def clip_to_grid(ends: Array, shape: tuple[int, ...]) -> tuple[Array, NDArray[np.int64]]:
    """The parts (K, 2, 2) of walls (S, 2, 2) [cells] inside the grid, and which wall each is of.

    Liang & Barsky 1984: the parameters at which a wall's line enters and leaves. Walls without
    length are dropped.
    """
    start, extent = ends[:, 0], ends[:, 1] - ends[:, 0]
    with np.errstate(all="ignore"):  # an extent of 0 along an axis gives ±inf, or NaN for 0/0
        one = (-SLACK - start) / extent
        other = (np.array(shape) + SLACK - start) / extent
    enter = np.maximum(np.fmin(one, other).max(axis=1, initial=0.0), 0.0)
    leave = np.minimum(np.fmax(one, other).min(axis=1, initial=1.0), 1.0)
    kept = (enter < leave) & np.any(extent != 0, axis=1)
    enter, leave = enter[kept, None], leave[kept, None]
    start, stop, extent = start[kept], ends[kept, 1], extent[kept]
    # Ends that stay are kept to the last bit: walls that share a vertex go on sharing it.
    first = np.where(enter > 0, start + enter * extent, start)
    last = np.where(leave < 1, start + leave * extent, stop)
    return np.stack([first, last], axis=1), np.flatnonzero(kept)
