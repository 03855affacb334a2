"""Sets of neighbour offsets, by dimension."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Offsets = NDArray[np.int64]

AXIAL_2D = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
ALL_2D = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
AXIAL_3D = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)])
ALL_3D = np.array([offset for offset in itertools.product((1, 0, -1), repeat=3) if any(offset)])

#: Offsets to the neighbours that share a face with a cell, by dimension.
AXIAL = {2: AXIAL_2D, 3: AXIAL_3D}


def unit(vectors: Offsets | Array) -> Array:
    """Vectors (..., dimension) scaled to length 1."""
    array = np.asarray(vectors, float)
    return np.asarray(array / np.linalg.norm(array, axis=-1, keepdims=True))


def angle(vectors: Offsets | Array) -> Array:
    """Angle (...) of vectors (..., 2) from +x, counter-clockwise [rad]."""
    array = np.asarray(vectors, float)
    return np.asarray(np.arctan2(array[..., 1], array[..., 0]))


def perpendicular(vectors: Array) -> tuple[Array, Array]:
    """Two unit vectors (..., 3) that make a right-handed frame with unit vectors (..., 3)."""
    axis = np.eye(3)[np.argmin(np.abs(vectors), axis=-1)]
    first = unit(np.cross(axis, vectors))
    return first, np.cross(vectors, first)
