"""The plane that is looked at: the whole of a 2D grid, one layer of a 3D one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flatland.field import Field
from flatland.grid import Grid

_Number = TypeVar("_Number", bound=np.number)

#: Axes that point right and up when a 3D grid is looked at along an axis.
_ACROSS = {0: (1, 2), 1: (0, 2), 2: (0, 1)}


@dataclass(frozen=True)
class Plane:
    """axes: indices of the axes that point right and up. normal: the axis looked along, or None.

    layer: index of the cells along it.
    """

    axes: tuple[int, int] = (0, 1)
    normal: int | None = None
    layer: int = 0

    @classmethod
    def of(cls, grid: Grid, normal: int = 2, layer: int | None = None) -> Plane:
        """The plane of a 2D grid; of a 3D one the layer across an axis, by default the middle."""
        if grid.dimension == 2:
            return cls()
        count = grid.shape[normal]
        index = count // 2 if layer is None else min(max(layer, 0), count - 1)
        return cls(_ACROSS[normal], normal, index)

    def shape(self, grid: Grid) -> tuple[int, int]:
        return grid.shape[self.axes[0]], grid.shape[self.axes[1]]

    def cut(self, values: NDArray[_Number], dimension: int) -> NDArray[_Number]:
        """Arrays (..., nx, ny[, nz]) as (..., right, up)."""
        if self.normal is None:
            return values
        return np.take(values, self.layer, axis=values.ndim - dimension + self.normal)

    def cell(self, right: int, up: int, dimension: int) -> tuple[int, ...]:
        """The cell of the grid at a place in the plane."""
        return tuple(int(i) for i in self.lift((right, up), self.layer, dimension))

    def lift(self, point: Sequence[float], depth: float, dimension: int) -> tuple[float, ...]:
        """A point in the plane with its place along the normal."""
        if self.normal is None:
            return float(point[0]), float(point[1])
        result = [0.0] * dimension
        result[self.axes[0]], result[self.axes[1]] = float(point[0]), float(point[1])
        result[self.normal] = float(depth)
        return tuple(result)

    def depth(self, grid: Grid) -> float:
        """Place of the layer's middle along the normal [m]."""
        if self.normal is None:
            return 0.0
        return grid.origin[self.normal] + (self.layer + 0.5) * grid.spacing

    def point(self, point: Sequence[float], grid: Grid) -> tuple[float, ...]:
        """A point of the plane [m] as a point of the world [m]."""
        return self.lift(point, self.depth(grid), grid.dimension)

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """World points or vectors (..., dimension) as (..., 2)."""
        return np.asarray(points, float)[..., list(self.axes)]

    def directions(self, angles: NDArray[np.float64], dimension: int) -> NDArray[np.float64]:
        """Unit vectors (K, dimension) in the plane at angles (K,) from right towards up."""
        result = np.zeros((angles.size, dimension))
        result[:, self.axes[0]], result[:, self.axes[1]] = np.cos(angles), np.sin(angles)
        return result


def grey(field: Field, channel: int | None = None) -> NDArray[np.floating]:
    """Coefficients (size, *shape) of one colour channel, or of all of them added up."""
    if not field.coloured:
        return field.values
    if channel is not None and channel < len(field.values):
        return np.asarray(field.values[channel])
    return np.asarray(field.values.sum(axis=0))
