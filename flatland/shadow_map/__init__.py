"""Reflective shadow maps in 2D: what a point light or a directional light lights first.

A map is a row of texels: equal arcs of directions round a point light, equal strips across a
directional one. A texel of an ordinary map looks along one ray. Here each is cut where the first
surface changes, so that it holds exactly the flux that each surface receives, whatever the number
of texels; that number only says how finely flux is placed along a surface.
"""

from flatland.shadow_map.budget import LightBudget
from flatland.shadow_map.reflection import WEIGHTS, light_budget, reflected_flux
from flatland.shadow_map.surfels import ShadowMap, map_directional_light, map_point_light

__all__ = [
    "WEIGHTS",
    "LightBudget",
    "ShadowMap",
    "light_budget",
    "map_directional_light",
    "map_point_light",
    "reflected_flux",
]
