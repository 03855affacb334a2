"""Several grids over one scene, each with cells twice as large as the one before (numerics §7)."""

from flatland.octree.downsampling import halved, spread
from flatland.octree.grids import level_grids, most_levels
from flatland.octree.index import INDEX_STRATEGIES, level_index
from flatland.octree.merging import blended, merged, require_width
from flatland.octree.octree import Octree
from flatland.octree.rules import NORMALIZATIONS, LevelRules

__all__ = [
    "INDEX_STRATEGIES",
    "NORMALIZATIONS",
    "LevelRules",
    "Octree",
    "blended",
    "halved",
    "level_grids",
    "level_index",
    "merged",
    "most_levels",
    "require_width",
    "spread",
]
