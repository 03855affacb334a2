"""Light from all around the grid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Deposit, Emission, Injector, Part, collect
from flatland.injectors.border import border_sides
from flatland.injectors.open_border import open_sources
from flatland.injectors.values import PerColour
from flatland.sources import Source, Wall


class EnvironmentLight(Injector):
    """The same radiance L from every direction outside, into the outer layer of cells.

    Through a border face of outward normal n comes h⟨−n|ω⟩₊L, a flux of 2hL in 2D, and h²⟨−n|ω⟩₊L,
    a flux of πh²L, in 3D (Kaplanyan & Dachsbacher 2010, section 3.1, put environment maps into the
    outer layer too). A cell stores the intensity that leaves it, and what comes into an empty cell
    leaves it again: so the light enters the cells behind the border as if they emitted it. A cell
    at an edge of the grid has a border face on each side.
    What it gets wrong: the flux is exact, but the cell's centre stands for the whole face, as it
    does in every step. In an empty grid the answer is uniform, and so is that of axial schemes
    with one band; with more, a scheme's own light would arrive in other directions than ⟨−n|ω⟩₊,
    and inner cells of LPV come out a third too bright, of DOM4 a tenth too dark. Walls in the outer
    half of a border cell block what comes straight in, whatever its direction (`border_sides`).
    The light does not bounce: it casts no shadow map.
    """

    dimensions: ClassVar = (2, 3)
    colour_keys: ClassVar = ("radiance",)

    kind: Literal["environment"] = Field("environment", description="light from all around")
    radiance: PerColour = Field(
        description="radiance [W/(m rad) in 2D, W/(m² sr) in 3D] of the surroundings, a number or"
        " one per colour"
    )

    @property
    def strength(self) -> float | tuple[float, ...]:
        return self.radiance

    def deposit(self, grid: Grid, basis: AngularBasis) -> Deposit:
        return self._deposit(grid, basis, ())

    def emissions(
        self, grid: Grid, basis: AngularBasis, walls: Sequence[Wall] = (), colours: int = 0
    ) -> list[Emission]:
        return [Emission(self.channels(colours), self._deposit(grid, basis, walls))]

    def sources(self, grid: Grid, colours: int = 0) -> list[Source]:
        return self.twins(grid, (), colours)

    def twins(
        self,
        grid: Grid,
        walls: Sequence[Wall] = (),
        colours: int = 0,
        part: Part = "both",
    ) -> list[Source]:
        """Area lights of the same radiance on the border, where no wall lies on it.

        Being opaque, they take the light that leaves the grid: books of an exact method count it
        as absorbed.
        """
        if part == "bounce":
            return []
        radiance = self.channels(colours)
        return [
            source
            for side in border_sides(grid)
            for source in open_sources(grid, walls, side, radiance)
        ]

    def _deposit(self, grid: Grid, basis: AngularBasis, walls: Sequence[Wall]) -> Deposit:
        sides = border_sides(grid, walls)
        area = grid.spacing ** (grid.dimension - 1)
        lobes = [
            area * side.open_shares[:, None] * basis.clamped_cosine(side.inward) for side in sides
        ]
        cells = np.concatenate([side.cells for side in sides], axis=1)
        return collect(cells, np.concatenate(lobes), grid.shape)
