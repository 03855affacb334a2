"""The pieces of an arrangement cut in elements, on each side of which radiance is constant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.blockers import TOUCH
from propagators.transport.arrangement import Arrangement

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class SurfaceElements:
    """Elements of equal length along each piece; black pieces and lights are one element.

    first: (S + 1,), those of piece s are first[s] … first[s + 1] - 1, from its start.
    """

    arrangement: Arrangement
    first: Counts

    @property
    def count(self) -> int:
        return int(self.first[-1])

    @property
    def owners(self) -> Counts:
        """Piece (E,) of each element."""
        return np.repeat(np.arange(len(self.first) - 1), np.diff(self.first))

    @property
    def lengths(self) -> Array:
        return (self.arrangement.lengths / np.diff(self.first))[self.owners]

    @property
    def albedo(self) -> Array:
        """(E, C)."""
        return self.arrangement.albedo[self.owners]

    @property
    def radiance(self) -> Array:
        """What lights send from each side, (E, 2, C)."""
        return self.arrangement.radiance[self.owners]

    @property
    def segments(self) -> Array:
        """Start and stop (E, 4)."""
        owners, counts = self.owners, np.diff(self.first)
        pieces = self.arrangement.segments[owners]
        place = (np.arange(self.count) - self.first[owners])[:, None]
        extent = pieces[:, 2:] - pieces[:, :2]
        shares = np.concatenate([place, place + 1], axis=1) / counts[owners][:, None]
        return np.hstack([pieces[:, :2] + shares[:, k : k + 1] * extent for k in (0, 1)])


def cut_elements(arrangement: Arrangement, size: float) -> SurfaceElements:
    """Elements of at most `size` cells where a piece reflects."""
    reflects = np.any(arrangement.albedo > 0, axis=1)
    wanted = np.ceil(arrangement.lengths / size - TOUCH).astype(np.int64)
    counts = np.where(reflects, np.maximum(wanted, 1), 1)
    return SurfaceElements(arrangement, np.concatenate([[0], np.cumsum(counts)]))
