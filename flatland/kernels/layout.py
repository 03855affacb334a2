"""Where a coefficient lies in memory."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Bytes of one vector; rows start on such a boundary.
VECTOR_BYTES = 64
#: Rows are a multiple of this many numbers apart, in float32 as in float64, so that a buffer of
#: one precision is copied into the other number by number.
_GRAIN = 16


@dataclass(frozen=True)
class Layout:
    """Fields with a border of zeros, so that a sweep needs no test at the grid's edge.

    Rows run along the last axis, and all components of a row lie side by side, so that a sweep
    walks through memory in one stream a field, however many components there are. Every row of a
    component is followed by at least one zero (which is also what lies left of the next one),
    every plane by a row of zeros and all by a plane of them; in front lies as much again. The
    border stays zero: light that would be written there has left the grid.

    shape: cells per axis. components: number of coefficients. dtype: float32 or float64. mirrors:
    per axis, whether the cells are one half of a field that is its own mirror image; behind the
    last one there then is a layer for the image of cells, in front of the border. 0: no. 1: the
    image of the last layer follows it. 2: the last layer lies on the mirror, and is no image.
    """

    shape: tuple[int, ...]
    components: int
    dtype: np.dtype
    mirrors: tuple[int, ...] = ()

    @cached_property
    def ghosts(self) -> tuple[int, ...]:
        """Layers of images behind the last cell of each axis, 0 or 1."""
        return tuple(int(mirror > 0) for mirror in self.mirrors or (0,) * len(self.shape))

    @property
    def lanes(self) -> int:
        """Numbers in one vector."""
        return VECTOR_BYTES // self.dtype.itemsize

    @property
    def width(self) -> int:
        """Cells in a row."""
        return self.shape[-1]

    @property
    def rows(self) -> int:
        return math.prod(self.shape[:-1])

    @cached_property
    def strides(self) -> tuple[int, ...]:
        """Distance, in numbers, of neighbours along each axis."""
        strides = [1, self.components * self.component_stride]
        for cells, ghosts in zip(reversed(self.shape[1:-1]), reversed(self.ghosts[1:-1])):
            strides.append(strides[-1] * (cells + ghosts + 1))
        return tuple(reversed(strides))

    @cached_property
    def component_stride(self) -> int:
        """Distance, in numbers, of a cell's components."""
        return -(-(self.width + self.ghosts[-1] + 1) // _GRAIN) * _GRAIN

    @cached_property
    def front(self) -> int:
        """Numbers before the first cell: one step back along every axis stays inside."""
        return sum(self.strides[:-1]) + _GRAIN

    @cached_property
    def size(self) -> int:
        """Numbers in one field, border included."""
        return 2 * self.front + self._within

    @cached_property
    def _within(self) -> int:
        """Numbers from the first cell on, the border behind the last one included."""
        return self.strides[0] * (self.shape[0] + self.ghosts[0] + 1)

    def shift(self, offset: NDArray[np.int64] | tuple[int, ...]) -> int:
        """Distance in memory from a cell to its neighbour at `offset`."""
        return int(np.dot(np.asarray(offset), self.strides))

    def index(self, cells: NDArray[np.int64]) -> NDArray[np.int64]:
        """Position in a buffer of the first component of cells (M, dimension)."""
        return self.front + cells @ np.asarray(self.strides)

    def allocate(self) -> NDArray[Any]:
        """A buffer (size,) of zeros, aligned to the vector size."""
        raw = np.zeros(self.size + self.lanes, self.dtype)
        start = (-(raw.ctypes.data // self.dtype.itemsize)) % self.lanes
        return raw[start : start + self.size]

    def view(self, buffer: NDArray[np.floating], images: bool = False) -> NDArray[np.floating]:
        """The cells of a buffer, (components, nx, ny[, nz]), without the border; not a copy.

        images: with the layers of images behind them.
        """
        shape, axes, *cells = self._viewed
        within = buffer[self.front : self.front + self._within]
        return within.reshape(shape).transpose(axes)[cells[images]]

    @cached_property
    def _viewed(self) -> tuple[Any, ...]:
        """Shape of a field with its border; order of axes, components first; cells; and images."""
        leading = [n + ghosts + 1 for n, ghosts in zip(self.shape[:-1], self.ghosts)]
        axes = (len(leading), *range(len(leading)), len(leading) + 1)
        cells = (slice(None), *map(slice, self.shape))
        images = (slice(None), *map(slice, np.add(self.shape, self.ghosts)))
        return (*leading, self.components, self.component_stride), axes, cells, images

    def copies(self, cells: NDArray[np.int64]) -> NDArray[np.float64]:
        """How often cells (M, dimension) are in the whole field, over how often most are, (M,)."""
        result = np.ones(len(cells))
        for axis, mirror in enumerate(self.mirrors):
            if mirror == 2:
                result[cells[:, axis] == self.shape[axis] - 1] /= 2
        return result
