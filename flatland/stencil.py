"""A propagation scheme as data: offsets and transfer matrices."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.harmonics import AngularBasis
from flatland.stability import spectral_radius, symbol

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Stencil:
    """One step S_{i+1}(x + d) += τ(x, d) T_d S_i(x) for every offset d (numerics §3).

    offsets: (K, dimension), whole cells, each in {-1, 0, 1} and none of them zero.
    transfer: (K, size, size), T_d acting on the coefficients of the source cell.
    reception (K, F, size) and emission (K, size, F), optional: transfer = emission @ reception,
    where reception gives the flux onto F faces. `clamp` sets negative face fluxes to zero; the
    step is then non-linear, and the transfer matrices describe only its linear twin.
    Raises InputError for arrays that do not fit together.
    """

    basis: AngularBasis
    offsets: NDArray[np.int64]
    transfer: Array
    reception: Array | None = None
    emission: Array | None = None
    clamp: bool = False

    def __post_init__(self) -> None:
        count, size = len(self.offsets), self.basis.size
        if self.offsets.shape != (count, self.basis.dimension) or np.abs(self.offsets).max() > 1:
            rule = f"must be (K, {self.basis.dimension}) steps of -1, 0 or 1"
            raise bad_input("offsets", self.offsets, rule)
        if not np.all(np.any(self.offsets != 0, axis=1)):
            raise bad_input("offsets", self.offsets, "must not hold the zero offset")
        if self.transfer.shape != (count, size, size):
            raise bad_input("transfer", self.transfer.shape, f"must be {(count, size, size)}")
        if not np.all(np.isfinite(self.transfer)):
            raise bad_input("transfer", self.transfer, "must be finite")
        if self.clamp and (self.reception is None or self.emission is None):
            raise bad_input("clamp", True, "needs reception and emission")

    @classmethod
    def from_faces(
        cls,
        basis: AngularBasis,
        offsets: ArrayLike,
        reception: Array,
        emission: Array,
        clamp: bool = False,
    ) -> Stencil:
        """A scheme that gathers flux on faces and re-emits one lobe per face."""
        return cls(
            basis, np.asarray(offsets, np.int64), emission @ reception, reception, emission, clamp
        )

    def scaled(self, factor: float) -> Stencil:
        """The scheme with every step multiplied by a factor."""
        emission = None if self.emission is None else self.emission * factor
        return Stencil(
            self.basis, self.offsets, self.transfer * factor, self.reception, emission, self.clamp
        )

    @property
    def flux_gain(self) -> Array:
        """Flux sent out per unit of each coefficient, over that of band 0: Σ_d T_d[0, :], (size,).

        (1, 0, 0, …) for a scheme that conserves flux in every cell.
        """
        return np.asarray(self.transfer[:, 0, :].sum(axis=0))

    def symbol(self, wave_vectors: ArrayLike) -> NDArray[np.complex128]:
        """A(k) = Σ_d T_d exp(−i k·d), (..., size, size), at k (..., dimension) [rad per cell]."""
        return symbol(self.offsets, self.transfer, np.asarray(wave_vectors, float))

    def spectral_radius(self) -> float:
        """max over k of the largest |eigenvalue| of the symbol; above 1, light grows without bound.

        See flatland.stability for how, and how accurately. For a clamped scheme this is the radius
        of its linear twin.
        """
        return self._radius

    @cached_property
    def _radius(self) -> float:
        return spectral_radius(self.basis, self.offsets, self.transfer)


class Scheme(Protocol):
    """What a simulation needs of a propagator: its stencil, and a warning of an unstable one."""

    def stencil(self, basis: AngularBasis) -> Stencil: ...

    def warn_if_unstable(self, stencil: Stencil) -> None: ...
