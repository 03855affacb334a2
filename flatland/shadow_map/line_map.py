"""Shadow maps in 2D: a light's view of the scene as lit pieces of segments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.grid import Grid
from flatland.shadow_map.clipping import clip_to_grid
from flatland.shadow_map.line_placing import cell_shares, segment_sources
from flatland.shadow_map.maps import CellShares, ShadowMap
from flatland.shadow_map.nearest import nearest_walls
from flatland.shadow_map.views import Array, Indices, View, parallel_view, point_view
from flatland.sources import Segment, SegmentSource


@dataclass(frozen=True, eq=False)
class LineMap(ShadowMap):
    """K lit pieces of segments in map order; starts, stops: (K, 2) [m], the light on the left.

    What `cell_shares` gets wrong: within a piece the flux is spread evenly, an error of the second
    order in the width of a texel.
    """

    starts: Array
    stops: Array

    @property
    def positions(self) -> Array:
        return 0.5 * (self.starts + self.stops)

    def cell_shares(self, chosen: Indices, flux: Array, grid: Grid) -> CellShares:
        return cell_shares(self, chosen, flux, grid)

    def source_map(self) -> LineMap:
        return self

    def sources(self, flux: Array, grid: Grid) -> list[SegmentSource]:
        """Neighbours on a wall are joined to segments of about half a cell."""
        return segment_sources(self, flux, grid)


def map_segments_round(
    grid: Grid, walls: Sequence[Segment], position: Array, texels: int
) -> LineMap:
    """The full circle round a position (2,) [m], in equal arcs from the direction -x on.

    received is Δθ/2π: exact arcs, so a slanted surface needs no cosine (numerics §4).
    """
    ends, index = _walls_in(grid, walls)
    view = point_view(ends, index, grid.to_cells(position), texels)
    return _shadow_map(grid, view, 1 / (2 * np.pi))


def map_segments_along(
    grid: Grid, walls: Sequence[Segment], direction: Array, texels: int
) -> LineMap:
    """Equal strips across the grid, along a unit vector (2,) that light travels along.

    received is a strip's width [m], which holds the cosine of the surface. Light comes in through
    the grid's border: what stands outside the grid casts no shadow into it.
    """
    ends, index = _walls_in(grid, walls)
    view = parallel_view(ends, index, direction, grid.shape, texels)
    return _shadow_map(grid, view, grid.spacing)


def _walls_in(grid: Grid, walls: Sequence[Segment]) -> tuple[Array, Indices]:
    """Parts of walls in the grid (K, 2, 2), in cells, and the place of each."""
    ends = np.array([(wall.start, wall.stop) for wall in walls], float).reshape(-1, 2, 2)
    return clip_to_grid(grid.to_cells(ends), grid.shape)


def _shadow_map(grid: Grid, view: View, unit: float) -> LineMap:
    """unit: flux per key of a light of unit strength."""
    low, high, row = nearest_walls(view)
    lit = row >= 0
    low, high, row = low[lit], high[lit], row[lit]
    middle = 0.5 * (low + high)
    starts, stops = (grid.to_world(_hits(view, row, keys)) for keys in (low, high))
    texels = np.searchsorted(view.borders, middle, side="right") - 1
    emitted = unit * float(view.borders[-1] - view.borders[0])
    received = unit * (high - low)
    cosines = _cosines(view, row, middle)
    normals = _normals(view.ends[row])
    return LineMap(normals, view.walls[row], texels, received, cosines, emitted, starts, stops)


def _hits(view: View, row: Indices, keys: Array) -> Array:
    """Where the rays of keys (K,) meet the walls of rows (K,), (K, 2) [cells].

    An end's pair and a ray are parallel where the ray passes through the end.
    """
    rays = view.rays(keys)[:, None]
    seen = view.seen[row]
    sides = seen[..., 0] * rays[..., 1] - seen[..., 1] * rays[..., 0]
    extent = sides[:, 0] - sides[:, 1]
    safe = np.where(extent == 0, 1.0, extent)
    part = np.clip(sides[:, 0] / safe, 0.0, 1.0)[:, None]
    ends = view.ends[row]
    return np.asarray((1 - part) * ends[:, 0] + part * ends[:, 1])


def _normals(ends: Array) -> Array:
    """Unit vectors (K, 2) to the left of walls (K, 2, 2)."""
    x, y = (ends[:, 1] - ends[:, 0]).T / np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    return np.stack([-y, x], axis=1)


def _cosines(view: View, row: Indices, keys: Array) -> NDArray[np.float64]:
    """|n·ω| on the rays of keys (K,).

    The nearness of a wall at distance d from a point light is n·ω/d; that of a wall in parallel
    light changes by the tangent of the angle per unit of key.
    """
    planes = view.nearness[row]
    if view.angular:
        near = np.einsum("kc,kc->k", planes, view.rays(keys))
        return np.clip(near / np.hypot(*planes.T), 0.0, 1.0)
    return np.asarray(1 / np.hypot(1.0, planes[:, 1]))
