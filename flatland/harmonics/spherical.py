"""Real spherical harmonics: the angular basis in 3D."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaln

from flatland.harmonics.base import Array
from flatland.harmonics.spherical_polygons import PolygonIntegrals


class SphericalHarmonics(PolygonIntegrals):
    """Real spherical harmonics with the Condon–Shortley phase, bands² coefficients.

    Index l² + l + m. The first four are 1/(2√π), −√3/(2√π) y, √3/(2√π) z, −√3/(2√π) x
    (Kirsch 2010, eq. 8–11; the octree thesis' eq. 7 and Kaplanyan 2009 drop the signs).
    """

    dimension = 3
    total_angle = 4 * np.pi

    @property
    def size(self) -> int:
        return self.bands**2

    @property
    def degrees(self) -> NDArray[np.int64]:
        return np.floor(np.sqrt(np.arange(self.size))).astype(np.int64)

    @property
    def orders(self) -> NDArray[np.int64]:
        """Order m of each coefficient, (size,)."""
        return np.arange(self.size) - self.degrees * (self.degrees + 1)

    def evaluate(self, directions: ArrayLike) -> Array:
        """Polynomials in x, y, z, band by band: no angles, so that poles are nothing special.

        y_l0 = Π_l0(z) and y_lm = √2 Π_l|m|(z) times Re (x + iy)^m, for m < 0 Im (x + iy)^|m|.
        """
        unit = self._unit(directions, "directions")
        unit = unit / np.linalg.norm(unit, axis=-1, keepdims=True)
        around = np.ones((*unit.shape[:-1], self.bands), complex)
        around[..., 1:] = unit[..., :1] + 1j * unit[..., 1:2]
        around = np.cumprod(around, axis=-1)
        result = np.empty((*unit.shape[:-1], self.size))
        for degree, legendre in enumerate(_legendre(unit[..., 2:], self.bands)):
            middle = degree * (degree + 1)
            waves = np.sqrt(2.0) * legendre[..., 1:] * around[..., 1 : degree + 1]
            result[..., middle] = legendre[..., 0]
            result[..., middle + 1 : middle + degree + 1] = waves.real
            result[..., middle - degree : middle] = waves.imag[..., ::-1]
        return result

    def clamped_cosine(self, normals: ArrayLike) -> Array:
        """Zonal coefficients turned towards n: f_lm = √(4π/(2l+1)) z_l y_lm(n) (numerics §2)."""
        degree = self.degrees
        zonal = zonal_clamped_cosine(self.bands)
        return np.sqrt(4 * np.pi / (2 * degree + 1)) * zonal[degree] * self.evaluate(normals)

    def quadrature(self, degree: int) -> tuple[Array, Array]:
        """Product rule: Gauss–Legendre in z, uniform in azimuth; exact up to `degree`."""
        z, z_weight = np.polynomial.legendre.leggauss(degree // 2 + 1)
        count = degree + 1
        azimuth = (np.arange(count) + 0.5) * (2 * np.pi / count)
        radius = np.sqrt(1 - z**2)[:, None]
        directions = np.stack(
            [radius * np.cos(azimuth), radius * np.sin(azimuth), np.repeat(z[:, None], count, 1)],
            axis=-1,
        )
        weights = np.repeat(z_weight[:, None], count, 1) * (2 * np.pi / count)
        return directions.reshape(-1, 3), weights.ravel()


def _legendre(z: Array, bands: int) -> Iterator[Array]:
    """Π_lm(z) for z (..., 1), shape (..., l + 1), one l after another.

    The normalised associated Legendre functions with the Condon–Shortley sign, over sin^m θ:
    Π_mm = −√((2m+1)/2m) Π_{m−1,m−1} and Π_lm = a_lm (z Π_{l−1,m} − b_lm Π_{l−2,m}).
    """
    zero = np.zeros_like(z)
    older, newer = zero, zero + 1 / np.sqrt(4 * np.pi)
    yield newer
    for degree in range(1, bands):
        a, b = _legendre_factors(degree)
        diagonal = -np.sqrt((2 * degree + 1) / (2 * degree)) * newer[..., -1:]
        following = np.concatenate([a * (z * newer - b * older), diagonal], axis=-1)
        older, newer = np.concatenate([newer, zero], axis=-1), following
        yield newer


@cache
def _legendre_factors(degree: int) -> tuple[Array, Array]:
    """a_lm and b_lm of the recurrence in l, m = 0 … l − 1."""
    square, below, m = degree**2, (degree - 1) ** 2, np.arange(degree) ** 2
    a = np.sqrt((4 * square - 1) / (square - m))
    return a, np.sqrt(np.maximum(below - m, 0) / np.abs(4 * below - 1))


def zonal_clamped_cosine(bands: int) -> Array:
    """Coefficients z_l (bands,) of max(0, cos θ): √π/2, √(π/3), then even l only.

    z_l = √(π(2l+1)) ∫₀¹ t P_l(t) dt, and for even l the integral is
    (−1)^{l/2−1} l! / (2^l ((l/2)!)² (l−1)(l+2)); it vanishes for odd l > 1.
    """
    degree = np.arange(bands)
    half = degree // 2
    size = np.exp(gammaln(degree + 1) - degree * np.log(2) - 2 * gammaln(half + 1))
    # (l-1) is -1 at l = 0 and turns the sign there, so one expression serves all even l.
    integral = (
        np.where(half % 2 == 1, 1.0, -1.0) * size / ((degree - 1 + (degree == 1)) * (degree + 2))
    )
    integral = np.where(degree % 2 == 1, np.where(degree == 1, 1 / 3, 0.0), integral)
    return np.sqrt(np.pi * (2 * degree + 1)) * integral
