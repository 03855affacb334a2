"""From flows of spherical polygons (see `flow`) to harmonics: linear, so applied last."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import SphericalHarmonics
from flatland.harmonics.spherical_polygons import direction_products, gradient_table

Array = NDArray[np.float64]


@lru_cache(maxsize=16)
def polygon_map(bands: int) -> Array:
    """∫ y dω of bands ≥ 2 from flows of one band less, (bands², 3 (bands - 1)² + 1)."""
    basis = SphericalHarmonics(bands)
    result = np.zeros((basis.size, 3 * (bands - 1) ** 2 + 1))
    result[:, :-1] = gradient_table(basis).transpose(1, 0, 2).reshape(basis.size, -1)
    result[0, -1] = 1 / basis.flux_weight
    return result


@lru_cache(maxsize=16)
def cosine_maps(bands: int) -> Array:
    """∫ ω_i y dω from flows of as many bands, (3, bands², 3 bands² + 1)."""
    basis, wide = SphericalHarmonics(bands), SphericalHarmonics(bands + 1)
    return np.asarray(direction_products(basis, wide) @ polygon_map(bands + 1))


def series_map(bands: int, series: Array) -> Array:
    """∫ I y dω from flows of `series_bands`, for I = Σ_j series_j y_j, (bands², flow)."""
    basis, wide = SphericalHarmonics(bands), SphericalHarmonics(series_bands(bands, series) + 1)
    own = SphericalHarmonics(_bands_of(series))
    directions, weights = basis.quadrature(2 * wide.bands)
    weights = weights * (own.evaluate(directions) @ series)
    products = (basis.evaluate(directions).T * weights) @ wide.evaluate(directions)
    return np.asarray(products @ polygon_map(wide.bands))


def series_bands(bands: int, series: Array) -> int:
    """Bands of the flows that `series_map` starts from."""
    return max(1, bands + _bands_of(series) - 2)


def _bands_of(series: Array) -> int:
    return round(np.sqrt(len(series)))
