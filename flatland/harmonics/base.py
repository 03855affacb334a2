"""What every angular basis offers, whatever its dimension."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from numbers import Integral
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input

Array = NDArray[np.float64]


class AngularBasis(ABC):
    """Orthonormal real functions of direction, bands l = 0 … bands - 1 (numerics: "n bands").

    Directions are unit vectors (..., dimension) that light TRAVELS along; coefficient arrays are
    (..., size). Truncation to n bands is the method's first error: it rings, and it can make an
    intensity negative.
    """

    dimension: ClassVar[int]
    #: Measure of all directions: 2 pi rad or 4 pi sr.
    total_angle: ClassVar[float]

    def __init__(self, bands: int) -> None:
        if not isinstance(bands, Integral) or isinstance(bands, bool) or bands < 1:
            raise bad_input("bands", bands, "must be a whole number, at least 1")
        self.bands: int = int(bands)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other.bands == self.bands

    def __hash__(self) -> int:
        return hash((type(self), self.bands))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.bands})"

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of coefficients."""

    @property
    @abstractmethod
    def degrees(self) -> NDArray[np.int64]:
        """Band l of each coefficient, (size,)."""

    @abstractmethod
    def evaluate(self, directions: ArrayLike) -> Array:
        """Basis functions (..., size) at directions (..., dimension)."""

    @abstractmethod
    def clamped_cosine(self, normals: ArrayLike) -> Array:
        """Coefficients (..., size) of max(0, n·ω) for unit normals (..., dimension).

        Not normalised: its flux is 2 on the circle and pi on the sphere.
        """

    @abstractmethod
    def quadrature(self, degree: int) -> tuple[Array, Array]:
        """Directions (K, dimension) and weights (K,) that integrate harmonics up to `degree`."""

    @cached_property
    def parities(self) -> NDArray[np.int64]:
        """±1 per coefficient and axis, (size, dimension): its sign when that axis is turned round.

        From values at random directions, each of which has it.
        """
        directions = np.random.default_rng(0).normal(size=(4 * self.size, self.dimension))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        plain = self.evaluate(directions)
        mirrors = 1 - 2 * np.eye(self.dimension)
        images = [self.evaluate(directions * mirror) for mirror in mirrors]
        signs = [np.sign(np.sum(plain * image, axis=0)) for image in images]
        return np.stack(signs, axis=1).astype(np.int64)

    @property
    def flux_weight(self) -> float:
        """Factor from the coefficient of band 0 to the flux, ∫ y_0 dω = √(2 pi) or √(4 pi)."""
        return float(np.sqrt(self.total_angle))

    def isotropic(self, flux: float = 1.0) -> Array:
        """Coefficients (size,) of a constant intensity of the given flux."""
        coefficients = np.zeros(self.size)
        coefficients[0] = flux / self.flux_weight
        return coefficients

    def lambertian(self, normals: ArrayLike, flux: float = 1.0) -> Array:
        """Coefficients (..., size) of a Lambertian emitter, Φ⟨n|ω⟩₊/2 in 2D, /π in 3D."""
        lobes = self.clamped_cosine(normals)
        return lobes * (flux / (self.flux_weight * lobes[..., :1]))

    def project(self, function: Callable[[Array], ArrayLike], degree: int | None = None) -> Array:
        """Coefficients (size,) of `function`, called once with directions (K, dimension).

        degree: highest harmonic of function times basis that is integrated exactly; 8 times the
        bands, at least 256 in 2D and 63 in 3D by default. A function with jumps or kinks
        converges only algebraically with it.
        """
        if degree is None:
            degree = max(8 * self.bands, 256 if self.dimension == 2 else 63)
        directions, weights = self.quadrature(degree)
        values = np.broadcast_to(np.asarray(function(directions), float), weights.shape)
        return np.asarray((weights * values) @ self.evaluate(directions))

    def _unit(self, vectors: ArrayLike, argument: str) -> Array:
        """Vectors (..., dimension), checked to be finite and of length 1 to 1e-6."""
        array = np.asarray(vectors, float)
        if array.ndim == 0 or array.shape[-1] != self.dimension:
            rule = f"must be unit vectors of shape (..., {self.dimension})"
            raise bad_input(argument, vectors, rule)
        lengths = np.linalg.norm(array, axis=-1)
        if not np.all(np.abs(lengths - 1.0) < 1e-6):
            raise bad_input(argument, vectors, "must be finite and of length 1")
        return array


def basis_for(dimension: int, bands: int) -> AngularBasis:
    """The harmonics of a dimension: circular for 2, spherical for 3."""
    from flatland.harmonics.circular import CircularHarmonics
    from flatland.harmonics.spherical import SphericalHarmonics

    bases: dict[int, type[AngularBasis]] = {2: CircularHarmonics, 3: SphericalHarmonics}
    if dimension not in bases:
        raise bad_input("dimension", dimension, "no angular basis", bases)
    return bases[dimension](bands)
