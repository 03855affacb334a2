"""All lights of a scene into one field."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular

from flatland.field import Field
from flatland.harmonics import AngularBasis
from flatland.injectors import Injector
from flatland.injectors.base import require_basis
from flatland.memory import require_memory
from flatland.scene import Scene

Array = NDArray[np.float64]

#: A colour channel is a mix of others if that gives it to this part of its own size.
DEPENDENCE = 1e-12


def inject(scene: Scene, basis: AngularBasis) -> Field:
    """The light of a scene before its first step: (size, *shape), or (colours, size, *shape).

    Carries exactly the flux of the lights. Raises InputError for a basis of the wrong dimension
    and for a field that would not fit into memory.
    """
    spectra = _spectra(scene)
    values = _superpose(scene, basis, scene.lights, spectra)
    return Field(scene.grid, basis, values if scene.colours else values[0])


def independent_spectra(scene: Scene, basis: AngularBasis) -> tuple[Array, Array]:
    """The injected field as few patterns: values[colour] = Σ_k mixing[colour, k] patterns[k].

    Returns patterns (K, size, *shape) and mixing (max(1, colours), K), K ≥ 1. Whatever is linear
    can be computed once per pattern. The patterns are the fields of K colour channels; every
    other channel is a mix of these, to DEPENDENCE. K = 1 if all lights are grey or proportional
    to each other. Holds for the light alone: coloured walls that reflect mix channels on the way.
    """
    spectra = _spectra(scene)
    chosen, mixing = factor_spectra(spectra)
    return _superpose(scene, basis, scene.lights, spectra[:, chosen]), mixing


def factor_spectra(spectra: Array) -> tuple[NDArray[np.int64], Array]:
    """Columns to keep (K,) and mixing (colours, K), spectra ≈ spectra[:, kept] @ mixing.T.

    spectra: (lights, colours). Pivoted QR of columns scaled to length 1, so that a faint channel
    counts as much as a bright one. K is at least 1.
    """
    lengths = np.linalg.norm(spectra, axis=0)
    lengths[lengths == 0] = 1.0
    triangle, order = _pivoted_triangle(spectra / lengths)
    diagonal = np.abs(np.diagonal(triangle))
    rank = max(1, int(np.count_nonzero(diagonal > DEPENDENCE)))
    mixing = np.zeros((spectra.shape[1], rank))
    mixing[order[:rank]] = np.eye(rank)
    if diagonal.size and diagonal[0] > 0:
        rest = solve_triangular(triangle[:rank, :rank], triangle[:rank, rank:])
        scale = lengths[order[rank:], None] / lengths[order[:rank]]
        mixing[order[rank:]] = rest.T * scale
    ascending = np.argsort(order[:rank])
    return order[:rank][ascending], mixing[:, ascending]


def _pivoted_triangle(matrix: Array) -> tuple[Array, NDArray[np.int64]]:
    """R and the column order of a pivoted QR; a matrix without rows has an empty R."""
    if not matrix.shape[0]:
        return np.zeros((0, matrix.shape[1])), np.arange(matrix.shape[1])
    triangle, order = qr(matrix, mode="r", pivoting=True)
    return triangle, order


def _spectra(scene: Scene) -> Array:
    """Strength of each light in each channel, (lights, max(1, colours))."""
    colours = scene.colours
    rows = [light.channels(colours) for light in scene.lights]
    return np.array(rows).reshape(len(rows), max(1, colours))


def _superpose(
    scene: Scene, basis: AngularBasis, lights: Sequence[Injector], weights: Array
) -> Array:
    """Σ over lights of weights[light, k] times its pattern, (K, size, *shape)."""
    grid = scene.grid
    require_basis(basis, grid)
    shape = (weights.shape[1], basis.size, *grid.shape)
    require_memory(8 * math.prod(shape), "bands", basis.bands)
    values = np.zeros(shape)
    for light, row in zip(lights, weights):
        cells, coefficients = light.deposit(grid, basis)
        values[(slice(None), slice(None), *cells)] += row[:, None, None] * coefficients.T
    return values
