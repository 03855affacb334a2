"""What point lights and directional lights share: a shadow map and a first bounce."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Literal

from pydantic import Field

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Deposit, Emission, Injector, Part
from flatland.injectors.bounce import bounce_emissions, bounce_sources
from flatland.injectors.values import MOST_TEXELS_3D, Broken, Texels
from flatland.shadow_map import LightBudget, ShadowMap, light_budget
from flatland.sources import Source, Wall


class Lamp(Injector):
    """A light whose own light and whose first bounce off the scene's walls are known apart.

    The first bounce comes from a reflective shadow map (flatland.shadow_map), as in light
    propagation volumes, where the direct light is drawn by shadow maps and not propagated: that is
    inject = "bounce". "both", the default, propagates all the light there is.
    """

    bounces: ClassVar = True

    # Named apart from its key, which is the name of a method of every light.
    part: Literal["both", "direct", "bounce"] = Field(
        "both", alias="inject", description="what is injected: its own light, the bounce, or both"
    )
    texels: Texels = Field(
        256, description="texels of its shadow map; in 3D along each side of the map"
    )
    weight: Literal["exact", "lpv2009"] = Field(
        "exact", description='flux of a texel; "lpv2009" counts the cosine twice, as printed there'
    )

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        if grid.dimension == 2 or self.texels <= MOST_TEXELS_3D:
            return []
        rule = f"must be at most {MOST_TEXELS_3D} in 3D, where maps are squares of texels"
        return [Broken(rule, key="texels", value=self.texels)]

    @abstractmethod
    def shadow_map(self, grid: Grid, walls: Sequence[Wall]) -> ShadowMap:
        """What the light meets first, for a light of unit strength."""

    @abstractmethod
    def direct(self, grid: Grid, basis: AngularBasis, walls: Sequence[Wall]) -> Deposit:
        """The light itself, for unit strength."""

    @abstractmethod
    def lamps(self, grid: Grid, colours: int) -> list[Source]:
        """The exact twin of the light itself."""

    def deposit(self, grid: Grid, basis: AngularBasis) -> Deposit:
        """In a grid without walls."""
        cells, coefficients = self.direct(grid, basis, ())
        kept = 0 if self.part == "bounce" else len(coefficients)
        return Deposit(cells[:, :kept], coefficients[:kept])

    def emissions(
        self, grid: Grid, basis: AngularBasis, walls: Sequence[Wall] = (), colours: int = 0
    ) -> list[Emission]:
        strength = self.channels(colours)
        emissions = []
        if self.part != "bounce":
            emissions.append(Emission(strength, self.direct(grid, basis, walls)))
        if self.part != "direct" and walls:
            found = self.shadow_map(grid, walls)
            emissions += bounce_emissions(found, walls, strength, self.weight, grid, basis)
        return emissions

    def sources(self, grid: Grid, colours: int = 0) -> list[Source]:
        """In a grid without walls."""
        return [] if self.part == "bounce" else self.lamps(grid, colours)

    def twins(
        self,
        grid: Grid,
        walls: Sequence[Wall] = (),
        colours: int = 0,
        part: Part = "both",
    ) -> list[Source]:
        """The light itself, and lit walls as Lambertian surfaces of its shadow map's flux."""
        if part == "lamp":
            return self.lamps(grid, colours)
        sources = [] if part == "bounce" else self.sources(grid, colours)
        if "direct" in (part, self.part) or not walls:
            return sources
        found, strength = self.shadow_map(grid, walls), self.channels(colours)
        return [*sources, *bounce_sources(found, walls, strength, self.weight, grid)]

    def budget(self, grid: Grid, walls: Sequence[Wall], colours: int = 0) -> LightBudget:
        """Of the light itself, whatever part of it is injected."""
        return light_budget(self.shadow_map(grid, walls), walls, self.channels(colours))
