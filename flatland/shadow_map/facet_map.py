"""Shadow maps in 3D: a light's view of the scene as lit patches of facets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.grid import Grid
from flatland.memory import require_memory
from flatland.shadow_map.convex import Polygons, measure
from flatland.shadow_map.facet_views import FacetView, parallel_view, point_views
from flatland.shadow_map.maps import CellShares, ShadowMap
from flatland.shadow_map.outlines import outlines_in
from flatland.shadow_map.patches import cut_by_cells
from flatland.shadow_map.visible import visible_polygons
from flatland.sources import Facet, PolygonSource

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Fewest tiles along a side of a map: fewer would hold too many facets each. Texels are cut in so
#: many tiles that there are as many; only the cost depends on it.
FEWEST_TILES = 32
#: What a tile takes while a map is made, if it shows one facet before one cell.
BYTES_PER_TILE = 400
#: Tiles along a side of the map that sources are made of: shadows are cut exactly in any case, and
#: each tile border may cut a source in two.
SOURCE_TILES = 8
#: Parts of a cell's side that sources are cut at: half a cell, as in 2D.
SOURCE_PARTS = 2


#: Of all flux: patches with less are rounding, and no surfaces to be made sources of.
SLIVER = 1e-14


@dataclass(frozen=True, eq=False)
class FacetMap(ShadowMap):
    """K lit patches of facets, each in one texel and before one cell.

    centres: (K, 3) [m]. cells: (K, 3), where a patch lies once it is moved half a cell along its
    normal; may be outside the grid. views: what the light sees through each window, from which
    the map was made. loops: corners (V, 3) [m] of each patch, counter-clockwise seen from the
    light; of a `source_map` only.
    """

    grid: Grid
    centres: Array
    cells: Indices
    views: Sequence[FacetView]
    loops: Sequence[Array] = ()

    @property
    def positions(self) -> Array:
        return self.centres

    def cell_shares(self, chosen: Indices, flux: Array, grid: Grid) -> CellShares:
        """Exact per facet and cell: patches are cut where the moved facet crosses cell borders."""
        chosen = chosen[
            np.all((self.cells[chosen] >= 0) & (self.cells[chosen] < grid.shape), axis=1)
        ]
        place = np.ravel_multi_index(tuple(self.cells[chosen].T), grid.shape)
        # A facet is lit from one side alone, so it has one normal.
        key = self.walls[chosen] * grid.cell_count + place
        _, first, group = np.unique(key, return_index=True, return_inverse=True)
        shares = np.bincount(group.ravel(), flux[chosen], len(first)).astype(float)
        return CellShares(self.cells[chosen[first]], shares, self.normals[chosen[first]])

    def source_map(self) -> FacetMap:
        """In few texels, and patches of about half a cell."""
        parts = [
            _seen_through(self.grid, view, SOURCE_TILES, parts=SOURCE_PARTS) for view in self.views
        ]
        return _joined(self.grid, self.views, parts, SOURCE_TILES, self.emitted)

    def sources(self, flux: Array, grid: Grid) -> list[PolygonSource]:
        """One polygon per patch, its front to the light."""
        kept = np.any(flux > SLIVER * flux.sum(axis=0), axis=1)
        pieces = zip(self.loops, flux, kept)
        return [PolygonSource(loop, spectrum) for loop, spectrum, lit in pieces if lit]


def map_facets_round(grid: Grid, walls: Sequence[Facet], position: Array, texels: int) -> FacetMap:
    """The full sphere round a position (3,) [m]: six faces of a cube, texels x texels each.

    received is Ω/4π: exact solid angles, where the octree thesis, 3.3, has the midpoint rule
    4 cos³θ tan²(FOV/2)/(N_x N_y).
    """
    views = point_views(outlines_in(grid, walls), grid.to_cells(position))
    return _mapped(grid, views, texels, 1.0)


def map_facets_along(grid: Grid, walls: Sequence[Facet], direction: Array, texels: int) -> FacetMap:
    """texels x texels across the grid, along a unit vector (3,) that light travels along.

    received is an area [m²] across the light, which holds the cosine of the surface. Light comes in
    through the grid's border: what stands outside the grid casts no shadow into it.
    """
    faces = np.prod(grid.shape) / np.array(grid.shape)
    emitted = grid.spacing**2 * float(np.abs(direction) @ faces)
    view = parallel_view(outlines_in(grid, walls), direction, grid.shape)
    return _mapped(grid, [view], texels, emitted)


class _Patches(NamedTuple):
    """Lit patches seen through one window, as in FacetMap; texels are counted from 0 in each."""

    normals: Array
    walls: Indices
    texels: Indices
    received: Array
    cosines: Array
    centres: Array
    cells: Indices
    loops: Sequence[Array] = ()


def _seen_through(
    grid: Grid, view: FacetView, texels: int, split: int = 1, parts: int = 1
) -> _Patches:
    """split: tiles along the side of a texel. parts: along the side of a cell."""
    polygons = cut_by_cells(visible_polygons(view, texels * split), view, parts)
    sizes, middles = measure(polygons.vertices, polygons.first, view.angular)
    rows, tiles, cells = polygons.tags[:, 0], polygons.tags[:, 1], polygons.tags[:, 2:]
    across, up = np.divmod(tiles, texels * split)
    rays = np.column_stack([middles, np.ones(len(middles))])
    unit = 1 / (4 * np.pi) if view.angular else grid.spacing**2
    return _Patches(
        view.normals[rows],
        view.facets[rows],
        across // split * texels + up // split,
        unit * np.maximum(sizes, 0.0),
        view.cosines(rows, rays),
        grid.to_world(view.points(rows, rays)),
        cells,
        _loops(grid, view, polygons) if parts > 1 else (),
    )


def _mapped(grid: Grid, views: Sequence[FacetView], texels: int, emitted: float) -> FacetMap:
    split = -(-FEWEST_TILES // texels)
    require_memory(BYTES_PER_TILE * len(views) * (texels * split) ** 2, "texels", texels)
    parts = [_seen_through(grid, view, texels, split) for view in views]
    return _joined(grid, views, parts, texels, emitted)


def _joined(
    grid: Grid,
    views: Sequence[FacetView],
    parts: Sequence[_Patches],
    texels: int,
    emitted: float,
) -> FacetMap:
    """What is seen through all windows, texels counted on from one to the next."""
    numbered = [part._replace(texels=part.texels + k * texels**2) for k, part in enumerate(parts)]
    columns = [np.concatenate(column) for column in list(zip(*numbered))[:-1]]
    normals, walls, numbers, received, cosines, centres, cells = columns
    loops = [loop for part in parts for loop in part.loops]
    return FacetMap(
        normals, walls, numbers, received, cosines, emitted, grid, centres, cells, views, loops
    )


def _loops(grid: Grid, view: FacetView, polygons: Polygons) -> list[Array]:
    """Corners (V, 3) [m] of each patch, counter-clockwise seen from the light."""
    corners = np.column_stack([polygons.vertices, np.ones(len(polygons.vertices))])
    rows = np.repeat(polygons.tags[:, 0], np.diff(polygons.first))
    points = grid.to_world(view.points(rows, corners))
    # In the map patches run counter-clockwise: in a right-handed frame, seen from behind them.
    backwards = np.linalg.det(view.axes) > 0
    loops = np.split(points, polygons.first[1:-1])[: len(polygons.tags)]
    return [loop[::-1] if backwards else loop for loop in loops]
