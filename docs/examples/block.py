"""A light of one's own: a block of cells, as a module of flatland/injectors would be."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Deposit, Injector
from flatland.injectors.cell import point_source
from flatland.injectors.values import Cell, PerColour
from flatland.sources import Source


class BlockLight(Injector):
    """A point at the centre of every cell of a block, isotropic; they share the flux evenly."""

    dimensions: ClassVar = (2, 3)
    colour_keys: ClassVar = ("flux",)

    kind: Literal["block"] = Field("block", description="light in a block of cells")
    low: Cell = Field(description="the block's first cell along each axis, counted from 0")
    high: Cell = Field(description="its last cell")
    flux: PerColour = Field(description="emitted flux [W], a number or one per colour")

    @property
    def strength(self) -> float | tuple[float, ...]:
        return self.flux

    def deposit(self, grid: Grid, basis: AngularBasis) -> Deposit:
        """The pattern of unit flux, for a stencil."""
        cells = self._cells()
        share = basis.isotropic(1.0 / cells.shape[1])
        return Deposit(cells, np.tile(share, (cells.shape[1], 1)))

    def sources(self, grid: Grid, colours: int = 0) -> list[Source]:
        """The same light for the exact answer."""
        cells = self._cells().T
        share = self.channels(colours) / len(cells)
        return [point_source(grid.cell_center(tuple(cell)), share, None) for cell in cells]

    def _cells(self) -> NDArray[np.int64]:
        """Indices (dimension, K)."""
        ranges = [np.arange(low, high + 1) for low, high in zip(self.low, self.high)]
        return np.stack([axis.ravel() for axis in np.meshgrid(*ranges, indexing="ij")])
