"""A propagation scheme as data: offsets and transfer matrices."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize

from flatland.errors import bad_input
from flatland.harmonics import AngularBasis

Array = NDArray[np.float64]

#: A radius this close to 1 is rounding, not growth: 10^5 steps gain less than 10^-4.
RADIUS_TOLERANCE = 1e-9


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
        phases = np.exp(-1j * (np.asarray(wave_vectors, float) @ self.offsets.T))
        return np.tensordot(phases, self.transfer.astype(complex), axes=(-1, 0))

    def spectral_radius(self) -> float:
        """max over k of the largest |eigenvalue| of the symbol; above 1, light grows without bound.

        Samples a grid of wave vectors that holds all corners and edge middles of the zone, then
        climbs from the best ones. Accurate to about 1e-9 for the smooth maxima of these schemes.
        For a clamped scheme this is the radius of its linear twin.
        """
        return self._radius

    @cached_property
    def _radius(self) -> float:
        if self._all_semidefinite():
            # |x*A(k)y| ≤ Σ_d |x*T_d y| ≤ ‖Σ_d T_d‖ by Cauchy–Schwarz, reached at k = 0.
            return float(np.linalg.eigvalsh(self.transfer.sum(axis=0)).max())
        samples = self._wave_vectors()
        values = self._radius_at(samples)
        best = float(values.max())
        for start in samples[np.argsort(values)[-3:]]:
            found = minimize(
                lambda k: -self._radius_at(k[None])[0],
                start,
                method="Nelder-Mead",
                options={"xatol": 1e-7, "fatol": 1e-12, "maxiter": self._climb_steps()},
            )
            best = max(best, float(-found.fun))
        return best

    def _climb_steps(self) -> int:
        return int(np.clip(4e6 / self.basis.size**3, 20, 200))

    def _all_semidefinite(self) -> bool:
        symmetric = np.abs(self.transfer - self.transfer.swapaxes(1, 2)).max() < 1e-14
        return bool(symmetric and np.linalg.eigvalsh(self.transfer).min() > -1e-14)

    def _wave_vectors(self) -> Array:
        """Samples of half the Brillouin zone: A(-k) is the conjugate of A(k)."""
        budget = 4e6 / self.basis.size**2.5  # eigenvalues cost about size^3
        per_axis = int(np.clip(budget ** (1 / self.basis.dimension), 4, 24)) // 4 * 4
        axis = np.linspace(-np.pi, np.pi, per_axis, endpoint=False)
        half = np.append(axis[axis >= 0], np.pi)
        axes = [half, *[axis] * (self.basis.dimension - 1)]
        return np.array(list(itertools.product(*axes)))

    def _radius_at(self, wave_vectors: Array) -> Array:
        eigenvalues = np.linalg.eigvals(self.symbol(wave_vectors))
        return np.asarray(np.abs(eigenvalues).max(axis=-1))
