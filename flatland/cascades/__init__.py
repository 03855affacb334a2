"""Nested grids of equal size round a focus, with cells that double (numerics §8)."""

from flatland.cascades.cascade import Cascade
from flatland.cascades.grids import cascade_grids, most_cascade_levels

__all__ = ["Cascade", "cascade_grids", "most_cascade_levels"]
