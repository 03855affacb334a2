"""How far light spreads in a medium: moments of the flux that collides, from a scheme's symbol.

An isotropic pulse of unit flux in an endless medium gives the density of collisions K(x). Its
Fourier transform K(k) is known for every linear scheme; its Taylor coefficients in |k| are the
moments m_0 = Σ K, r2 = Σ |x|² K and r4 = Σ |x|⁴ K. In truth, in 2D, with φ(k) = 1/√(1 + k²/σ²) the
transform of one flight, K(k) = φ/(1 - c φ) (numerics §13).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.medium import collision_probability

if TYPE_CHECKING:
    from flatland.medium_step import MediumStep

Array = NDArray[np.float64]
Waves = NDArray[np.complex128]

#: Points of the circle on which Taylor coefficients are found, and directions of k.
_POINTS, _DIRECTIONS = 16, 8
#: Radius of that circle as a share of the distance to the nearest pole of the exact transform.
_WITHIN = 0.1
#: And no longer than this [1 / cell]: what a step does to a wave grows with e^|k|.
_LONGEST = 0.5
#: Collisions a cell below which a ratio is taken as here; digits would be lost, not gained.
THIN = 1e-4


class Moments(NamedTuple):
    """m0, and r2 and r4 in squares and fourth powers of the cells that k is given in."""

    m0: float
    r2: float
    r4: float


def moments_of(response: Callable[[Waves], Waves], radius: float) -> Moments:
    """Moments of a density with the transform K(k) at waves k (M, 2) [1 / cell], any complex.

    radius: of the circle in the complex plane, small against the nearest pole. By Cauchy's
    integral with 16 points, averaged over 8 directions.
    """
    turns = radius * np.exp(2j * np.pi * np.arange(_POINTS) / _POINTS)
    angles = np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS + 0.1
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    waves = (directions[:, None] * turns[:, None]).reshape(-1, 2)
    values = response(waves).reshape(_DIRECTIONS, _POINTS).mean(axis=0)
    powers = _taylor(values, radius)
    # Over directions (u·x)² has the mean r²/2 and (u·x)⁴ the mean 3 r⁴/8.
    return Moments(float(powers[0].real), float(-4 * powers[2].real), float(64 * powers[4].real))


def exact_moments(optical_length: float, albedo: float) -> Moments:
    """The truth for σ_t h = optical_length, from K = φ/(1 - c φ), φ = (1 + k²/σ²)^(-1/2)."""
    sigma, c = optical_length, albedo
    m0, r2 = 1 / (1 - c), 2 / (sigma * (1 - c)) ** 2
    # φ = 1 - u/2 + 3u²/8, u = (k/σ)²: K = φ/(1 - cφ) to u².
    r4 = 64 * ((3 / 8) / (1 - c) ** 2 + c / (4 * (1 - c) ** 3)) / sigma**4
    return Moments(m0, r2, r4)


def step_moments(step: MediumStep) -> Moments:
    """Moments of a stencil's collisions in a medium of albedo below 1, in 2D, in cells."""
    reach = (1 - step.medium.albedo) * step.optical
    return moments_of(lambda waves: _collisions(step, waves), _radius(reach))


def spread_ratio(step: MediumStep) -> float:
    """r2 over the exact one; the same for every albedo, and in 3D as in 2D.

    Found for albedo 0, where light makes one flight, and r2 is its mean square length, 2/σ².
    """
    if step.optical < THIN:
        x = -np.log1p(-step.probability) * (THIN / step.optical)
        step = replace(step, optical=THIN, probability=collision_probability(x))
    passing = (1 - step.probability)[:, None, None] * step.vacuum.transfer
    black = replace(
        step,
        medium=replace(step.medium, albedo=0.0),
        stencil=replace(step.vacuum, transfer=passing),
        behind=np.zeros_like(step.behind),
    )
    dimension, radius = step.vacuum.basis.dimension, _radius(step.optical)
    turns = radius * np.exp(2j * np.pi * np.arange(_POINTS) / _POINTS)
    waves = (np.eye(dimension)[:, None] * turns[:, None]).reshape(-1, dimension)
    values = _collisions(black, waves).reshape(dimension, _POINTS).sum(axis=0)
    return float(-_taylor(values, radius)[2].real * step.optical**2)


def _radius(reach: float) -> float:
    return min(_WITHIN * reach, _LONGEST)


def _collisions(step: MediumStep, waves: Waves) -> Waves:
    """K(k) = r (1 - A)⁻¹ e_0, r(k) = Σ_d p_d (1 - b_d + b_d e^(-ik·d)) T_d[0, :] of the vacuum."""
    vacuum, p, b = step.vacuum, step.probability, step.share
    phases = np.exp(-1j * (waves @ vacuum.offsets.T))
    received = (p * ((1 - b) + b * phases)) @ vacuum.transfer[:, 0, :]
    start = np.zeros((len(waves), vacuum.basis.size, 1), complex)
    start[:, 0] = 1.0
    sent = np.linalg.solve(np.eye(vacuum.basis.size) - step.symbol(waves), start)
    return np.asarray(np.einsum("mk,mk->m", received, sent[:, :, 0]))


def _taylor(values: Waves, radius: float) -> Waves:
    """Coefficients from values on a circle, from radius on counter-clockwise."""
    return np.asarray(np.fft.fft(values) / values.size / radius ** np.arange(values.size))
