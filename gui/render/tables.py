"""Values of an angular basis at every pixel of a cell."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import AngularBasis
from gui.models.plane import Plane
from gui.render.kernel import largest_sizes

Floats = NDArray[np.float32]
#: Directions at which the size of a lobe is measured, per band and at least.
_PER_BAND, _LEAST = 12, 24


class PixelTable(NamedTuple):
    """values (size, p, p): the basis in the direction of each pixel from the middle of a cell of
    p x p pixels, first row on top; distances (p, p): from the middle [pixels].
    """

    values: Floats
    distances: Floats


@lru_cache(maxsize=16)
def pixel_table(basis: AngularBasis, axes: tuple[int, int], pixels: int) -> PixelTable:
    """The table of a basis, seen in the plane of two axes."""
    offsets = np.arange(pixels) - (pixels - 1) / 2
    right, up = np.meshgrid(offsets, -offsets)
    angles = np.arctan2(up, right)
    distances = np.hypot(right, up).astype(np.float32)
    values = _evaluate(basis, axes, angles.ravel()).T.reshape(-1, pixels, pixels)
    return PixelTable(np.ascontiguousarray(values, dtype=np.float32), distances)


@lru_cache(maxsize=16)
def circle_table(basis: AngularBasis, axes: tuple[int, int], count: int = 0) -> Floats:
    """The basis at evenly spread directions of the plane from angle 0, (count, size)."""
    number = count or max(_LEAST, _PER_BAND * basis.bands)
    angles = np.arange(number, dtype=float) * (2 * np.pi / number)
    return _evaluate(basis, axes, angles).astype(np.float32)


def _evaluate(
    basis: AngularBasis, axes: tuple[int, int], angles: NDArray[np.float64]
) -> NDArray[np.float64]:
    directions = Plane(axes).directions(angles, basis.dimension)
    return basis.evaluate(directions)


def peaks(basis: AngularBasis, axes: tuple[int, int], values: NDArray[np.floating]) -> Floats:
    """Largest size of the intensity over directions in the plane, (...) for values (size, ...).

    Sampled 12 times per band: 1 - cos(π/12) = 3.4 % too small at most, less than what a lobe at
    full size keeps from the side of its cell.
    """
    flat = np.ascontiguousarray(values, np.float32).reshape(len(values), -1)
    found = np.zeros(flat.shape[1], np.float32)
    # Not a matrix product: BLAS would wake all its threads for a millisecond of work.
    largest_sizes(circle_table(basis, axes), flat, found)
    return found.reshape(values.shape[1:])
