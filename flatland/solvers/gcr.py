"""Truncated GCR on the padded buffers of a sweep (Eisenstat, Elman & Schultz 1983: ORTHOMIN).

The residual never grows and the preconditioner may be another one each time, as for GMRES, but a
few directions are kept instead of all. Behind a preconditioner that leaves little to be found,
images are nearly orthogonal to those before by themselves: five directions need as many iterations
as all (at most two more in the cases measured), and time and memory do not grow with them.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.solvers.bicgstab import Operator, Outcome
from flatland.solvers.vectors import BLOCK, FAST, add, dot, dots, subtract

Vector = NDArray[np.float64]

#: Directions that are kept.
KEPT = 5


def gcr(
    apply: Operator, precondition: Operator, right: Vector, tolerance: float, limit: int
) -> Outcome:
    """Iterate on apply(x) = right from zero until the relative residual is below the tolerance.

    apply, precondition: write their result into the second vector. Ends early where an image
    vanishes; the caller checks the true residual.
    """
    answer, rest = np.zeros_like(right), right.copy()
    directions, images = (np.zeros((KEPT, right.size)) for _ in range(2))
    lengths, parts = np.ones(KEPT), np.zeros(KEPT)
    start = squares = float(dot(right, right))
    goal, iterations = tolerance**2 * start, 0
    while squares > goal and iterations < limit:
        now = iterations % KEPT
        direction, image = directions[now], images[now]
        precondition(rest, direction)
        apply(direction, image)
        parts[:] = 0
        dots(images, parts, image)
        parts /= lengths
        length, share = _without(directions, images, now, parts, rest)
        if not (length > 0 and np.isfinite(length)):
            break
        lengths[now] = length
        add(answer, share / length, direction, 0.0, direction)
        squares = float(subtract(rest, share / length, image))
        iterations += 1
    return Outcome(answer, iterations, float(np.sqrt(squares / start)) if start else 0.0)


@njit(cache=True, fastmath=FAST)
def _without(directions, images, now, parts, rest):  # type: ignore[no-untyped-def]
    """Take parts of all others out of an image and its direction.

    Returns image · image and image · rest.
    """
    length = share = 0.0
    for start in range(0, rest.size, BLOCK):
        stop = start + BLOCK
        image, direction = images[now, start:stop], directions[now, start:stop]
        piece = rest[start:stop]
        for k in range(parts.size):
            if k != now:
                part = parts[k]
                row, line = images[k, start:stop], directions[k, start:stop]
                for j in range(piece.size):
                    image[j] -= part * row[j]
                for j in range(piece.size):
                    direction[j] -= part * line[j]
        for j in range(piece.size):
            length += image[j] * image[j]
            share += image[j] * piece[j]
    return length, share
