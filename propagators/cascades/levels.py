"""The hierarchy of a cascade: where its probes are, where they look and how far."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: How far, in grids, a ray without an end goes.
_OPEN = 4.0


class Level(NamedTuple):
    """One level: probes at ((a - 1/2) D, (b - 1/2) D), a < count_x, b < count_y, in cells.

    spacing: D. directions: (R, 2), in which light travels that a ray along -ω looks for, in the
    middle of R equal bins. start, stop: the interval of distances that a ray of this level sees.
    Level 0 has no probes of its own; its points are where light is gathered, and its bins are those
    of level 1.
    """

    spacing: float
    count_x: int
    count_y: int
    directions: Array
    start: float
    stop: float


@dataclass(frozen=True)
class Plan:
    """Parameters of a cascade, see `RadianceCascades`; lengths in cells."""

    bins: int
    branching: int
    spacing: float
    interval: float

    def levels(self, shape: tuple[int, int]) -> list[Level]:
        """Levels until the last one sees to the end of the grid; it has no end."""
        far = float(np.hypot(*shape))
        found: list[Level] = []
        start = 0.0
        while not found or start < far:
            level = len(found)
            stop = start + self.interval * self.branching**level
            stop = stop if stop < far else start + _OPEN * far
            spacing = self.spacing * 2.0 ** (level - 1)
            probes = [int(np.ceil(n / spacing)) + 2 if level else 0 for n in shape]
            directions = _directions(self.bins * self.branching ** max(level - 1, 0))
            found.append(Level(spacing, probes[0], probes[1], directions, start, stop))
            start = stop
        return found


def _directions(count: int) -> Array:
    angles = (np.arange(count) + 0.5) * (2 * np.pi / count)
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)
