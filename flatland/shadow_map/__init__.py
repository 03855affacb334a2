"""Reflective shadow maps: what a point light or a directional light lights first.

In 2D a map is a row of texels: equal arcs of directions round a point light, equal strips across a
directional one. In 3D it is a square of texels, or six of them on the faces of a cube round a point
light. A texel of an ordinary map looks along one ray. Here each is cut where the first surface
changes, so that it holds exactly the flux that each surface receives, whatever the number of
texels. In 2D that number says how finely flux is placed along a surface; in 3D flux is placed
exactly too, and the number is felt by `lpv2009` alone, whose cosines are those of texels.
"""

from __future__ import annotations

from collections.abc import Sequence

from flatland.grid import Grid
from flatland.shadow_map.budget import LightBudget
from flatland.shadow_map.facet_map import map_facets_along, map_facets_round
from flatland.shadow_map.line_map import map_segments_along, map_segments_round
from flatland.shadow_map.maps import Array, ShadowMap
from flatland.shadow_map.reflection import WEIGHTS, light_budget, reflected_flux
from flatland.sources import Wall, facets_of, segments_of

__all__ = [
    "WEIGHTS",
    "LightBudget",
    "ShadowMap",
    "light_budget",
    "map_directional_light",
    "map_point_light",
    "reflected_flux",
]


def map_point_light(grid: Grid, walls: Sequence[Wall], position: Array, texels: int) -> ShadowMap:
    """What a point light at a position (dimension,) [m] lights first."""
    if grid.dimension == 2:
        return map_segments_round(grid, segments_of(walls), position, texels)
    return map_facets_round(grid, facets_of(walls), position, texels)


def map_directional_light(
    grid: Grid, walls: Sequence[Wall], direction: Array, texels: int
) -> ShadowMap:
    """What light along a unit vector (dimension,) lights first."""
    if grid.dimension == 2:
        return map_segments_along(grid, segments_of(walls), direction, texels)
    return map_facets_along(grid, facets_of(walls), direction, texels)
