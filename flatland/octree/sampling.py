"""Light between the centres of cells, by (bi/tri)linear interpolation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

Values = NDArray[np.floating]


def sampled(values: Values, places: NDArray[np.float64]) -> Values:
    """values (..., *shape) at places (dimension, ...) in cell units; the centre of cell i at i + ½.

    Beyond the outermost centres the value there goes on. Returns (..., *places.shape[1:]).
    """
    dimension = len(places)
    leading = values.shape[: values.ndim - dimension]
    flat = values.reshape(-1, *values.shape[values.ndim - dimension :])
    result = np.empty((len(flat), *places.shape[1:]), values.dtype)
    for picture, out in zip(flat, result):
        map_coordinates(picture, places - 0.5, output=out, order=1, mode="nearest")
    return result.reshape(*leading, *places.shape[1:])
