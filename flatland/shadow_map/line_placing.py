"""Where the flux of lit segments goes: into cells, and onto sources for exact methods."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from flatland.grid import Grid
from flatland.moved_segments import cells_along
from flatland.shadow_map.maps import CellShares
from flatland.shadow_map.views import Array, Indices
from flatland.sources import SegmentSource

if TYPE_CHECKING:
    from flatland.shadow_map.line_map import LineMap

#: Of the length of a source: pieces with a smaller gap touch.
SAME_PLACE = 1e-6
#: Cells. Pieces of a map are joined to sources of at most about this length: a stencil does not
#: resolve more, and an exact method pays for every source.
LONGEST_SOURCE = 0.5


def cell_shares(shadow_map: LineMap, chosen: Indices, flux: Array, grid: Grid) -> CellShares:
    """See ShadowMap: walls one by one, flux (K,) of the chosen pieces."""
    cells, shares, normals = [np.empty((0, 2), np.int64)], [np.empty(0)], [np.empty((0, 2))]
    for pieces in _by_wall(shadow_map, chosen):
        normal = shadow_map.normals[pieces[0]]
        found, amounts = _shares_on_wall(shadow_map, pieces, flux[pieces], grid)
        inside = np.all((found >= 0) & (found < grid.shape), axis=1)
        cells.append(found[inside])
        shares.append(amounts[inside])
        normals.append(np.tile(normal, (int(inside.sum()), 1)))
    return CellShares(np.concatenate(cells), np.concatenate(shares), np.concatenate(normals))


def segment_sources(shadow_map: LineMap, flux: Array, grid: Grid) -> list[SegmentSource]:
    """Lit surfaces as Lambertian segments of flux (K, C): the same pieces, neighbours joined."""
    sources = []
    for pieces in _by_wall(shadow_map, np.flatnonzero(flux.any(axis=1))):
        starts, stops = shadow_map.starts[pieces], shadow_map.stops[pieces]
        for part in _runs(starts, stops, LONGEST_SOURCE * grid.spacing):
            start, stop = starts[part[0]], stops[part[-1]]
            if np.any(start != stop):
                sources.append(SegmentSource(start, stop, flux[pieces[part]].sum(axis=0)))
    return sources


def _by_wall(shadow_map: LineMap, chosen: Indices) -> Iterator[Indices]:
    """Those of the chosen pieces that lie on one wall, in order along it; wall by wall."""
    along = np.einsum("kc,kc->k", shadow_map.starts, _along(shadow_map.normals))
    chosen = chosen[np.lexsort((along[chosen], shadow_map.walls[chosen]))]
    changes = np.flatnonzero(np.diff(shadow_map.walls[chosen])) + 1
    yield from np.split(chosen, changes) if chosen.size else []


def _along(normals: Array) -> Array:
    """Directions (K, 2) from start to stop of pieces with normals (K, 2) on their left."""
    return np.stack([normals[:, 1], -normals[:, 0]], axis=1)


def _shares_on_wall(
    shadow_map: LineMap, pieces: Indices, flux: Array, grid: Grid
) -> tuple[Indices, Array]:
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


def _runs(starts: Array, stops: Array, longest: float) -> list[Indices]:
    """Pieces (K, 2) in order along a wall, as runs without gaps of about `longest` or less."""
    middles = 0.5 * (starts + stops)
    number = np.floor(np.hypot(*(middles - starts[0]).T) / longest)
    gap = np.hypot(*(starts[1:] - stops[:-1]).T) > SAME_PLACE * longest
    breaks = np.flatnonzero(gap | (np.diff(number) != 0)) + 1
    return np.split(np.arange(len(starts)), breaks)
