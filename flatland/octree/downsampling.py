"""From a level to the next coarser one and back."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def halved(values: NDArray[np.floating], dimension: int) -> NDArray[Any]:
    """Mean of the 2^D children of every coarse cell (the octree thesis, equation 11).

    values: (..., *shape), space last, `dimension` axes of it. An axis of odd length ends in a cell
    whose missing children count as dark, so that the sum over coarse cells is always 2^-D times
    the sum over fine ones: the mean keeps the flux of the light per volume. A constant stays
    that constant in every cell that has all its children.
    """
    for axis in range(values.ndim - dimension, values.ndim):
        lower: Any = (*[slice(None)] * axis, slice(None, None, 2))
        upper: Any = (*[slice(None)] * axis, slice(1, None, 2))
        total, rest = values[lower].copy(), values[upper]
        pairs: Any = (*[slice(None)] * axis, slice(rest.shape[axis]))
        total[pairs] += rest
        # A power of two, and pairs of equals: a constant is kept to the last bit.
        values = 0.5 * total
    return values


def spread(values: NDArray[Any], level: int, shape: tuple[int, ...]) -> NDArray[Any]:
    """A level's cells repeated in all their cells of level 0, (..., *coarse) as (..., *shape)."""
    for axis in range(-len(shape), 0):
        values = np.repeat(values, 2**level, axis)
    inside: Any = (..., *map(slice, shape))
    return values[inside]
