"""A lamp that shines in all directions from one point."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Deposit
from flatland.injectors.cell import point_source, wrong_length
from flatland.injectors.lamp import Lamp
from flatland.injectors.values import Broken, PerColour, Position
from flatland.moved_segments import ON_BORDER
from flatland.shadow_map import ShadowMap, map_point_light
from flatland.sources import Source, Wall
from flatland.touching import touches


class PointLight(Lamp):
    """Intensity Φ/2π (2D) or Φ/4π (3D) in every direction.

    The first bounce is Φ_o = albedo · Φ Δθ/2π or albedo · Φ Ω/4π per texel of angle Δθ or Ω.
    Its own light leaves the cell that holds it, isotropic; on a cell border, the cells on both
    sides in equal parts. What that gets wrong: the position inside the cell is lost, and with it
    the shade of walls in the same cell.
    """

    dimensions: ClassVar = (2, 3)
    colour_keys: ClassVar = ("flux",)

    kind: Literal["point"] = Field("point", description="shines in all directions from a point")
    position: Position = Field(description="where it is [m], inside the grid")
    flux: PerColour = Field(description="emitted flux [W], a number or one per colour")

    @property
    def strength(self) -> float | tuple[float, ...]:
        return self.flux

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        if broken := wrong_length("position", self.position, grid):
            return broken
        broken = super().grid_misfits(grid, directory)
        cells = grid.to_cells(self.position)
        if not np.all((cells > ON_BORDER) & (cells < np.array(grid.shape) - ON_BORDER)):
            spans = " x ".join(f"{o:g} to {u:g}" for o, u in zip(grid.origin, grid.upper))
            rule = f"must lie inside the grid, {spans}, and not on its border"
            broken.append(Broken(rule, key="position", value=self.position))
        return broken

    def wall_misfits(self, grid: Grid, walls: Sequence[Wall]) -> list[Broken]:
        if not touches(walls, np.array(self.position), ON_BORDER * grid.spacing):
            return []
        rule = "must not lie on an occluder: move it to the side that it is to light"
        return [Broken(rule, key="position", value=self.position)]

    def shadow_map(self, grid: Grid, walls: Sequence[Wall]) -> ShadowMap:
        return map_point_light(grid, walls, np.array(self.position), self.texels)

    def direct(self, grid: Grid, basis: AngularBasis, walls: Sequence[Wall]) -> Deposit:
        place = grid.to_cells(self.position)
        ranges = [np.unique(np.floor([x - ON_BORDER, x + ON_BORDER])) for x in place]
        cells = np.stack([axis.ravel() for axis in np.meshgrid(*ranges, indexing="ij")])
        share = basis.isotropic(1 / cells.shape[1])
        return Deposit(cells.astype(np.int64), np.tile(share, (cells.shape[1], 1)))

    def lamps(self, grid: Grid, colours: int) -> list[Source]:
        return [point_source(np.array(self.position), self.channels(colours), None)]
