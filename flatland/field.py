"""A field: one angular distribution of intensity per cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.harmonics import AngularBasis, basis_for

Values = NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class Field:
    """Intensity [W/rad in 2D, W/sr in 3D] that leaves each cell, as coefficients of a basis.

    values: (size, nx, ny[, nz]), or (colours, size, nx, ny[, nz]). Spatial axes come last, so
    that each coefficient is one contiguous picture of the grid.
    """

    grid: Grid
    basis: AngularBasis
    values: Values

    def __post_init__(self) -> None:
        expected = (self.basis.size, *self.grid.shape)
        shape = self.values.shape
        if shape[-len(expected) :] != expected or len(shape) > len(expected) + 1:
            rule = f"must be {expected} or (colours, {str(expected)[1:]}"
            raise bad_input("the shape of values", shape, rule)
        if self.basis.dimension != self.grid.dimension:
            rule = f"must match the grid's {self.grid.dimension} dimensions"
            raise bad_input("basis", self.basis, rule)

    @property
    def coloured(self) -> bool:
        """Whether the leading axis of `values` is that of colours."""
        return self.values.ndim == self.grid.dimension + 2

    @property
    def _coefficient_axis(self) -> int:
        return -1 - self.grid.dimension

    def coefficient(self, index: int) -> Values:
        """One coefficient, ([colours,] nx, ny[, nz])."""
        return np.take(self.values, index, axis=self._coefficient_axis)

    def scalar_flux(self) -> NDArray[np.float64]:
        """Flux that leaves each cell in all directions, ∫ I dω [W], ([colours,] nx, ny[, nz])."""
        return self.coefficient(0).astype(float) * self.basis.flux_weight

    def total_flux(self) -> NDArray[np.float64]:
        """Sum of the scalar flux over cells [W], () or (colours,)."""
        axes = tuple(range(-self.grid.dimension, 0))
        return np.asarray(self.scalar_flux().sum(axis=axes))

    def net_flux(self) -> NDArray[np.float64]:
        """Vector flux ∫ I ω dω [W], ([colours,] dimension, nx, ny[, nz]); zero for one band."""
        directions, weights = self.basis.quadrature(2 * self.basis.bands)
        weighted = (weights[:, None] * directions).T @ self.basis.evaluate(directions)
        return self._contract(weighted)

    def evaluate(self, directions: ArrayLike) -> NDArray[np.float64]:
        """Intensity ([colours,] K, nx, ny[, nz]) at unit directions (K, dimension)."""
        return self._contract(self.basis.evaluate(np.atleast_2d(np.asarray(directions, float))))

    def with_bands(self, bands: int) -> Field:
        """The same field with fewer bands (dropped) or more (zero)."""
        basis = basis_for(self.grid.dimension, bands)
        axis = self._coefficient_axis
        shape = list(self.values.shape)
        shape[axis] = basis.size
        values = np.zeros(shape, self.values.dtype)
        common = min(basis.size, self.basis.size)
        target, source = np.moveaxis(values, axis, 0), np.moveaxis(self.values, axis, 0)
        target[:common] = source[:common]
        return Field(self.grid, basis, values)

    def _contract(self, matrix: NDArray[np.float64]) -> NDArray[np.float64]:
        """matrix (K, size) applied to the coefficient axis."""
        result = np.tensordot(
            matrix, self.values, axes=(1, self.values.ndim + self._coefficient_axis)
        )
        return np.moveaxis(result, 0, self._coefficient_axis)
