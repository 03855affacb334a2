"""Sets of neighbour directions and the arcs that belong to them, in 2D."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import CircularHarmonics

Array = NDArray[np.float64]

AXIAL_2D = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
ALL_2D = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])


def unit(vectors: NDArray[np.int64] | Array) -> Array:
    """Vectors (..., dimension) scaled to length 1."""
    array = np.asarray(vectors, float)
    return np.asarray(array / np.linalg.norm(array, axis=-1, keepdims=True))


def angle(vectors: NDArray[np.int64] | Array) -> Array:
    """Angle (...) of vectors (..., 2) from +x, counter-clockwise [rad]."""
    array = np.asarray(vectors, float)
    return np.asarray(np.arctan2(array[..., 1], array[..., 0]))


def equal_arcs(offsets: NDArray[np.int64]) -> tuple[Array, Array]:
    """Start and stop angles (K,) of the Voronoi cells of K evenly spread directions."""
    middle, half = angle(offsets), np.pi / len(offsets)
    return middle - half, middle + half


def mirror_of(degrees: NDArray[np.int64]) -> Array:
    """Signs (size,) that y(θ) takes under θ → −θ: cosines stay, sines turn."""
    is_sine = (np.arange(degrees.size) % 2 == 0) & (degrees > 0)
    return np.where(is_sine, -1.0, 1.0)


def circular(basis: object) -> CircularHarmonics:
    """The basis, known to be circular."""
    assert isinstance(basis, CircularHarmonics)
    return basis
