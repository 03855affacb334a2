"""Arguments of the analytic reference, checked at its border."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input

Array = NDArray[np.float64]


def checked_points(argument: str, points: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.asarray(points, float)
    fits = array.ndim == len(shape) and array.shape[-1] == shape[-1]
    if not fits or not np.all(np.isfinite(array)):
        numbers = "2 finite numbers" if len(shape) == 1 else "finite numbers of shape (K, 2)"
        raise bad_input(argument, points, f"must be {numbers}")
    return array


def checked_directions(directions: ArrayLike, argument: str = "directions") -> Array:
    unit = np.atleast_2d(np.asarray(directions, float))
    lengths = np.linalg.norm(unit, axis=-1)
    if unit.ndim != 2 or unit.shape[1] != 2 or not np.all(np.abs(lengths - 1) < 1e-6):
        raise bad_input(argument, directions, "must be unit vectors of shape (K, 2)")
    return np.ascontiguousarray(unit / lengths[:, None])
