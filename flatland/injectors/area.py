"""A straight Lambertian light in 2D."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Array, Deposit, Injector
from flatland.injectors.item import is_degenerate
from flatland.injectors.values import Broken, OptionalPerColour, Point
from flatland.moved_segments import ON_BORDER, cells_along, on_border
from flatland.sources import SegmentSource, Source


class AreaLight(Injector):
    """A segment that emits Φ⟨n|ω⟩₊/2 per point to the left of start -> end (CLPV 3.1).

    CLPV scatter virtual point lights over the emitter, move each by half a cell along its
    normal and put it into the cell it then lies in. This is the limit of infinitely many: the
    moved segment is cut at the cell borders, and each cell gets its share of the length. A part
    that lies on a border after the move belongs to the cell in front of it.
    What it gets wrong: the position inside the cell is lost, so a slanted light becomes steps.
    """

    dimensions: ClassVar = (2,)
    colour_keys: ClassVar = ("flux", "radiance")

    kind: Literal["area"] = Field("area", description="a segment that emits to its left")
    start: Point = Field(description="start [m]; light goes to the left of start -> end")
    end: Point = Field(description="end [m]")
    flux: OptionalPerColour = Field(
        None, description="emitted flux [W], a number or one per colour; or give radiance"
    )
    radiance: OptionalPerColour = Field(
        None, description="radiance [W/(m rad)] of the front, a number or one per colour"
    )

    @property
    def length(self) -> float:
        return float(np.hypot(*np.subtract(self.end, self.start)))

    @property
    def normal(self) -> Array:
        """Unit vector (2,) towards the front, left of start -> end."""
        x, y = np.subtract(self.end, self.start) / self.length
        return np.array([-y, x])

    @property
    def strength(self) -> float | tuple[float, ...]:
        """Flux [W]; 2 · length · radiance, since the clamped cosine integrates to 2."""
        if self.flux is not None:
            return self.flux
        flux = 2 * self.length * np.asarray(self.radiance)
        return tuple(flux.tolist()) if flux.ndim else float(flux)

    def inner_misfits(self) -> list[Broken]:
        broken = []
        if (self.flux is None) == (self.radiance is None):
            broken.append(Broken("must have either flux or radiance, and not both"))
        if is_degenerate(self.start, self.end):
            rule = "must differ from start: a light needs a length"
            broken.append(Broken(rule, key="end", value=self.end))
        return broken

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        spans = " x ".join(f"[{o:g}, {u:g}]" for o, u in zip(grid.origin, grid.upper))
        broken = [
            Broken(f"must lie in the grid, {spans}", key=key, value=value)
            for key, value in (("start", self.start), ("end", self.end))
            if not grid.contains(value)
        ]
        if not broken and not is_degenerate(self.start, self.end) and self._leaves(grid):
            rule = (
                "sends its light out of the grid: it starts half a cell in front of the segment,"
                " to the left of start -> end; move the segment inwards or swap its ends"
            )
            broken.append(Broken(rule))
        return broken

    def deposit(self, grid: Grid, basis: AngularBasis) -> Deposit:
        cells, shares = self._shares(grid)
        return Deposit(cells, shares[:, None] * basis.lambertian(self.normal))

    def sources(self, grid: Grid, colours: int = 0) -> list[Source]:
        return [SegmentSource(np.array(self.start), np.array(self.end), self.channels(colours))]

    def _moved(self, grid: Grid) -> Array:
        """Both ends (2, 2), moved by half a cell to the front, in cell units."""
        return grid.to_cells([self.start, self.end]) + 0.5 * self.normal

    def _leaves(self, grid: Grid) -> bool:
        moved = self._moved(grid)
        # On the border with the front outwards, the cell in front is the one beyond the border.
        probe = np.where(on_border(moved, self.normal), moved + 0.5 * np.sign(self.normal), moved)
        return bool(np.any(probe < -ON_BORDER) or np.any(probe > np.array(grid.shape) + ON_BORDER))

    def _shares(self, grid: Grid) -> tuple[NDArray[np.int64], Array]:
        """Cells (2, K) under the moved segment and the part of its length in each (K,)."""
        cuts, cells = cells_along(self._moved(grid), self.normal)
        inside = np.clip(cells, 0, np.array(grid.shape) - 1)
        # Rounding at a cell's corner may cut one cell's part in two.
        flat = np.ravel_multi_index(tuple(inside.T), grid.shape)
        unique, place = np.unique(flat, return_inverse=True)
        return np.stack(np.unravel_index(unique, grid.shape)), np.bincount(
            place, np.diff(cuts)
        ).astype(float)
