"""What lit surfaces send back: the first bounce."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from flatland.shadow_map.budget import LightBudget
from flatland.shadow_map.maps import ShadowMap
from flatland.sources import Wall

Array = NDArray[np.float64]

#: Factor per lit piece (K,) on its flux, by name. "exact": the flux of a texel already holds the
#: cosine of the surface, Φ_o = albedo · flux received (numerics §4; the octree thesis, 3.3).
#: "lpv2009": times the cosine once more, as Kaplanyan 2009 weights texels and Kirsch 2010 writes in
#: equation 7; too dark by that cosine, kept for comparison.
WEIGHTS: dict[str, Callable[[ShadowMap], Array]] = {
    "exact": lambda shadow_map: np.ones_like(shadow_map.cosines),
    "lpv2009": lambda shadow_map: shadow_map.cosines,
}


def reflected_flux(
    shadow_map: ShadowMap, walls: Sequence[Wall], strength: Array, weight: str = "exact"
) -> Array:
    """Flux (K, C) [W] that each lit piece reflects; strength (C,) of the light per colour."""
    share = WEIGHTS[weight](shadow_map) * shadow_map.received
    albedo = albedo_table(walls, strength.size)[shadow_map.walls]
    return np.asarray(share[:, None] * albedo * strength)


def albedo_table(walls: Sequence[Wall], colours: int) -> Array:
    """Albedo (walls, C) of each wall."""
    rows = [np.broadcast_to(wall.albedo, colours) for wall in walls]
    return np.array(rows, float).reshape(-1, colours)


def light_budget(shadow_map: ShadowMap, walls: Sequence[Wall], strength: Array) -> LightBudget:
    """The books of a lamp of strength (C,) per colour."""
    received = float(shadow_map.received.sum()) * strength
    reflected = reflected_flux(shadow_map, walls, strength).sum(axis=0)
    escaped = shadow_map.escaped * strength
    return LightBudget(shadow_map.emitted * strength, received, received - reflected, escaped)
