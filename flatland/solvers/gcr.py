"""Truncated GCR on the padded buffers of a sweep (Eisenstat, Elman & Schultz 1983: ORTHOMIN).

The residual never grows and the preconditioner may be another one each time, as for GMRES, but a
few directions are kept instead of all. Behind a preconditioner that leaves little to be found,
images are nearly orthogonal to those before by themselves: five directions need as many iterations
as all (at most one more in the cases measured), and time and memory do not grow with them.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from flatland.solvers.bicgstab import Operator, Outcome
from flatland.solvers.vectors import dot

Vector = NDArray[np.float64]

#: Directions that are kept.
KEPT = 5
#: Numbers that are worked on at a time.
_BLOCK = 2048
_FAST = {"reassoc", "contract", "nsz"}


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
        others = np.array([k for k in range(min(iterations, KEPT)) if k != now], np.int64)
        precondition(rest, directions[now])
        apply(directions[now], images[now])
        _products(images, images[now], others, parts)
        parts /= lengths
        length, share = _without(directions, images, now, others, parts, rest)
        if not (length > 0 and np.isfinite(length)):
            break
        lengths[now] = length
        squares = _advance(answer, rest, share / length, directions[now], images[now])
        iterations += 1
    return Outcome(answer, iterations, float(np.sqrt(squares / start)) if start else 0.0)


@njit(cache=True, fastmath=_FAST)
def _products(images, image, others, parts):  # type: ignore[no-untyped-def]
    """parts[k] = images[k] · image, in blocks that stay in the cache."""
    parts[:] = 0
    for start in range(0, image.size, _BLOCK):
        piece = image[start : start + _BLOCK]
        for k in others:
            row = images[k, start : start + _BLOCK]
            total = 0.0
            for j in range(piece.size):
                total += row[j] * piece[j]
            parts[k] += total


@njit(cache=True, fastmath=_FAST)
def _without(directions, images, now, others, parts, rest):  # type: ignore[no-untyped-def]
    """Take the others' parts out of an image and its direction.

    Returns image · image and image · rest.
    """
    length = share = 0.0
    for start in range(0, rest.size, _BLOCK):
        stop = start + _BLOCK
        image, direction = images[now, start:stop], directions[now, start:stop]
        piece = rest[start:stop]
        for k in others:
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


@njit(cache=True, fastmath=_FAST)
def _advance(answer, rest, weight, direction, image):  # type: ignore[no-untyped-def]
    """answer += weight direction, rest −= weight image; returns rest · rest."""
    squares = 0.0
    for i in range(rest.size):
        answer[i] += weight * direction[i]
        value = rest[i] - weight * image[i]
        rest[i] = value
        squares += value * value
    return squares
