"""Circular harmonics: the Fourier basis on the circle of directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.harmonics.base import AngularBasis, Array


class CircularHarmonics(AngularBasis):
    """1/√(2π), then cos(mθ)/√π, sin(mθ)/√π for m = 1 … bands - 1: 2 bands - 1 coefficients.

    θ is measured from +x, counter-clockwise. Orthonormal over the circle.
    """

    dimension = 2
    total_angle = 2 * np.pi

    @property
    def size(self) -> int:
        return 2 * self.bands - 1

    @property
    def degrees(self) -> NDArray[np.int64]:
        return (np.arange(self.size) + 1) // 2

    def evaluate(self, directions: ArrayLike) -> Array:
        unit = self._unit(directions, "directions")
        return self.evaluate_angles(np.arctan2(unit[..., 1], unit[..., 0]))

    def evaluate_angles(self, angles: ArrayLike) -> Array:
        """Basis functions (..., size) at angles (...) [rad]."""
        theta = np.asarray(angles, float)[..., None] * np.arange(1, self.bands)
        return self._interleave(
            np.full(theta.shape[:-1], 1 / np.sqrt(2 * np.pi)),
            np.cos(theta) / np.sqrt(np.pi),
            np.sin(theta) / np.sqrt(np.pi),
        )

    def clamped_cosine(self, normals: ArrayLike) -> Array:
        """Closed form (numerics §2): √(2/π); (√π/2) for m = 1; 2(−1)^{m/2+1}/((m²−1)√π), m even."""
        unit = self._unit(normals, "normals")
        angles: Array = np.asarray(np.arctan2(unit[..., 1], unit[..., 0]))
        theta = angles[..., None] * np.arange(1, self.bands)
        amplitude = clamped_cosine_amplitudes(self.bands)
        return self._interleave(
            np.full(theta.shape[:-1], np.sqrt(2 / np.pi)),
            amplitude * np.cos(theta),
            amplitude * np.sin(theta),
        )

    def arc_integral(self, start: ArrayLike, stop: ArrayLike) -> Array:
        """∫ y(θ) dθ from angle start to stop [rad], shapes (...) to (..., size); signed."""
        a, b = np.broadcast_arrays(np.asarray(start, float), np.asarray(stop, float))
        m = np.arange(1, self.bands)
        # sin(mb) - sin(ma) and its twin as products: no cancellation for short arcs.
        half, middle = (b - a)[..., None] * m / 2, (a + b)[..., None] * m / 2
        chord = 2 * np.sin(half) / (m * np.sqrt(np.pi))
        return self._interleave(
            (b - a) / np.sqrt(2 * np.pi), chord * np.cos(middle), chord * np.sin(middle)
        )

    def cosine_arc_integral(self, starts: ArrayLike, stops: ArrayLike, angle: float) -> Array:
        """∫ cos(θ - angle) y(θ) dθ from angle start to stop [rad], shapes (...) to (..., size).

        cos(θ - φ) e^{imθ} = (e^{-iφ} e^{i(m+1)θ} + e^{iφ} e^{i(m-1)θ}) / 2.
        """
        a, b = np.broadcast_arrays(np.asarray(starts, float), np.asarray(stops, float))
        orders = np.arange(-1, self.bands + 1)
        half, middle = (b - a)[..., None] / 2, (a + b)[..., None] / 2
        powers = 2 * half * np.sinc(half * orders / np.pi) * np.exp(1j * middle * orders)
        turn = np.exp(1j * angle)
        moments = 0.5 * (powers[..., 2:] / turn + powers[..., :-2] * turn)
        return self._interleave(
            moments[..., 0].real / np.sqrt(2 * np.pi),
            moments[..., 1:].real / np.sqrt(np.pi),
            moments[..., 1:].imag / np.sqrt(np.pi),
        )

    def arc_gram(self, start: float, stop: float) -> Array:
        """∫ y yᵀ dθ over an arc, (size, size).

        Restricts an intensity to the arc and projects it again. Exact: products of harmonics
        are harmonics of twice the bands.
        """
        double = CircularHarmonics(2 * self.bands - 1)
        integral = double.arc_integral(start, stop)
        cosine = np.concatenate(
            [[integral[0] * np.sqrt(2 * np.pi)], integral[1::2] * np.sqrt(np.pi)]
        )
        sine = np.concatenate([[0.0], integral[2::2] * np.sqrt(np.pi)])
        m = self.degrees
        is_sine = (np.arange(self.size) % 2 == 0) & (m > 0)
        total, difference = m[:, None] + m, m[:, None] - m
        cos_sum, cos_difference = cosine[total], cosine[np.abs(difference)]
        sin_sum, sin_difference = sine[total], np.sign(difference) * sine[np.abs(difference)]
        gram = 0.5 * (cos_difference + cos_sum)  # cos cos
        both = is_sine[:, None] & is_sine
        gram = np.where(both, 0.5 * (cos_difference - cos_sum), gram)
        gram = np.where(is_sine[:, None] & ~is_sine, 0.5 * (sin_sum + sin_difference), gram)
        gram = np.where(~is_sine[:, None] & is_sine, 0.5 * (sin_sum - sin_difference), gram)
        norm = np.sqrt(np.pi * (1.0 + (m == 0)))
        return np.asarray(gram / np.multiply.outer(norm, norm))

    def quadrature(self, degree: int) -> tuple[Array, Array]:
        count = 2 * (degree // 2 + 1)
        angles = (np.arange(count) + 0.5) * (2 * np.pi / count)
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        return directions, np.full(count, 2 * np.pi / count)

    def _interleave(self, constant: Array, cosines: Array, sines: Array) -> Array:
        result = np.empty((*np.shape(constant), self.size))
        result[..., 0] = constant
        result[..., 1::2] = cosines
        result[..., 2::2] = sines
        return result


def clamped_cosine_amplitudes(bands: int) -> Array:
    """Amplitude of cos(m(θ - θ₀)), m = 1 … bands - 1, in the clamped cosine, times √π."""
    m = np.arange(1, bands)
    amplitude = np.zeros(m.size)
    amplitude[m == 1] = np.sqrt(np.pi) / 2
    even = m % 2 == 0
    amplitude[even] = 2.0 * (-1.0) ** (m[even] // 2 + 1) / ((m[even] ** 2 - 1.0) * np.sqrt(np.pi))
    return amplitude
