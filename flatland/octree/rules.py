"""How an octree is built and read, apart from what is in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.octree.falloff import FALLOFFS
from flatland.octree.grids import level_grids
from flatland.octree.index import INDEX_STRATEGIES

NORMALIZATIONS = ("flux", "mean")


@dataclass(frozen=True)
class LevelRules:
    """Levels of an octree (numerics §7).

    count: levels, 1 for a uniform grid.
    normalization: "mean" injects level i with the mean of its children (the octree thesis, equation
    11). "flux" with 2^i times that. Light accumulates in every cell that it leaves. On its way
    through a coarse cell it leaves 2 of the 2^D children, and one cell where there is only the
    coarse one, so that means of accumulated light are 2 · 2^-D of what passed. Emission adds up
    over all children, and its mean is 2^-D of it. The ratio, 2 a level, holds for light that
    keeps its way in metres; a scheme that makes it diffuse needs more, up to 4 a level.
    factors: these factors per level instead, the first of them 1.
    falloff: "cells" steps every level with the same stencil, so that what a step loses, it loses
    per cell (the thesis). "metres": see flatland.octree.falloff.
    index: which level a place is read from, see flatland.octree.index. patience: a level counts as
    lit where as many steps have been done as its first light took, times this. 1 reads it at once
    (the thesis), although most of its light is still to come; a few wait for more of it.
    drop: a level's light is taken away, and booked, in the outer layers of the box that it is in
    where all coefficients are at most this part of the largest that the level started with.
    skip: what no merge can read is not propagated: cells that light has not reached, on any level,
    and levels that no place is read from, until somebody looks at them. Fields are the same bit
    for bit. On large grids, nor is what is the mirror image of another part; fields then are the
    same to rounding.
    """

    count: int = 1
    normalization: str = "flux"
    factors: Sequence[float] | None = None
    falloff: str = "cells"
    index: str = "finest"
    patience: float = 1.0
    skip: bool = True
    drop: float = 0.0

    def __post_init__(self) -> None:
        for name, choices in (
            ("normalization", NORMALIZATIONS),
            ("falloff", FALLOFFS),
            ("index", INDEX_STRATEGIES),
        ):
            if getattr(self, name) not in choices:
                raise bad_input(name, getattr(self, name), "is unknown", choices)
        if not (np.isfinite(self.patience) and self.patience >= 1):
            raise bad_input("patience", self.patience, "must be finite and at least 1")
        if not (np.isfinite(self.drop) and 0 <= self.drop < 1):
            raise bad_input("drop", self.drop, "must be at least 0 and less than 1")
        if self.drop and not self.skip:
            raise bad_input("drop", self.drop, "must be 0 when all cells are swept (skip = False)")

    def grids(self, grid: Grid) -> tuple[Grid, ...]:
        """All levels' grids. Raises InputError for a count that this grid cannot have."""
        return level_grids(grid, self.count)

    def injection_factors(self) -> tuple[float, ...]:
        """What multiplies the mean of level 0's light on each level, 1 for level 0.

        Raises InputError for given factors that are not one positive number per level, 1 first.
        """
        if self.factors is None:
            base = 2.0 if self.normalization == "flux" else 1.0
            return tuple(base**level for level in range(self.count))
        try:
            values = np.asarray(self.factors, float)
        except (TypeError, ValueError):
            values = np.array(np.nan)
        good = values.shape == (self.count,) and np.all(np.isfinite(values) & (values > 0))
        if not good or values[0] != 1:
            rule = f"must be {self.count} positive numbers, one per level, the first of them 1"
            raise bad_input("level_factors", self.factors, rule)
        return tuple(values.tolist())
