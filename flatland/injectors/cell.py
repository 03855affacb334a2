"""Light in a single cell (the octree thesis' single element injector, section 5.1)."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.harmonics import AngularBasis, basis_for
from flatland.injectors.base import Array, Deposit, Injector, unit_vector
from flatland.injectors.values import Broken, Cell, Direction, PerColour
from flatland.sources import PointSource, Source


class CellLight(Injector):
    """A point at the centre of a cell: isotropic, or a Lambertian lobe Φ⟨n|ω⟩₊/2 (2D), /π (3D).

    Few bands store a lobe badly: two of them leave it negative backwards, which is where back
    bleeding starts (the thesis' figure 16; scene `back-bleeding`).
    """

    dimensions: ClassVar = (2, 3)
    colour_keys: ClassVar = ("flux",)

    kind: Literal["cell"] = Field("cell", description="light in a single cell")
    cell: Cell = Field(description="index of the cell along each axis, counted from 0")
    direction: Direction = Field(None, description="axis of the lobe; isotropic without it")
    flux: PerColour = Field(description="emitted flux [W], a number or one per colour")

    @property
    def strength(self) -> float | tuple[float, ...]:
        return self.flux

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        broken = wrong_length("direction", self.direction, grid)
        outside = wrong_length("cell", self.cell, grid)
        if not outside and any(i >= n for i, n in zip(self.cell, grid.shape)):
            ranges = ", ".join(f"0 to {n - 1}" for n in grid.shape)
            outside = [Broken(f"must lie in the grid, {ranges}", key="cell", value=self.cell)]
        return outside + broken

    def deposit(self, grid: Grid, basis: AngularBasis) -> Deposit:
        return Deposit(np.array(self.cell)[:, None], lobe(self.direction, basis)[None])

    def refined(self, factor: int) -> Self:
        """The small cell in the middle of this one; even factors have none."""
        if factor % 2 == 0:
            rule = "must be odd for a light of kind 'cell', whose point lies in the cell's middle"
            raise bad_input("resolution", factor, rule)
        cell = tuple(factor * index + factor // 2 for index in self.cell)
        return self.model_copy(update={"cell": cell})

    def sources(self, grid: Grid, colours: int = 0) -> list[Source]:
        position = grid.cell_center(self.cell)
        return [point_source(position, self.channels(colours), self.direction)]


def lobe(direction: Direction, basis: AngularBasis) -> Array:
    """Coefficients (size,) of unit flux: Lambertian along a direction, isotropic without one."""
    return basis.isotropic() if direction is None else basis.lambertian(unit_vector(direction))


def point_source(position: Array, spectrum: Array, direction: Direction) -> PointSource:
    """The exact twin of a lobe in a cell centred at `position`."""
    constant = basis_for(position.size, 1).isotropic()
    if direction is None:
        return PointSource(position, spectrum, constant)
    return PointSource(position, spectrum, 0 * constant, 1.0, unit_vector(direction))


def wrong_length(key: str, value: tuple[float, ...] | None, grid: Grid) -> list[Broken]:
    """The broken rule of a vector that has not one component per axis of the grid."""
    if value is None or len(value) == grid.dimension:
        return []
    return [Broken(f"must be {grid.dimension} numbers, as the grid's axes", key=key, value=value)]
