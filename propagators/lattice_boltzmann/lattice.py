"""Populations on the grid: one step, and the light of all steps together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.errors import ConvergenceError
from flatland.solvers.bicgstab import bicgstab
from propagators.analytic.compiling import shared
from propagators.lattice_boltzmann.rules import VELOCITIES

Array = NDArray[np.float64]

#: Relative residual asked for, and the one beyond which an answer is refused.
RESIDUAL, WORST_RESIDUAL = 1e-13, 1e-8
#: Steps for each cell along both sides after which a solver takes over: in a vacuum one is enough.
_PATIENCE = 1
MOST_ITERATIONS = 20_000
#: A round of steps and solver goes on with what the last one left, if it left less than this.
_GAIN, _MOST_ROUNDS = 0.5, 20


@dataclass(frozen=True, eq=False)
class Lattice:
    """What happens to populations (9, nx, ny) [W] between leaving a cell and leaving the next.

    matrix: Θ (9, 9). open_share: (9, nx, ny) of each link, or None. cells, lobes: of cells (M, 2)
    at walls, what comes back into each population per flux sent along each link, (M, 8, 9).
    """

    matrix: Array
    open_share: Array | None
    cells: NDArray[np.int64]
    lobes: Array

    def arrived(self, sent: Array) -> Array:
        """Populations that arrive in cells; light at rest stays where it is."""
        passing = sent if self.open_share is None else sent * self.open_share
        result = np.empty_like(sent)
        stream(passing, VELOCITIES, result)
        return result

    def step(self, sent: Array) -> Array:
        """What leaves cells next: collisions of what arrived, and what walls send back."""
        collided = self.arrived(sent)
        collide(self.matrix, collided)
        if len(self.cells):
            at = (slice(None), *self.cells.T)
            collided[at] += np.einsum("mdj,dm->jm", self.lobes, sent[1:][at])
        return collided

    def settled(self, start: Array) -> Array:
        """All light that ever leaves cells, G = start + step(G).

        Step by step while light is on its way out, which is all there is to do in a vacuum; what
        then still diffuses goes to BiCGSTAB. It may break down, and the steps after it then begin
        it anew. Raises ConvergenceError where light never ends.
        """
        total, rest = start.copy(), self.step(start)
        goal, before = RESIDUAL * float(np.linalg.norm(start)), np.inf
        for _ in range(_MOST_ROUNDS):
            for _ in range(_PATIENCE * sum(start.shape[1:])):
                total += rest
                if float(np.linalg.norm(rest)) <= goal:
                    return total
                rest = self.step(rest)
            total += self._solved(rest, goal)
            rest = start + self.step(total) - total
            residual = float(np.linalg.norm(rest))
            if not goal < residual < _GAIN * before:
                break
            before = residual
        if not residual <= WORST_RESIDUAL / RESIDUAL * goal:
            share = residual / float(np.linalg.norm(start))
            message = (
                f"light on the lattice did not settle (residual {share:.1e}): it has no way out"
            )
            raise ConvergenceError(message)
        return total

    def _solved(self, right: Array, goal: float) -> Array:
        """(1 - step)⁻¹ of a right-hand side, to a residual norm."""

        def apply(values: Array, result: Array) -> None:
            result[:] = values - self.step(values.reshape(right.shape)).ravel()

        def copy(values: Array, result: Array) -> None:
            result[:] = values

        norm = float(np.linalg.norm(right))
        if norm <= goal:
            return right
        tolerance = max(goal / norm, 1e-14)
        found = bicgstab(apply, copy, right.ravel().copy(), tolerance, MOST_ITERATIONS)
        return found.answer.reshape(right.shape)


@shared
def stream(sent: Array, velocities: NDArray[np.int64], arrived: Array) -> None:
    """Each population one step on, into arrived (9, nx, ny); what leaves the grid is gone."""
    nx, ny = sent.shape[1], sent.shape[2]
    for i in range(sent.shape[0]):
        dx, dy = velocities[i, 0], velocities[i, 1]
        for x in range(nx):
            for y in range(ny):
                u, v = x - dx, y - dy
                inside = 0 <= u < nx and 0 <= v < ny
                arrived[i, x, y] = sent[i, u, v] if inside else 0.0


@shared
def collide(matrix: Array, populations: Array) -> None:
    """populations (9, nx, ny) = Θ populations, cell by cell."""
    count = populations.shape[0]
    old = np.empty(count)
    for x in range(populations.shape[1]):
        for y in range(populations.shape[2]):
            for j in range(count):
                old[j] = populations[j, x, y]
            for i in range(count):
                total = 0.0
                for j in range(count):
                    total += matrix[i, j] * old[j]
                populations[i, x, y] = total
