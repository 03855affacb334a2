"""The same light in every cell along a side (the octree thesis' wall injector, section 5.1)."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StrictBool

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Array, Deposit, Injector
from flatland.injectors.cell import lobe, point_source, wrong_length
from flatland.injectors.values import Broken, Direction, Index, OptionalIndex, PerColour
from flatland.sources import Source

Side = Literal["left", "right", "bottom", "top", "back", "front"]
#: Axis of each side, and whether it is the upper end; `back` is the lower end of z.
SIDES = {
    "left": (0, False),
    "right": (0, True),
    "bottom": (1, False),
    "top": (1, True),
    "back": (2, False),
    "front": (2, True),
}


class WallLight(Injector):
    """One point per cell of a side, each with an equal part of the flux.

    A row of points, not an emitting line: seen from less than a cell away it looks dotted, in
    the reference too. Use an area light for a smooth one.
    """

    dimensions: ClassVar = (2, 3)
    colour_keys: ClassVar = ("flux",)

    kind: Literal["wall"] = Field("wall", description="light in the cells along a side")
    side: Side = Field(description="side of the grid; back and front in 3D only")
    flux: PerColour = Field(
        description="flux of all cells together [W], a number or one per colour"
    )
    direction: Direction = Field(None, description="axis of the lobes; inward without it")
    isotropic: StrictBool = Field(False, description="the same in all directions, no lobe")
    first: Index = Field(0, description="first cell along the side (2D)")
    last: OptionalIndex = Field(None, description="last cell along the side (2D); the whole side")

    @property
    def strength(self) -> float | tuple[float, ...]:
        return self.flux

    def inner_misfits(self) -> list[Broken]:
        broken = []
        if self.isotropic and self.direction is not None:
            rule = "cannot be combined with isotropic = true"
            broken.append(Broken(rule, key="direction", value=self.direction))
        if self.last is not None and self.last < self.first:
            rule = f"must be at least first = {self.first}"
            broken.append(Broken(rule, key="last", value=self.last))
        return broken

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        axis, _ = SIDES[self.side]
        if axis >= grid.dimension:
            sides = tuple(side for side, (a, _) in SIDES.items() if a < grid.dimension)
            return [Broken("is no side of a 2D grid", sides, key="side", value=self.side)]
        broken = wrong_length("direction", self.direction, grid)
        for key in ("first", "last"):
            value = getattr(self, key)
            if grid.dimension == 3 and value:
                broken.append(Broken("works in 2D only", key=key, value=value))
            elif grid.dimension == 2 and value is not None and value >= grid.shape[1 - axis]:
                rule = f"must lie along the side, 0 to {grid.shape[1 - axis] - 1}"
                broken.append(Broken(rule, key=key, value=value))
        return broken

    def deposit(self, grid: Grid, basis: AngularBasis) -> Deposit:
        cells = self._cells(grid)
        share = lobe(self._axis_of_lobe(grid), basis) / cells.shape[1]
        return Deposit(cells, np.tile(share, (cells.shape[1], 1)))

    def refined(self, factor: int) -> Self:
        """The same part of the side and the same flux, as `factor` times as many points a cell."""
        last = None if self.last is None else factor * self.last + factor - 1
        return self.model_copy(update={"first": factor * self.first, "last": last})

    def sources(self, grid: Grid, colours: int = 0) -> list[Source]:
        cells, axis = self._cells(grid), self._axis_of_lobe(grid)
        spectrum = self.channels(colours) / cells.shape[1]
        return [point_source(grid.to_world(cell + 0.5), spectrum, axis) for cell in cells.T]

    def _cells(self, grid: Grid) -> NDArray[np.int64]:
        """Indices (dimension, K) of the cells along the side."""
        axis, upper = SIDES[self.side]
        ranges = [np.arange(n) for n in grid.shape]
        ranges[axis] = ranges[axis][-1:] if upper else ranges[axis][:1]
        if grid.dimension == 2:
            stop = None if self.last is None else self.last + 1
            ranges[1 - axis] = ranges[1 - axis][self.first : stop]
        return np.stack([index.ravel() for index in np.meshgrid(*ranges, indexing="ij")])

    def _axis_of_lobe(self, grid: Grid) -> tuple[float, ...] | None:
        if self.isotropic or self.direction is not None:
            return self.direction
        axis, upper = SIDES[self.side]
        inward: Array = np.zeros(grid.dimension)
        inward[axis] = -1.0 if upper else 1.0
        return tuple(inward)
