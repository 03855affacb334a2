"""Real spherical harmonics: the angular basis in 3D."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaln, sph_harm_y

from flatland.harmonics.base import AngularBasis, Array


class SphericalHarmonics(AngularBasis):
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
        unit = self._unit(directions, "directions")
        # atan2 keeps full accuracy near the poles, where arccos(z) loses half the digits.
        polar = np.arctan2(np.hypot(unit[..., 0], unit[..., 1]), unit[..., 2])[..., None]
        azimuth = np.arctan2(unit[..., 1], unit[..., 0])[..., None]
        order = self.orders
        values = sph_harm_y(self.degrees, np.abs(order), polar, azimuth)
        root = np.sqrt(2.0)
        return np.where(
            order == 0, values.real, root * np.where(order > 0, values.real, values.imag)
        )

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
