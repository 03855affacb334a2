"""Multigrid: one cycle as the preconditioner of a Krylov method."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from flatland.kernels import Layout, Sweep
from flatland.solvers.smoothing import SweptLevel
from flatland.solvers.transfers import Transfer, coarse_shape
from flatland.solvers.vectors import scale, squares
from flatland.stencil import Stencil

Buffer = NDArray[np.floating]
Array = NDArray[np.float64]
Offset = tuple[int, ...]

#: A grid of at most this many unknowns is solved by its inverse.
_DIRECT = 250


def galerkin(blocks: dict[Offset, Array]) -> dict[Offset, Array]:
    """R L P of an operator (L x)(i) = Σ_o L_o x(i − o) on the next coarser grid, in the same form.

    Full weighting and linear interpolation meet in offsets of -1, 0, 1 again, and the zeros
    outside the grid coincide on all levels, so that this is exact up to the border.
    """
    dimension = len(next(iter(blocks)))
    hat = {-1: 0.5, 0: 1.0, 1: 0.5}
    result: dict[Offset, Array] = {}
    for down in itertools.product(hat, repeat=dimension):
        weight = np.prod([hat[s] / 2 for s in down])
        for offset, block in blocks.items():
            place = np.array(down) - offset
            for goal in itertools.product((-1, 0, 1), repeat=dimension):
                steps = place - 2 * np.array(goal)
                if np.abs(steps).max() <= 1:
                    share = weight * np.prod([hat[int(s)] for s in steps])
                    key = tuple(-g for g in goal)
                    result[key] = result.get(key, 0.0) + share * block
    return result


def _level(stencil: Stencil, shape: tuple[int, ...], blocks: dict[Offset, Array]) -> SweptLevel:
    """One grid, its operator scaled to 1 − A with A free of the cell itself."""
    zero = (0,) * len(shape)
    inverse = np.linalg.inv(blocks[zero])
    offsets = [offset for offset in blocks if offset != zero]
    transfer = np.array([-inverse @ blocks[offset] for offset in offsets])
    layout = Layout(shape, stencil.basis.size, np.dtype(np.float32))
    return SweptLevel(Sweep(Stencil(stencil.basis, np.array(offsets), transfer), layout))


class Multigrid:
    """V-cycles for 1 − A, the same stencil in every cell.

    Vertex-centred coarsening, Galerkin coarse operators, two damped Jacobi sweeps before and after
    each coarse correction, all in single precision: a preconditioner needs no more. Blocked cells
    are not seen by it.
    """

    def __init__(self, stencil: Stencil, shape: tuple[int, ...]) -> None:
        zero = (0,) * len(shape)
        blocks: dict[Offset, Array] = {zero: np.eye(stencil.basis.size)}
        for offset, transfer in zip(stencil.offsets, stencil.transfer):
            blocks[tuple(int(o) for o in offset)] = -transfer
        self.levels = [_level(stencil, shape, blocks)]
        diagonals = [blocks[zero]]
        while self._unknowns() > _DIRECT and min(coarse_shape(shape)) >= 1:
            blocks, shape = galerkin(blocks), coarse_shape(shape)
            self.levels.append(_level(stencil, shape, blocks))
            diagonals.append(blocks[zero])
        self.transfers = [
            Transfer(fine.layout, coarse.layout)
            for fine, coarse in zip(self.levels, self.levels[1:])
        ]
        # A coarse level is scaled by its own diagonal; its right-hand side has to follow.
        self.mixing = [
            np.linalg.solve(coarse, fine).astype(np.float32)
            for fine, coarse in itertools.pairwise(diagonals)
        ]
        self.inverse = self._coarsest_inverse() if self._unknowns() <= _DIRECT else None
        #: Applications of the finest operator.
        self.applications = 0

    @property
    def bytes(self) -> int:
        """Memory that is kept."""
        return sum(level.bytes for level in self.levels)

    def _unknowns(self) -> int:
        layout = self.levels[-1].layout
        return layout.components * layout.rows * layout.width

    def _coarsest_inverse(self) -> NDArray[np.float32]:
        level = self.levels[-1]
        view = level.layout.view(level.right)
        columns = np.empty((view.size, view.size), np.float32)
        for i, cell in enumerate(np.ndindex(view.shape)):
            view[cell] = 1
            level.sweep.combine(1.0, 0.0, -1.0, level.right, level.right, level.scratch)
            columns[:, i] = level.layout.view(level.scratch).ravel()
            view[cell] = 0
        return np.asarray(np.linalg.inv(columns.astype(float)).astype(np.float32))

    def precondition(self, right: NDArray[np.float64], answer: NDArray[np.float64]) -> None:
        """Write an approximate solution of (1 − A) x = right into `answer`."""
        finest = self.levels[0]
        # Kept near 1: a residual of 1e-40 would be lost in single precision.
        total = squares(right)
        size = math.sqrt(total / right.size) if total > 0 else 1.0
        scale(right, 1 / size, finest.right)
        self._cycle(0)
        self.applications += 4
        scale(finest.answer, size, answer)

    def _cycle(self, depth: int) -> None:
        level = self.levels[depth]
        if depth == len(self.levels) - 1:
            self._solve_coarsest(level)
            return
        below = self.levels[depth + 1]
        level.first_smooth()
        self.transfers[depth].down(level.residual(), below.right, self.mixing[depth])
        self._cycle(depth + 1)
        self.transfers[depth].up(below.answer, level.answer)
        level.smooth(2)

    def _solve_coarsest(self, level: SweptLevel) -> None:
        if self.inverse is None:
            level.first_smooth()
            level.smooth(2)
            return
        layout = level.layout
        answer = self.inverse @ layout.view(level.right).ravel()
        layout.view(level.answer)[...] = answer.reshape(layout.view(level.answer).shape)
