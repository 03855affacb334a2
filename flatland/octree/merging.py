"""One field from many levels, on the cells of level 0."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from flatland.errors import bad_input
from flatland.octree.downsampling import spread
from flatland.octree.index import Index
from flatland.octree.sampling import sampled

Values = NDArray[np.floating]
#: Gives the light (size, *shape) of a level when it is needed.
Source = Callable[[int], Values]


def merged(source: Source, index: Index) -> Values:
    """M(x) = O_{I(x)}(x) (the octree thesis 4.2), (size, *index.shape)."""
    result = np.array(source(0))
    for level in np.unique(index):
        if level > 0:
            light = spread(source(int(level)), int(level), index.shape)
            np.copyto(result, light, where=index == level)
    return result


def blended(source: Source, index: Index, width: float) -> Values:
    """As `merged`, without jumps: levels fade into each other and are interpolated in space.

    width: over how many cells of level i it fades in, in front of where it is read, 0 or more.
    Level i has the weight clip(1 − d_i(x) / (width · 2^i), 0, 1) over all finer ones, with d_i
    the distance to the nearest cell that is read from level i or a coarser one. So a place keeps
    at least the level that it has, and light is taken only from levels that have it. What it gets
    wrong: near a border, coarse light replaces a part of the finer.
    """
    require_width(width)
    result = np.array(source(0), float)
    centres = np.indices(index.shape) + 0.5
    for level in range(1, int(index.max()) + 1):
        weight = _weight(index >= level, width * 2**level)
        cells = np.nonzero(weight)
        points = np.array([axis[cells] for axis in centres]) / 2**level
        light = sampled(source(level).astype(float), points)
        share = weight[cells]
        places: Any = (..., *cells)
        result[places] = (1 - share) * result[places] + share * light
    return result.astype(source(0).dtype)


def require_width(width: float | None) -> None:
    """Raise InputError for a width that `blended` cannot have; None is none."""
    if width is not None and not (np.isfinite(width) and width >= 0):
        raise bad_input("blend", width, "must be finite and at least 0")


def _weight(mask: NDArray[np.bool_], reach: float) -> NDArray[np.float64]:
    if reach == 0 or mask.all():
        return mask.astype(float)
    return np.asarray(np.clip(1 - distance_transform_edt(~mask) / reach, 0.0, 1.0))
