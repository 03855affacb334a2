"""Where rays meet walls: for the few rays that need no kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH

Array = NDArray[np.float64]


def hit_distances(origins: Array, ways: Array, walls: Array) -> Array:
    """Distance (K, S) in units of |way| at which each ray meets each wall; inf where it does not.

    origins, ways: (K, 2). walls: (S, 4). Walls along a ray are not met; nor is one behind it.
    """
    extent = walls[:, 2:] - walls[:, :2]
    offset = walls[None, :, :2] - origins[:, None]
    across = ways[:, None, 0] * extent[:, 1] - ways[:, None, 1] * extent[:, 0]
    parallel = np.abs(across) <= TOUCH * np.hypot(*extent.T)
    divisor = np.where(parallel, 1.0, across)
    distance = (offset[..., 0] * extent[:, 1] - offset[..., 1] * extent[:, 0]) / divisor
    share = (offset[..., 0] * ways[:, None, 1] - offset[..., 1] * ways[:, None, 0]) / divisor
    met = ~parallel & (share >= 0) & (share <= 1) & (distance >= 0)
    return np.where(met, distance, np.inf)


def is_clear(starts: Array, stops: Array, walls: Array) -> NDArray[np.bool_]:
    """Whether each line of sight (K,) is free; walls that only touch its ends do not count."""
    lengths = np.hypot(*(stops - starts).T)
    ways = (stops - starts) / np.where(lengths > 0, lengths, 1.0)[:, None]
    hits = hit_distances(starts, ways, walls)
    return np.asarray(~np.any((hits > TOUCH) & (hits < lengths[:, None] - TOUCH), axis=1))
