"""A level of groups: the operator between them, smoothed, coarsened and accelerated."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from flatland.kernels.threads import rows_of, run_shared, thread_count
from flatland.solvers import block_kernels
from flatland.solvers.aggregates import BlockMatrix, Groups, group
from flatland.solvers.smoothing import DAMPING
from flatland.solvers.vectors import dot, subtract

Vector = NDArray[np.float32]
Integers = NDArray[np.int64]

#: A level of at most this many unknowns is solved by its inverse.
_DIRECT = 800
#: Groups that are more than this part of their members are no coarser level.
_SLOW = 0.9
#: Part of the defect that one step may leave, so that there is no second.
_ENOUGH = 0.25
#: Numbers in blocks above which a pass is shared by threads.
_WORTH_SHARING = 200_000
_SWEEPS_IF_LAST = 8


class Coarse(Protocol):
    """Who knows an approximate solution of M answer = right, both (n, size)."""

    right: Vector
    answer: Vector

    @property
    def bytes(self) -> int: ...

    def solve(self) -> None: ...


def make_level(matrix: BlockMatrix, places: Integers) -> Coarse:
    """The level of a matrix, and all below it."""
    count, size = len(matrix.diagonal), matrix.blocks.shape[1]
    if count * size <= _DIRECT:
        return _Inverse(matrix)
    groups = group(places, matrix.links())
    if groups.count > _SLOW * count:
        return BlockLevel(matrix, None, None)
    below = make_level(matrix.between(groups), groups.places) if groups.count else None
    return BlockLevel(matrix, groups, below)


class _Inverse:
    """The last level."""

    def __init__(self, matrix: BlockMatrix) -> None:
        count, size = len(matrix.diagonal), matrix.blocks.shape[1]
        dense = np.zeros((count, size, count, size))
        dense[matrix.rows, :, matrix.columns, :] = matrix.blocks
        inverse = np.linalg.inv(dense.reshape(count * size, count * size))
        self.inverse = inverse.astype(np.float32)
        self.right, self.answer = (np.zeros((count, size), np.float32) for _ in range(2))

    @property
    def bytes(self) -> int:
        return int(self.inverse.nbytes + 2 * self.right.nbytes)

    def solve(self) -> None:
        self.answer[...] = (self.inverse @ self.right.ravel()).reshape(self.answer.shape)


class BlockLevel:
    """M answer = right by two steps of GCR (Eisenstat, Elman & Schultz 1983), each with a cycle.

    A cycle smooths twice, corrects by the level below, and smooths twice. Two steps of a Krylov
    method at every level (K-cycle; Notay & Vassilevski 2008) make up for what groups of constant
    light get wrong: their operator is too stiff.
    """

    def __init__(self, matrix: BlockMatrix, groups: Groups | None, below: Coarse | None) -> None:
        count, size = len(matrix.diagonal), matrix.blocks.shape[1]
        self.first = np.searchsorted(matrix.rows, np.arange(count + 1))
        self.columns = matrix.columns.astype(np.int32)
        # The other way round in memory: a column is added at a time, which vectors do.
        self.blocks = _turned(matrix.blocks)
        self.inverse = _turned(np.linalg.inv(matrix.blocks[matrix.diagonal]))
        self.labels = None if groups is None else groups.labels
        self.below = below
        fields = (np.zeros((count, size), np.float32) for _ in range(6))
        self.right, self.answer, self._defect, self._step, *self._images = fields
        self._other = np.zeros((count, size), np.float32)
        self._unit = (0,) * size
        self._parties = thread_count() if self.blocks.size > _WORTH_SHARING else 1

    @property
    def bytes(self) -> int:
        """Memory of this level and all below."""
        own = self.blocks.nbytes + self.inverse.nbytes + self.columns.nbytes + 7 * self.right.nbytes
        return int(own + (0 if self.below is None else self.below.bytes))

    def solve(self) -> None:
        """Two steps, or one if it is enough. The right-hand side is used up."""
        first, second = self._images
        before = dot(self.right.ravel(), self.right.ravel())
        self._cycle(self.answer)
        self._apply(self.answer, first)
        length = dot(first.ravel(), first.ravel())
        if not length > 0:
            return
        share = dot(first.ravel(), self.right.ravel()) / length
        left = subtract(self.right.ravel(), np.float32(share), first.ravel())
        if left <= _ENOUGH**2 * before:
            self.answer *= np.float32(share)
            return
        self._cycle(self._step)
        self._apply(self._step, second)
        overlap = dot(first.ravel(), second.ravel()) / length
        square = subtract(second.ravel(), np.float32(overlap), first.ravel())
        more = dot(second.ravel(), self.right.ravel()) / square if square > 0 else 0.0
        self.answer *= np.float32(share - more * overlap)
        self.answer += np.float32(more) * self._step

    def _cycle(self, answer: Vector) -> None:
        """An approximate solution for what is in `right`."""
        begin, end = answer, self._other
        self._share(block_kernels.first_sweep, self.inverse, self.right, np.float32(DAMPING), begin)
        self._relax(begin, end)
        if self.below is None or self.labels is None:
            for _ in range(_SWEEPS_IF_LAST):
                begin, end = end, begin
                self._relax(begin, end)
        else:
            self._apply(end, self._defect)
            np.subtract(self.right, self._defect, out=self._defect)
            block_kernels.gather(self._unit, self._defect, self.labels, self.below.right)
            self.below.solve()
            self._share(block_kernels.spread, self.below.answer, self.labels, end)
            self._relax(end, begin)
            self._relax(begin, end)
        if end is not answer:
            answer[...] = end

    def _relax(self, old: Vector, new: Vector) -> None:
        parts = self.first, self.columns, self.blocks, self.inverse
        self._share(block_kernels.relax, *parts, old, self.right, np.float32(DAMPING), new)

    def _apply(self, values: Vector, image: Vector) -> None:
        self._share(block_kernels.multiply, self.first, self.columns, self.blocks, values, image)

    def _share(self, kernel: Callable[..., None], *arguments: object) -> None:
        """Call a kernel for all rows."""
        count = len(self.answer)
        if self._parties == 1:
            kernel(self._unit, *arguments, 0, count)
            return

        def part(party: int, parties: int) -> None:
            kernel(self._unit, *arguments, *rows_of(party, parties, count))

        run_shared(part, self._parties)


def _turned(blocks: NDArray[np.floating]) -> Vector:
    return np.ascontiguousarray(np.swapaxes(blocks, 1, 2), np.float32)
