"""From the intensity that leaves a cell to the radiance in it.

In a uniform field of radiance L a cell sends I(ω) = L(ω) h^(D-1) Σ|ω_i|: its size times its
cross-section (numerics §1). Read the other way round this turns a stored intensity into a radiance.
The cross-section that is divided by is the one a field of n bands can hold, so that a uniform field
of the same radiance in all directions gives that radiance for every number of bands.
What it gets wrong: light that is not uniform over a cell, and whatever truncation to n bands does.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import AngularBasis

Array = NDArray[np.float64]


@lru_cache(maxsize=64)
def cross_section(basis: AngularBasis) -> Array:
    """Coefficients (size,) of Σ|ω_i|: the mean, 4/π or 3/2, alone below five bands."""
    axes = np.eye(basis.dimension)
    result = basis.clamped_cosine(np.concatenate([axes, -axes])).sum(axis=0)
    result.setflags(write=False)
    return np.asarray(result)


def radiance_weights(basis: AngularBasis, directions: Array, spacing: float) -> Array:
    """Weights (M, size) that make coefficients the radiance along unit vectors (M, dimension)."""
    values = basis.evaluate(directions)
    size = spacing ** (basis.dimension - 1) * (values @ cross_section(basis))
    return np.asarray(values / size[:, None])


@lru_cache(maxsize=64)
def radiance_matrix(basis: AngularBasis) -> Array:
    """Matrix (size, size): coefficients of I become those of L h^(D-1), cut off at n bands.

    ∫ y yᵀ / χ dω with the cross-section χ of `cross_section`: two thirds (3D) or π/4 (2D) of the
    identity below five bands. χ is smooth, so that the quadrature converges faster than any power.
    """
    directions, weights = basis.quadrature(8 * basis.bands + 64)
    values = basis.evaluate(directions)
    result = (values.T * (weights / (values @ cross_section(basis)))) @ values
    result.setflags(write=False)
    return np.asarray(result)
