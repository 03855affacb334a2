"""The first bounce of a lamp: virtual lights of its shadow map into cells, and as sources."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Array, Emission, collect
from flatland.shadow_map import WEIGHTS, ShadowMap, reflected_flux
from flatland.shadow_map.reflection import albedo_table
from flatland.sources import Source, Wall

#: Ratios between colours of an albedo count as the same to this many decimals.
SAME_HUE = 12


def bounce_emissions(
    shadow_map: ShadowMap,
    walls: Sequence[Wall],
    strength: Array,
    weight: str,
    grid: Grid,
    basis: AngularBasis,
) -> list[Emission]:
    """What lit surfaces put into cells, one entry per colour ratio of their albedo.

    strength: (C,), the lamp's. Each lit piece is a Lambertian emitter, moved by half a cell along
    its normal (Kaplanyan & Dachsbacher 2010, section 3.1) and cut at the cell borders, as an area
    light is. What then lies outside the grid is left out: it shines out of it.
    What it gets wrong: as for every light, the place inside the cell is lost.
    """
    albedo = albedo_table(walls, strength.size)
    largest = albedo.max(axis=1)
    hues = albedo / np.where(largest > 0, largest, 1.0)[:, None]
    _, first, group = np.unique(
        np.round(hues, SAME_HUE), axis=0, return_index=True, return_inverse=True
    )
    flux = WEIGHTS[weight](shadow_map) * shadow_map.received * largest[shadow_map.walls]
    number = group.ravel()[shadow_map.walls]
    emissions = []
    for hue, example in enumerate(first):
        chosen = np.flatnonzero((number == hue) & (flux > 0))
        cells, shares, normals = shadow_map.cell_shares(chosen, flux, grid)
        if len(shares):
            lobes = shares[:, None] * basis.lambertian(normals)
            spectrum = hues[example] * strength
            emissions.append(Emission(spectrum, collect(cells.T, lobes, grid.shape)))
    return emissions


def bounce_sources(
    shadow_map: ShadowMap, walls: Sequence[Wall], strength: Array, weight: str, grid: Grid
) -> list[Source]:
    """Lit surfaces as Lambertian segments or polygons of the same flux."""
    pieces = shadow_map.source_map()
    return list(pieces.sources(reflected_flux(pieces, walls, strength, weight), grid))
