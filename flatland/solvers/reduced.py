"""Converged light by transforms: unknowns only where mirrors are not the truth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.kernels import Sweep
from flatland.kernels.reports import Buffer
from flatland.memory import available_memory
from flatland.solvers.edges import Edges
from flatland.solvers.gmres import flexible_gmres
from flatland.solvers.mirrored import Mirrored, Waves, spectrum_bytes
from flatland.solvers.patches import Patches, largest_count
from flatland.solvers.watching import applied
from flatland.stencil import Stencil
from flatland.symmetry import is_mirror_symmetric

Array = NDArray[np.float64]

#: Spectra take this part of the free memory at most.
_SHARE_OF_MEMORY = 0.25
#: A correction in single precision gains this much at best.
_GAIN = 1e-5
#: Residual, relative to its own start, that single precision can reach.
_PRECISION = 1e-6
#: Second largest eigenvalue of a step of even light below which a scheme diffuses.
_FORGOTTEN = 0.7
#: Iterations after which a correction is left as it is.
_ITERATIONS = 150


class Reduced:
    """(1 − A)⁻¹ = P (1 + U P)⁻¹ with P the inverse between mirrors (Woodbury).

    U, what walls and the vacuum around the grid change, is non-zero only in the cells next to
    them, so that GMRES (Saad & Schultz 1986) has to find light in those alone: vectors of a
    dimension less than the grid, and memory for hundreds of them. A coarse problem between patches
    of these cells makes iterations nearly independent of the grid's size, as coarse spaces do for
    boundary integral equations. Transforms are in single precision, and the residual of the whole
    is corrected in double precision until it is small enough.

    What it gets wrong: walls in most of the cells leave no smaller problem.
    """

    def __init__(self, sweep: Sweep) -> None:
        stencil = sweep.stencil
        self.layout = sweep.layout
        self.mirrored = Mirrored(stencil, sweep.layout.shape)
        self.edges = Edges(sweep, self.mirrored)
        self.patches = Patches(self.edges, sweep) if _needs_patches(sweep) else None
        self._cells = (len(self.edges.cells), self.mirrored.size)
        self._end = len(self.edges.cells) * self.mirrored.size
        self._inside = (slice(None), *(slice(1, 1 + n) for n in self.mirrored.shape))

    @property
    def bytes(self) -> int:
        """Memory that is kept."""
        patches = 0 if self.patches is None else self.patches.factors[0].nbytes
        return int(self.mirrored.inverse.nbytes + patches + 8 * 8 * self._end)

    def correct(self, right: Buffer, answer: Buffer, goal: float) -> int:
        """Add an approximate solution of (1 − A) x = right to `answer`.

        goal: residual, in the L2 norm, below which nothing is gained. Returns iterations, each with
        one application of the operator in the cells of the edges.
        """
        view = self.layout.view(right)
        size = float(np.abs(view).max(initial=0.0))
        if size == 0:
            return 0
        field = self.mirrored.field()
        np.multiply(view, 1 / size, out=field[self._inside], casting="same_kind")
        length = float(np.linalg.norm(field))
        free, missing = self.mirrored.solve(field)
        rest = np.concatenate([-self.edges.difference(free).ravel(), missing.ravel()])
        wanted = max(_GAIN * length, goal / size) / max(float(np.linalg.norm(rest)), 1e-300)
        tolerance = min(max(wanted, _PRECISION), 0.5)
        edges, iterations = self._at_the_edges(rest, tolerance)
        found = free + self._between_mirrors(edges)[0]
        self.layout.view(answer)[...] += size * found[self._inside]
        return iterations

    def _at_the_edges(self, rest: Array, tolerance: float) -> tuple[Array, int]:
        """An approximate solution of (1 + U P) x = rest, and iterations."""
        precondition = _copy if self.patches is None else self.patches.precondition
        if self.patches is not None and self.patches.whole:
            answer = np.empty_like(rest)
            precondition(rest, answer)
            return answer, 1
        outcome = flexible_gmres(
            self.apply, precondition, rest, tolerance, _ITERATIONS, _ITERATIONS
        )
        return outcome.answer, outcome.iterations

    def apply(self, values: Array, result: Array) -> None:
        """1 + U P in the cells (M, size), and what endless waves (W, size) lack, as one vector."""
        applied(1)
        found, missing = self._between_mirrors(values)
        result[: self._end] = self.edges.difference(found).ravel()
        result[self._end :] = -missing.ravel()
        result += values

    def _between_mirrors(self, values: Array) -> tuple[Waves, Array]:
        field = self.edges.spread(values[: self._end].reshape(self._cells))
        return self.mirrored.solve(field, values[self._end :].reshape(-1, self.mirrored.size))


def _needs_patches(sweep: Sweep) -> bool:
    """Whether patches save more iterations than they cost: in space they are too many."""
    is_open = sweep.open_share is None and sweep.reflection is None
    return len(sweep.layout.shape) == 2 and not (is_open and diffuses(sweep.stencil))


def diffuses(stencil: Stencil) -> bool:
    """Whether directions of light are soon forgotten: all waves but the evenly lit grid die."""
    sizes = np.sort(np.abs(np.linalg.eigvals(stencil.transfer.sum(axis=0))))
    return bool(len(sizes) == 1 or sizes[-2] < _FORGOTTEN)


def _copy(values: Array, result: Array) -> None:
    result[:] = values


def is_reducible(sweep: Sweep) -> bool:
    """Whether transforms fit the scheme and its spectrum the memory."""
    needed = spectrum_bytes(sweep.stencil, sweep.layout.shape)
    if _needs_patches(sweep):
        needed += 4 * largest_count(sweep) ** 2
    affordable = needed <= _SHARE_OF_MEMORY * available_memory()
    return affordable and is_mirror_symmetric(sweep.stencil)
