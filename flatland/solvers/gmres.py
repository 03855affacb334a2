"""Flexible GMRES on the padded buffers of a sweep (Saad 1993).

The residual never grows and the preconditioner may be of lower precision: each of its answers is
kept and used as it is. Both failed BiCGSTAB with a single-precision preconditioner on 512² cells.
The price is one vector of each precision an iteration.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.solvers.bicgstab import Operator, Outcome
from flatland.solvers.vectors import BLOCK, FAST, dot, dots

Vector = NDArray[np.float64]

#: A vector that loses more than this share of its length by orthogonalisation is treated twice.
_LOSS = 0.7


def flexible_gmres(
    apply: Operator,
    precondition: Operator,
    right: Vector,
    tolerance: float,
    limit: int,
    restart: int,
) -> Outcome:
    """Iterate on apply(x) = right from zero until the relative residual is below the tolerance.

    apply, precondition: write their result into the second vector. restart: iterations after
    which the space is dropped; the number of vectors that are kept.
    """
    answer, rest, work = np.zeros_like(right), right.copy(), np.zeros_like(right)
    start = residual = float(np.sqrt(dot(right, right)))
    iterations = 0
    while start > 0 and residual > tolerance * start and iterations < limit:
        steps = min(restart, limit - iterations)
        space, before = _Space(rest, residual, steps), residual
        residual = space.grow(apply, precondition, tolerance * start)
        iterations += space.count
        space.add_to(answer)
        apply(answer, work)
        np.subtract(right, work, out=rest)
        residual = float(np.sqrt(dot(rest, rest)))
        if not residual < 0.5 * before:
            break
    return Outcome(answer, iterations, residual / start if start else 0.0)


class _Space:
    """One run of Arnoldi's method: directions z_k = M⁻¹ v_k, and A Z = V H."""

    def __init__(self, rest: Vector, length: float, steps: int) -> None:
        self.steps, self.count = steps, 0
        self.basis = np.empty((steps + 1, rest.size))
        np.divide(rest, length, out=self.basis[0])
        self.directions: list[NDArray[np.float32]] = []
        self.triangle = np.zeros((steps + 1, steps))
        self.turns = np.zeros((steps, 2))
        self.right = np.zeros(steps + 1)
        self.right[0] = length
        self.scratch = np.zeros_like(rest)

    def grow(self, apply: Operator, precondition: Operator, goal: float) -> float:
        """Add directions until the residual is below `goal`; the residual as estimated."""
        while self.count < self.steps:
            precondition(self.basis[self.count], self.scratch)
            self.directions.append(self.scratch.astype(np.float32))
            self.scratch[:] = self.directions[-1]
            image = np.zeros_like(self.scratch)
            apply(self.scratch, image)
            length = self._append(image)
            residual = abs(float(self.right[self.count]))
            if residual <= goal or not length > 0:
                break
        return residual

    def _append(self, image: Vector) -> float:
        """Orthogonalise an image, keep it, and turn its column of H into a triangle's."""
        column, k = self.triangle[:, self.count], self.count
        before = np.sqrt(dot(image, image))
        length = self._orthogonalise(image, column)
        if length < _LOSS * before:
            length = self._orthogonalise(image, column)
        for i, (cosine, sine) in enumerate(self.turns[:k]):
            upper, lower = column[i], column[i + 1]
            column[i], column[i + 1] = (
                cosine * upper + sine * lower,
                cosine * lower - sine * upper,
            )
        size = np.hypot(column[k], length)
        self.turns[k] = (column[k] / size, length / size) if size > 0 else (1.0, 0.0)
        column[k] = size
        self.right[k + 1] = -self.turns[k, 1] * self.right[k]
        self.right[k] *= self.turns[k, 0]
        self.count += 1
        if length > 0:
            np.divide(image, length, out=self.basis[self.count])
        return length

    def _orthogonalise(self, image: Vector, column: Vector) -> float:
        """Take the components along the basis out of an image, add them to column; its length."""
        parts = np.zeros(self.count + 1)
        dots(self.basis, parts, image)
        column[: parts.size] += parts
        return float(np.sqrt(_subtract_all(self.basis, parts, image)))

    def add_to(self, answer: Vector) -> None:
        """answer += Z y, y the least-squares solution."""
        k = self.count
        weights = np.linalg.lstsq(self.triangle[:k, :k], self.right[:k], rcond=None)[0]
        for weight, direction in zip(weights, self.directions):
            _subtract(answer, -weight, direction)


@njit(cache=True, fastmath=FAST)
def _subtract_all(basis, parts, image):  # type: ignore[no-untyped-def]
    """image −= Σ parts[i] v_i; returns image · image."""
    squares = 0.0
    for start in range(0, image.size, BLOCK):
        piece = image[start : start + BLOCK]
        for i in range(parts.size):
            row = basis[i, start : start + BLOCK]
            part = parts[i]
            for j in range(piece.size):
                piece[j] -= part * row[j]
        for j in range(piece.size):
            squares += piece[j] * piece[j]
    return squares


@njit(cache=True, fastmath=FAST)
def _subtract(target, factor, vector):  # type: ignore[no-untyped-def]
    for i in range(target.size):
        target[i] -= factor * vector[i]
