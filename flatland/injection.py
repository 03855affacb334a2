"""All lights of a scene into one field."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular

from flatland.field import Field
from flatland.grid import Grid, cells_on
from flatland.harmonics import AngularBasis
from flatland.injectors import Emission
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
    emissions = _emissions(scene, basis)
    values = _superpose(scene, basis, emissions, _spectra(scene, emissions))
    return Field(scene.grid, basis, values if scene.colours else values[0])


def independent_spectra(scene: Scene, basis: AngularBasis) -> tuple[Array, Array]:
    """The injected field as few patterns: values[colour] = Σ_k mixing[colour, k] patterns[k].

    Returns patterns (K, size, *shape) and mixing (max(1, colours), K), K ≥ 1. Whatever is linear
    can be computed once per pattern. The patterns are the fields of K colour channels; every
    other channel is a mix of these, to DEPENDENCE. K = 1 if all lights are grey or proportional
    to each other, and so are the walls that lamps bounce off. Holds for what is injected: coloured
    walls that reflect mix channels on the way.
    """
    emissions = _emissions(scene, basis)
    spectra = _spectra(scene, emissions)
    chosen, mixing = factor_spectra(spectra)
    return _superpose(scene, basis, emissions, spectra[:, chosen]), mixing


def spectra_on(
    scene: Scene, basis: AngularBasis, grids: Sequence[Grid], apart: bool = False
) -> tuple[list[Array], Array, Array]:
    """A scene's light on other grids over it, cell by cell where the cells' centres lie.

    Returns patterns (K, size, *shape) per grid, mixing (max(1, colours), K), and what lies outside
    of each grid: flux [W], (grids, K). A pattern and what it leaves out carry the flux of the
    lights. apart: one pattern per colour instead of the independent ones.
    """
    emissions = _emissions(scene, basis)
    spectra = _spectra(scene, emissions)
    if apart:
        chosen, mixing = np.arange(spectra.shape[1]), np.eye(spectra.shape[1])
    else:
        chosen, mixing = factor_spectra(spectra)
    patterns, outside = [], np.zeros((len(grids), mixing.shape[1]))
    for number, grid in enumerate(grids):
        values = np.zeros((mixing.shape[1], basis.size, *grid.shape))
        for emission, row in zip(emissions, spectra[:, chosen]):
            cells, coefficients = emission.deposit
            places, inside = cells_on(scene.grid, cells, grid)
            light = row[:, None, None] * coefficients.T
            np.add.at(values, (slice(None), slice(None), *places[:, inside]), light[..., inside])
            outside[number] += light[:, 0, ~inside].sum(axis=1) * basis.flux_weight
        patterns.append(values)
    return patterns, mixing, outside


def most_spectra(scene: Scene) -> int:
    """An upper limit of the K of `independent_spectra`, without tracing any light.

    Every wall of another colour may add a spectrum to each lamp that it reflects.
    """
    bouncing = sum(light.bounces for light in scene.lights)
    return max(1, min(scene.colours, len(scene.lights) + bouncing * len(scene.occluders)))


def factor_spectra(spectra: Array) -> tuple[NDArray[np.int64], Array]:
    """Columns to keep (K,) and mixing (colours, K), spectra ≈ spectra[:, kept] @ mixing.T.

    spectra: (emissions, colours). Pivoted QR of columns scaled to length 1, so that a faint channel
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


def _emissions(scene: Scene, basis: AngularBasis) -> list[Emission]:
    """What all lights put into cells."""
    require_basis(basis, scene.grid)
    # Before any light is traced: the coefficients alone must fit.
    require_memory(8 * basis.size * scene.grid.cell_count, "bands", basis.bands)
    walls, colours = scene.walls(), scene.colours
    return [
        emission
        for light in scene.lights
        for emission in light.emissions(scene.grid, basis, walls, colours)
    ]


def _spectra(scene: Scene, emissions: Sequence[Emission]) -> Array:
    """Strength of each emission in each channel, (emissions, max(1, colours))."""
    rows = [emission.spectrum for emission in emissions]
    return np.array(rows).reshape(len(rows), max(1, scene.colours))


def _superpose(
    scene: Scene, basis: AngularBasis, emissions: Sequence[Emission], weights: Array
) -> Array:
    """Σ over emissions of weights[emission, k] times its pattern, (K, size, *shape)."""
    shape = (weights.shape[1], basis.size, *scene.grid.shape)
    require_memory(8 * math.prod(shape), "bands", basis.bands)
    values = np.zeros(shape)
    for emission, row in zip(emissions, weights):
        cells, coefficients = emission.deposit
        values[(slice(None), slice(None), *cells)] += row[:, None, None] * coefficients.T
    return values
