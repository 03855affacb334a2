"""Parallel light from far away, such as the sun's."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Array, Deposit, collect, unit_vector
from flatland.injectors.border import border_sides
from flatland.injectors.cell import wrong_length
from flatland.injectors.lamp import Lamp
from flatland.injectors.values import Broken, Heading, PerColour
from flatland.shadow_map import ShadowMap, map_directional_light
from flatland.sources import ParallelSource, Source, Wall


class DirectionalLight(Lamp):
    """Irradiance E⊥ along one direction ω, from outside.

    The first bounce is albedo · E⊥ · width (2D) or area (3D) of a texel across ω. The light comes
    in through the border: through a border face of outward normal n enters the flux
    E⊥ h^(dimension - 1) max(0, −n·ω); as with environment light, it leaves the cell behind the
    face, as a peak along ω: coefficients Φ y(ω). What that gets wrong: a peak of few bands is a
    wide lobe that is negative elsewhere, and walls in the outer half of a border cell block as
    seen along the axis.
    """

    dimensions: ClassVar = (2, 3)
    colour_keys: ClassVar = ("irradiance",)

    kind: Literal["directional"] = Field("directional", description="parallel light from outside")
    direction: Heading = Field(description="direction that the light travels along")
    irradiance: PerColour = Field(
        description="[W/m in 2D, W/m² in 3D] on a surface perpendicular to the light, a number or"
        " one per colour"
    )

    @property
    def strength(self) -> float | tuple[float, ...]:
        return self.irradiance

    @property
    def heading(self) -> Array:
        """Unit vector (dimension,) that the light travels along."""
        return unit_vector(self.direction)

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        broken = wrong_length("direction", self.direction, grid)
        return broken + super().grid_misfits(grid, directory)

    def shadow_map(self, grid: Grid, walls: Sequence[Wall]) -> ShadowMap:
        return map_directional_light(grid, walls, self.heading, self.texels)

    def direct(self, grid: Grid, basis: AngularBasis, walls: Sequence[Wall]) -> Deposit:
        area = grid.spacing ** (grid.dimension - 1)
        lit = [side for side in border_sides(grid, walls) if side.inward @ self.heading > 0]
        flux = [area * (side.inward @ self.heading) * side.open_shares for side in lit]
        cells = np.concatenate([side.cells for side in lit], axis=1)
        peak = basis.evaluate(self.heading)
        return collect(cells, np.concatenate(flux)[:, None] * peak, grid.shape)

    def lamps(self, grid: Grid, colours: int) -> list[Source]:
        return [ParallelSource(self.heading, self.channels(colours))]
