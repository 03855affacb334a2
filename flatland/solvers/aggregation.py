"""Multigrid over groups of cells that end at walls: a cycle as a preconditioner."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.kernels import Sweep
from flatland.kernels.reports import Buffer
from flatland.kernels.threads import rows_of, run_shared, thread_count
from flatland.solvers.aggregates import cell_pairs, group
from flatland.solvers.block_level import make_level
from flatland.solvers.smoothing import SweptLevel
from flatland.solvers.vectors import scale, squares

#: Cells from which on light is carried between grid and groups by several threads.
_WORTH_SHARING = 100_000


def needed_bytes(sweep: Sweep) -> int:
    """Memory for groups while they are set up, at most: blocks in double and single precision."""
    dimension, size = len(sweep.layout.shape), sweep.stencil.basis.size
    neighbours = min(3**dimension, 1 + len(sweep.stencil.offsets))
    blocks = math.prod(sweep.layout.shape) * neighbours / 2**dimension
    return int(20 * blocks * size**2 / (1 - 0.5**dimension))


class Aggregation:
    """Cycles for 1 − A with walls: aggregation-based multigrid (Notay 2010) on blocks of 2^D cells.

    Groups of cells that light gets between take the place of coarse cells, with light constant in
    each, all coefficients kept, and Galerkin operators between groups. Closed pockets are left to
    smoothing. All in single precision: a preconditioner needs no more. A cycle is no linear map,
    so that the method around it has to be flexible.

    What it costs: blocks between neighbouring groups, in 2D about 3 size² numbers a cell.

    What it gets wrong: light in one value a group. Schemes with rays that nothing spreads (DOM4
    with 5 bands) are smoothed too slowly, and BiCGSTAB alone is faster.
    """

    def __init__(self, sweep: Sweep) -> None:
        layout = replace(sweep.layout, dtype=np.dtype(np.float32))
        single = Sweep(sweep.stencil, layout, sweep.open_share).reflecting(sweep.reflection)
        self.finest = SweptLevel(single)
        self.layout = layout
        places = np.indices(layout.shape).reshape(len(layout.shape), -1).T
        pairs = cell_pairs(sweep)
        groups = group(places, pairs.links(sweep))
        self.labels = groups.labels
        self.below = (
            make_level(pairs.between(groups, sweep), groups.places) if groups.count else None
        )
        rows = np.indices((*layout.shape[:-1], 1)).reshape(len(layout.shape), -1).T
        self._starts = layout.index(rows)
        #: Applications of the finest operator.
        self.applications = 0

    @property
    def bytes(self) -> int:
        """Memory that is kept."""
        below = 0 if self.below is None else self.below.bytes
        return int(self.finest.bytes + self.labels.nbytes + below)

    def precondition(self, right: NDArray[np.float64], answer: NDArray[np.float64]) -> None:
        """Write an approximate solution of (1 − A) x = right into `answer`."""
        finest = self.finest
        # Kept near 1: a residual of 1e-40 would be lost in single precision.
        total = squares(right)
        size = math.sqrt(total / right.size) if total > 0 else 1.0
        scale(right, 1 / size, finest.right)
        finest.first_smooth()
        if self.below is not None:
            self._down(finest.residual(), self.below.right)
            self.below.solve()
            self._up(self.below.answer, finest.answer)
        finest.smooth(2)
        self.applications += 4
        scale(finest.answer, size, answer)

    def _down(self, fine: Buffer, coarse: NDArray[np.float32]) -> None:
        coarse[...] = 0
        layout = self.layout
        # Groups lie within two layers, so that threads with whole pairs of them never meet.
        pair = 2 * layout.rows // layout.shape[0]
        self._shared(_gather, pair, fine, coarse)

    def _up(self, coarse: NDArray[np.float32], fine: Buffer) -> None:
        self._shared(_spread, 1, coarse, fine)

    def _shared(self, kernel: Callable[..., None], unit: int, *arguments: object) -> None:
        """Call a kernel for all rows, in threads each with whole units of them."""
        layout = self.layout
        units = -(-layout.rows // unit)
        places = self._starts, layout.component_stride, layout.width, self.labels

        def part(party: int, parties: int) -> None:
            begin, end = rows_of(party, parties, units)
            kernel(*arguments, *places, begin * unit, min(end * unit, layout.rows))

        parties = thread_count() if self.labels.size > _WORTH_SHARING else 1
        run_shared(part, min(parties, units))


@njit(cache=True, nogil=True)
def _gather(fine, coarse, starts, stride, width, labels, begin, end):  # type: ignore[no-untyped-def]
    for r in range(begin, end):
        for j in range(width):
            label = labels[r * width + j]
            if label >= 0:
                for k in range(coarse.shape[1]):
                    coarse[label, k] += fine[starts[r] + k * stride + j]


@njit(cache=True, nogil=True)
def _spread(coarse, fine, starts, stride, width, labels, begin, end):  # type: ignore[no-untyped-def]
    for r in range(begin, end):
        for j in range(width):
            label = labels[r * width + j]
            if label >= 0:
                for k in range(coarse.shape[1]):
                    fine[starts[r] + k * stride + j] += coarse[label, k]
