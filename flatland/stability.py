"""Von Neumann stability: the largest factor by which a step multiplies any wave of light."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from flatland.harmonics import AngularBasis

Array = NDArray[np.float64]
Offsets = NDArray[np.int64]

#: A radius this close to 1 is rounding, not growth: 10^5 steps gain less than 10^-4.
RADIUS_TOLERANCE = 1e-9
#: Singular values of a scheme below this share of the largest are rounding.
_RANK = 1e-13
#: Samples of the zone times matrix size^2.5 (eigenvalues cost about size^3): half a second.
_BUDGET = 1e6
#: Samples per half axis at most.
_FINEST = 24
#: Peaks that are climbed at most; those this far below the best sample are not.
_PEAKS, _WITHIN_REACH = 3, 0.9


def spectral_radius(basis: AngularBasis, offsets: Offsets, transfer: Array) -> float:
    """max over k of the largest |eigenvalue| of A(k) = Σ_d T_d exp(−i k·d).

    Samples a grid of wave vectors that holds all corners and edge middles of the Brillouin zone,
    then climbs from the best ones. Of a scheme with all symmetries of the square or the cube, the
    irreducible wedge π ≥ k₁ ≥ k₂ (≥ k₃) ≥ 0 is enough. Accurate to about 1e-9 for smooth maxima;
    a peak narrower than the samples' distance, π/12 in 3D with 26 neighbours, could be missed.
    """
    if _all_semidefinite(transfer):
        # |x*A(k)y| ≤ Σ_d |x*T_d y| ≤ ‖Σ_d T_d‖ by Cauchy–Schwarz, reached at k = 0.
        return float(np.linalg.eigvalsh(transfer.sum(axis=0)).max())
    small = compressed(transfer)

    def radius_at(waves: Array) -> Array:
        eigenvalues = np.linalg.eigvals(symbol(offsets, small, waves))
        return np.asarray(np.abs(eigenvalues).max(axis=-1))

    symmetric = has_grid_symmetry(basis, offsets, transfer)
    samples, step = _wave_vectors(basis.dimension, small.shape[-1], symmetric)
    values = radius_at(samples)
    starts = _peaks(samples, values, step)
    return max([float(values.max()), *(_climb(radius_at, start, step) for start in starts)])


def symbol(offsets: Offsets, transfer: Array, waves: NDArray[np.inexact]) -> NDArray[np.complex128]:
    """A(k) = Σ_d T_d exp(−i k·d), (..., size, size), at k (..., dimension) [rad per cell].

    Waves may be complex: they then grow along one way and fade along the other.
    """
    phases = np.exp(-1j * (waves @ offsets.T))
    return np.tensordot(phases, transfer.astype(complex), axes=(-1, 0))


def compressed(transfer: Array) -> Array:
    """Smaller matrices (K, r, r) whose every combination has the same non-zero eigenvalues.

    With U an orthonormal basis of what the T_d (K, size, size) can write together, A = U UᵀA has
    those of UᵀAU; the same for what they can read. Lobes along six axes leave r = 6 of any size.
    """
    for axes in ((1, 0, 2), (2, 0, 1)):
        size = transfer.shape[-1]
        vectors, values, _ = np.linalg.svd(
            transfer.transpose(axes).reshape(size, -1), full_matrices=False
        )
        rank = max(1, int(np.count_nonzero(values > _RANK * values[0])))
        transfer = vectors[:, :rank].T @ transfer @ vectors[:, :rank]
    return transfer


def has_grid_symmetry(basis: AngularBasis, offsets: Offsets, transfer: Array) -> bool:
    """Whether turning or mirroring light, then stepping, is stepping, then turning: to 1e-11."""
    size = np.abs(transfer).max(initial=0.0)
    number = {tuple(offset): d for d, offset in enumerate(offsets.tolist())}
    for turn in _generators(basis.dimension):
        turned = [tuple(offset) for offset in (offsets @ turn.T).tolist()]
        if not all(offset in number for offset in turned):
            return False
        mixing = _representation(basis, turn.tobytes())
        images = transfer[[number[offset] for offset in turned]]
        if np.abs(mixing @ transfer - images @ mixing).max() > 1e-11 * size:
            return False
    return True


def _generators(dimension: int) -> list[Offsets]:
    """Matrices whose products are all symmetries of the square or the cube."""
    mirror = np.diag([-1] + [1] * (dimension - 1))
    swap = np.eye(dimension, dtype=int)[[1, 0, *range(2, dimension)]]
    shift = np.roll(np.eye(dimension, dtype=int), 1, axis=0)
    return [mirror, swap, shift]


@cache
def _representation(basis: AngularBasis, turn: bytes) -> Array:
    """Coefficients of S(g⁻¹ω) from those of S(ω), (size, size)."""
    matrix = np.frombuffer(turn, int).reshape(basis.dimension, basis.dimension)
    directions, weights = basis.quadrature(2 * basis.bands)
    return (basis.evaluate(directions).T * weights) @ basis.evaluate(directions @ matrix)


def _all_semidefinite(transfer: Array) -> bool:
    symmetric = np.abs(transfer - transfer.swapaxes(1, 2)).max() < 1e-14
    return bool(symmetric and np.linalg.eigvalsh(transfer).min() > -1e-14)


def _wave_vectors(dimension: int, size: int, symmetric: bool) -> tuple[Array, float]:
    """Samples of the wedge, or of half the zone since A(−k) is the conjugate of A(k); and step."""
    share = math.factorial(dimension) if symmetric else 1 / 2 ** (dimension - 1)
    per_half_axis = (share * _BUDGET / size**2.5) ** (1 / dimension)
    count = int(np.clip(per_half_axis, 4, _FINEST)) // 4 * 4
    step = np.pi / count
    if symmetric:
        places = list(itertools.combinations_with_replacement(range(count, -1, -1), dimension))
    else:
        axes = [range(count + 1), *[range(-count, count)] * (dimension - 1)]
        places = list(itertools.product(*axes))
    return step * np.array(places), step


def _peaks(samples: Array, values: Array, step: float) -> list[Array]:
    """The best samples, no two of them neighbours, that a climb could lift to the top."""
    chosen: list[Array] = []
    for i in np.argsort(-values, kind="stable"):
        if len(chosen) == _PEAKS or values[i] < _WITHIN_REACH * values.max():
            break
        if all(np.abs(samples[i] - other).max() > 1.5 * step for other in chosen):
            chosen.append(samples[i])
    return chosen


def _climb(radius_at: Callable[[Array], Array], start: Array, step: float) -> float:
    """The radius at the top of a peak that begins within a step of `start`."""
    from scipy.optimize import minimize  # a sixth of a second: only where needed

    around = np.array(list(itertools.product((0.0, 1e-3, -1e-3), repeat=start.size)))
    values = radius_at(start + step * around)
    if values[0] >= values.max() - 1e-12:  # as at points of symmetry, where most maxima lie
        return float(values.max())
    simplex = start + 0.5 * step * np.vstack([np.zeros(start.size), np.eye(start.size)])
    options = {"initial_simplex": simplex, "xatol": 1e-6, "fatol": 1e-12, "maxiter": 100}
    found = minimize(
        lambda wave: -radius_at(wave[None])[0], start, method="Nelder-Mead", options=options
    )
    return float(-found.fun)
