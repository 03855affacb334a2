"""A flat Lambertian light: a segment in 2D, a polygon in 3D."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from flatland.grid import Grid
from flatland.harmonics import AngularBasis
from flatland.injectors.base import Array, Deposit, Injector
from flatland.injectors.emitters import Emitter, PolygonEmitter, SegmentEmitter
from flatland.injectors.item import is_degenerate
from flatland.injectors.values import (
    Broken,
    OptionalPerColour,
    OptionalPoint,
    OptionalSpaceVertices,
)
from flatland.planar import polygon_fault
from flatland.sources import Source, Wall


class AreaLight(Injector):
    """Emits Φ⟨n|ω⟩₊/2 (2D) or Φ⟨n|ω⟩₊/π (3D) per point to its front (CLPV 3.1).

    In 2D a segment with its front on the left of start -> end; in 3D a planar polygon with its
    front where the vertices run counter-clockwise.
    CLPV scatter virtual point lights over the emitter, move each by half a cell along its
    normal and put it into the cell it then lies in. This is the limit of infinitely many: the
    moved emitter is cut at the cell borders, and each cell gets its share of the length or area.
    A part that lies on a border after the move belongs to the cell in front of it.
    What it gets wrong: the position inside the cell is lost, so a slanted light becomes steps.
    """

    dimensions: ClassVar = (2, 3)
    colour_keys: ClassVar = ("flux", "radiance")

    kind: Literal["area"] = Field("area", description="a flat light that emits to its front")
    start: OptionalPoint = Field(
        None, description="start [m] in 2D; light goes to the left of start -> end"
    )
    end: OptionalPoint = Field(None, description="end [m] in 2D")
    vertices: OptionalSpaceVertices = Field(
        None,
        description="at least 3 points [m] in 3D, in one plane; light goes to the side from which "
        "they run counter-clockwise",
    )
    flux: OptionalPerColour = Field(
        None, description="emitted flux [W], a number or one per colour; or give radiance"
    )
    radiance: OptionalPerColour = Field(
        None,
        description="radiance of the front [W/(m rad) in 2D, W/(m² sr) in 3D], a number or one "
        "per colour",
    )

    @property
    def emitter(self) -> Emitter:
        """What emits; for a light that breaks no rule."""
        if self.vertices is not None:
            return PolygonEmitter(np.array(self.vertices))
        return SegmentEmitter(np.array([self.start, self.end], float))

    @property
    def normal(self) -> Array:
        """Unit vector (dimension,) towards the front."""
        return self.emitter.normal

    @property
    def strength(self) -> float | tuple[float, ...]:
        """Flux [W]: radiance times 2 · length or π · area, as the clamped cosine integrates to."""
        if self.flux is not None:
            return self.flux
        flux = self.emitter.whole_cosine * self.emitter.size * np.asarray(self.radiance)
        return tuple(flux.tolist()) if flux.ndim else float(flux)

    def inner_misfits(self) -> list[Broken]:
        broken = []
        if (self.flux is None) == (self.radiance is None):
            broken.append(Broken("must have either flux or radiance, and not both"))
        return broken + self._shape_misfits()

    def _shape_misfits(self) -> list[Broken]:
        """Rules that the keys of its shape break."""
        ends = {"start": self.start, "end": self.end}
        given = [key for key, value in ends.items() if value is not None]
        if self.vertices is not None:
            if given:
                rule = f"cannot be combined with {' and '.join(given)}, which are for 2D"
                return [Broken(rule, key="vertices", value=self.vertices)]
            fault = polygon_fault(np.array(self.vertices))
            return [Broken(fault, key="vertices", value=self.vertices)] if fault else []
        if not given:
            return [Broken("needs a start and an end in 2D, or vertices in 3D")]
        if len(given) == 1:
            missing = "end" if given == ["start"] else "start"
            return [Broken(f"has no key {missing!r}, which it needs")]
        if is_degenerate(self.start, self.end):
            rule = "must differ from start: a light needs a length"
            return [Broken(rule, key="end", value=self.end)]
        return []

    def grid_misfits(self, grid: Grid, directory: Path) -> list[Broken]:
        if broken := self._dimension_misfits(grid):
            return broken
        spans = " x ".join(f"[{o:g}, {u:g}]" for o, u in zip(grid.origin, grid.upper))
        broken = [
            Broken(f"must lie in the grid, {spans}", key=key, value=value)
            for key, value in self._corners()
            if not grid.contains(value)
        ]
        if not broken and not self._shape_misfits() and self.emitter.leaves(grid):
            rule = "sends its light out of the grid: it starts half a cell in front of the "
            broken.append(Broken(rule + self.emitter.front))
        return broken

    def _dimension_misfits(self, grid: Grid) -> list[Broken]:
        if grid.dimension == 2 and self.vertices is not None:
            rule = "are for 3D, the grid is 2D: write start = [x, y] and end = [x, y] instead"
            return [Broken(rule, key="vertices", value=self.vertices)]
        key, value = ("end", self.end) if self.start is None else ("start", self.start)
        if grid.dimension == 3 and value is not None and self.vertices is None:
            rule = (
                "is for 2D, the grid is 3D: write vertices = [[x, y, z], ...] instead, at least 3 "
                "points of one plane"
            )
            return [Broken(rule, key=key, value=value)]
        return []

    def _corners(self) -> list[tuple[str, tuple[float, ...]]]:
        """Its corners, as far as they are given, each with the key that says where it is."""
        if self.vertices is not None:
            return [("vertices", vertex) for vertex in self.vertices]
        ends = (("start", self.start), ("end", self.end))
        return [(key, point) for key, point in ends if point is not None]

    def deposit(self, grid: Grid, basis: AngularBasis) -> Deposit:
        cells, shares = self.emitter.shares(grid)
        return Deposit(cells, shares[:, None] * basis.lambertian(self.normal))

    def sources(self, grid: Grid, colours: int = 0) -> list[Source]:
        return [self.emitter.source(self.channels(colours))]

    def blocker(self, colours: int = 0) -> Wall:
        """The black wall that it is where lights block."""
        return self.emitter.wall(np.zeros(max(1, colours)))
