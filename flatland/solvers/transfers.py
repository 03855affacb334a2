"""Between a grid and the next coarser one, for multigrid.

Coarse cell J sits at fine cell 2J + 1; zeros lie where cell -1 and the last one plus 1 would be,
on every level, so that the vacuum outside stays where it is (aligning blocks of cells instead
moves it outwards on each level, and the cycle diverges).
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels import Layout

Buffer = NDArray[np.floating]
_FAST = {"reassoc", "contract", "nsz"}


def coarse_shape(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Cells of the next coarser grid."""
    return tuple((cells - 1) // 2 for cells in shape)


class Transfer:
    """Full weighting down (1/4, 1/2, 1/4 along each axis), linear interpolation up."""

    def __init__(self, fine: Layout, coarse: Layout) -> None:
        self.fine, self.coarse = fine, coarse
        dtype = fine.dtype.type
        leading = list(np.ndindex(coarse.shape[:-1]))
        steps = list(itertools.product((0, 1, 2), repeat=len(fine.shape) - 1))
        self.gather_rows = np.array(
            [[_row(fine, 2 * np.array(c, int) + s) for s in steps] for c in leading]
        )
        self.gather_weights = np.array([dtype(_product((0.25, 0.5, 0.25), s)) for s in steps])
        self.coarse_rows = np.array([_row(coarse, np.array(c)) for c in leading])
        self.fine_rows, self.spread_rows, self.spread_weights = self._spreading()

    def _spreading(self) -> tuple[NDArray[np.int64], NDArray[np.int64], Buffer]:
        """Per fine row: where it is, its 2^(D-1) coarse rows and their weights."""
        leading = list(np.ndindex(self.fine.shape[:-1]))
        sides = list(itertools.product((0, 1), repeat=len(self.fine.shape) - 1))
        rows, weights = [], []
        for cell in map(np.array, leading):
            lower = (cell - 2) // 2 + (cell % 2)  # an odd cell has its coarse one right on it
            below = np.where(cell % 2 == 1, 1.0, 0.5)
            above = np.where(cell % 2 == 1, 0.0, 0.5)
            rows.append([_row(self.coarse, lower + s) for s in sides])
            weights.append([np.prod(np.where(np.array(s) == 0, below, above)) for s in sides])
        starts = np.array([_row(self.fine, np.array(cell)) for cell in leading])
        return starts, np.array(rows), np.array(weights, self.fine.dtype)

    def down(self, fine: Buffer, coarse: Buffer, mixing: Buffer) -> None:
        """coarse = mixing · R fine, mixing (size, size) applied in every cell."""
        _restrict(
            fine, coarse, self.gather_rows, self.gather_weights, self.coarse_rows,
            self.coarse.width, self.fine.component_stride, self.coarse.component_stride, mixing,
        )  # fmt: skip

    def up(self, coarse: Buffer, fine: Buffer) -> None:
        """fine += P coarse."""
        _prolong(
            coarse, fine, self.spread_rows, self.spread_weights, self.fine_rows, self.fine.width,
            self.fine.component_stride, self.coarse.component_stride, self.fine.components,
        )  # fmt: skip


def _row(layout: Layout, leading: NDArray[Any]) -> int:
    """Position of the first cell of a row."""
    return layout.front + layout.shift((*leading, 0))


def _product(weights: tuple[float, ...], indices: tuple[int, ...]) -> float:
    return float(np.prod([weights[i] for i in indices]))


@njit(cache=True, fastmath=_FAST)
def _restrict(fine, coarse, gather, weights, rows, width, fine_stride, coarse_stride, mixing):  # type: ignore[no-untyped-def]
    quarter, half = weights.dtype.type(0.25), weights.dtype.type(0.5)
    size = mixing.shape[0]
    line = np.empty(2 * width + 1, fine.dtype)
    values = np.empty((size, width), fine.dtype)
    for r in range(rows.size):
        for k in range(size):
            line[:] = 0
            for q in range(weights.size):
                start = gather[r, q] + k * fine_stride
                row = fine[start : start + line.size]
                for j in range(line.size):
                    line[j] += weights[q] * row[j]
            value = values[k]
            even, odd, next_even = line[0:-1:2], line[1::2], line[2::2]
            for j in range(width):
                value[j] = quarter * (even[j] + next_even[j]) + half * odd[j]
        for k in range(size):
            start = rows[r] + k * coarse_stride
            out = coarse[start : start + width]
            out[:] = 0
            for m in range(size):
                factor = mixing[k, m]
                value = values[m]
                for j in range(width):
                    out[j] += factor * value[j]


@njit(cache=True, fastmath=_FAST)
def _prolong(coarse, fine, spread, weights, rows, width, fine_stride, coarse_stride, size):  # type: ignore[no-untyped-def]
    half = weights.dtype.type(0.5)
    count = width // 2 + 1
    line = np.empty(count + 1, fine.dtype)
    for k in range(size):
        for r in range(rows.size):
            line[:] = 0
            for q in range(weights.shape[1]):
                weight = weights[r, q]
                if weight != 0:
                    start = spread[r, q] + k * coarse_stride - 1  # one zero before the row
                    row = coarse[start : start + count + 1]
                    for j in range(count + 1):
                        line[j] += weight * row[j]
            start = rows[r] + k * fine_stride
            out = fine[start : start + width]
            even, odd = out[0::2], out[1::2]
            for j in range(even.size):
                even[j] += half * (line[j] + line[j + 1])
            for j in range(odd.size):
                odd[j] += line[j + 1]
