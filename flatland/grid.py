"""The grid: where cells are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input


@dataclass(frozen=True)
class Grid:
    """A regular grid of squares (2D) or cubes (3D).

    ::

        y ^   +------+------+        cell (0, 0) sits at the lower corner `origin`;
          |   | 0,1  | 1,1  |        arrays are indexed [..., x, y(, z)]
          |   +------+------+
          |   | 0,0  | 1,0  |
          |   +------+------+
        origin -> x

    shape: number of cells along x, y[, z]. spacing: side of a cell [m].
    origin: world position of the grid's lower corner [m], zero by default.
    Raises InputError for other than 2 or 3 axes, empty axes and non-positive or non-finite sizes.
    """

    shape: tuple[int, ...]
    spacing: float = 1.0
    origin: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        whole = all(isinstance(n, Integral) and not isinstance(n, bool) for n in self.shape)
        if not whole or len(self.shape) not in (2, 3) or min(self.shape) < 1:
            rule = "must be 2 or 3 whole numbers of cells, each at least 1"
            raise bad_input("shape", self.shape, rule)
        shape = tuple(int(n) for n in self.shape)
        if not (math.isfinite(self.spacing) and self.spacing > 0):
            raise bad_input("spacing", self.spacing, "must be finite and greater than 0")
        origin = tuple(float(x) for x in self.origin) or (0.0,) * len(shape)
        if len(origin) != len(shape) or not all(map(math.isfinite, origin)):
            raise bad_input("origin", self.origin, f"must be {len(shape)} finite numbers")
        object.__setattr__(self, "shape", shape)
        object.__setattr__(self, "spacing", float(self.spacing))
        object.__setattr__(self, "origin", origin)

    @property
    def dimension(self) -> int:
        return len(self.shape)

    @property
    def cell_count(self) -> int:
        return math.prod(self.shape)

    @property
    def extent(self) -> tuple[float, ...]:
        """Length of the grid along each axis [m]."""
        return tuple(n * self.spacing for n in self.shape)

    @property
    def upper(self) -> tuple[float, ...]:
        """World position of the upper corner [m]."""
        return tuple(o + e for o, e in zip(self.origin, self.extent))

    def to_cells(self, points: ArrayLike) -> NDArray[np.float64]:
        """World points (..., dimension) [m] in cell units, where cell i spans [i, i + 1]."""
        return (np.asarray(points, float) - self.origin) / self.spacing

    def to_world(self, points: ArrayLike) -> NDArray[np.float64]:
        """Points (..., dimension) in cell units as world positions [m]."""
        return np.asarray(points, float) * self.spacing + self.origin

    def cell_center(self, cell: Sequence[int]) -> NDArray[np.float64]:
        """World position (dimension,) of a cell's centre [m]."""
        return self.to_world(np.asarray(cell) + 0.5)

    def contains(self, points: ArrayLike, tolerance: float = 1e-9) -> NDArray[np.bool_]:
        """Which world points (..., dimension) lie in the grid, border included.

        tolerance: slack in cells, so that rounding in a scene file puts no light outside.
        """
        cells = self.to_cells(points)
        return np.all((cells >= -tolerance) & (cells <= np.array(self.shape) + tolerance), axis=-1)

    def coarsen(self) -> Grid:
        """The grid with cells twice as large; odd axes keep their last, half-covered cell."""
        shape = tuple(-(-n // 2) for n in self.shape)
        return Grid(shape, 2 * self.spacing, self.origin)


def cells_on(
    grid: Grid, cells: NDArray[np.int64], other: Grid
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Cells of another grid in which the centres of cells (dimension, K) lie, and which do, (K,).

    Cells (dimension, K); those outside of the other grid are counted beyond its ends.
    """
    places = np.floor(other.to_cells(grid.to_world(cells.T + 0.5))).astype(np.int64)
    inside = np.all((places >= 0) & (places < np.array(other.shape)), axis=1)
    return places.T, inside
