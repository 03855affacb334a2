"""The first bounce of a lamp: virtual lights of its shadow map into cells, and as sources."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Array, Emission, collect
from flatland.moved_segments import cells_along
from flatland.shadow_map import WEIGHTS, ShadowMap, reflected_flux
from flatland.shadow_map.reflection import lit_albedo
from flatland.sources import SegmentSource, Wall

#: Ratios between colours of an albedo count as the same to this many decimals.
SAME_HUE = 12
#: Of the length of a source: pieces with a smaller gap touch.
SAME_PLACE = 1e-6
#: Cells. Pieces of a map are joined to sources of at most about this length: a stencil does not
#: resolve more, and an exact method pays for every source.
LONGEST_SOURCE = 0.5


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
    What it gets wrong: within a piece the flux is spread evenly, an error of the second order in
    the width of a texel; as for every light, the place inside the cell is lost.
    """
    albedo = lit_albedo(shadow_map, walls, strength.size)
    largest = albedo.max(axis=1)
    hues = albedo / np.where(largest > 0, largest, 1.0)[:, None]
    _, first, group = np.unique(
        np.round(hues, SAME_HUE), axis=0, return_index=True, return_inverse=True
    )
    flux = WEIGHTS[weight](shadow_map) * shadow_map.received * largest
    emissions = []
    for number, example in enumerate(first):
        chosen = np.flatnonzero((group.ravel() == number) & (flux > 0))
        cells, shares, normals = _cell_shares(shadow_map, chosen, flux, grid)
        if len(shares):
            lobes = shares[:, None] * basis.lambertian(normals)
            spectrum = hues[example] * strength
            emissions.append(Emission(spectrum, collect(cells.T, lobes, grid.shape)))
    return emissions


def bounce_sources(
    shadow_map: ShadowMap, walls: Sequence[Wall], strength: Array, weight: str, grid: Grid
) -> list[SegmentSource]:
    """Lit surfaces as Lambertian segments: the same pieces, neighbours on a wall joined."""
    flux = reflected_flux(shadow_map, walls, strength, weight)
    sources = []
    for pieces in _by_wall(shadow_map, np.flatnonzero(flux.any(axis=1))):
        starts, stops = shadow_map.starts[pieces], shadow_map.stops[pieces]
        for part in _runs(starts, stops, LONGEST_SOURCE * grid.spacing):
            start, stop = starts[part[0]], stops[part[-1]]
            if np.any(start != stop):
                sources.append(SegmentSource(start, stop, flux[pieces[part]].sum(axis=0)))
    return sources


def _by_wall(shadow_map: ShadowMap, chosen: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Those of the chosen pieces that lie on one wall, in order along it; wall by wall."""
    along = np.einsum("kc,kc->k", shadow_map.starts, _along(shadow_map.normals))
    chosen = chosen[np.lexsort((along[chosen], shadow_map.walls[chosen]))]
    changes = np.flatnonzero(np.diff(shadow_map.walls[chosen])) + 1
    yield from np.split(chosen, changes) if chosen.size else []


def _along(normals: Array) -> Array:
    """Directions (K, 2) from start to stop of pieces with normals (K, 2) on their left."""
    return np.stack([normals[:, 1], -normals[:, 0]], axis=1)


def _cell_shares(
    shadow_map: ShadowMap, chosen: NDArray[np.int64], flux: Array, grid: Grid
) -> tuple[NDArray[np.int64], Array, Array]:
    """Cells (M, 2) that chosen pieces light, the flux (M,) in each and its normal (M, 2)."""
    cells, shares, normals = [np.empty((0, 2), np.int64)], [np.empty(0)], [np.empty((0, 2))]
    for pieces in _by_wall(shadow_map, chosen):
        normal = shadow_map.normals[pieces[0]]
        found, amounts = _shares_on_wall(shadow_map, pieces, flux[pieces], grid)
        inside = np.all((found >= 0) & (found < grid.shape), axis=1)
        cells.append(found[inside])
        shares.append(amounts[inside])
        normals.append(np.tile(normal, (int(inside.sum()), 1)))
    return np.concatenate(cells), np.concatenate(shares), np.concatenate(normals)


def _shares_on_wall(
    shadow_map: ShadowMap, pieces: NDArray[np.int64], flux: Array, grid: Grid
) -> tuple[NDArray[np.int64], Array]:
    """Cells (M, 2) in front of one wall's pieces (K,), in order along it, and the flux in each."""
    normal = shadow_map.normals[pieces[0]]
    ends = grid.to_cells([shadow_map.starts[pieces], shadow_map.stops[pieces]])
    outline = np.stack([ends[0, 0], ends[1, -1]])
    cuts, cells = cells_along(outline + 0.5 * normal, normal)
    # Flux up to each end of a piece: rises along pieces, stays where shadows part them.
    along = (ends - outline[0]) @ _along(normal[None])[0]
    places = np.maximum.accumulate(along.T.ravel())
    total = np.cumsum(flux)
    sums = np.stack([total - flux, total], axis=1).ravel()
    return cells, np.diff(np.interp(cuts * places[-1], places, sums))


def _runs(starts: Array, stops: Array, longest: float) -> list[NDArray[np.int64]]:
    """Pieces (K, 2) in order along a wall, as runs without gaps of about `longest` or less."""
    middles = 0.5 * (starts + stops)
    number = np.floor(np.hypot(*(middles - starts[0]).T) / longest)
    gap = np.hypot(*(starts[1:] - stops[:-1]).T) > SAME_PLACE * longest
    breaks = np.flatnonzero(gap | (np.diff(number) != 0)) + 1
    return np.split(np.arange(len(starts)), breaks)
