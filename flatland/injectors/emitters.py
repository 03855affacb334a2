"""Flat Lambertian emitters: a segment in 2D, a polygon in 3D."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flatland.facets import cut_by_cells, facet_table, vector_area
from flatland.grid import Grid
from flatland.moved_segments import ON_BORDER, cells_along, on_border
from flatland.sources import Facet, PolygonSource, Segment, SegmentSource, Source, Wall

Array = NDArray[np.float64]
Cells = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Emitter(ABC):
    """Where light leaves a flat thing to its front. points: its corners (P, dimension) [m]."""

    points: Array

    #: ∫⟨n|ω⟩₊ dω: flux per radiance and size.
    whole_cosine: ClassVar[float]
    #: Where its front is and how to turn it, for messages.
    front: ClassVar[str]

    @property
    @abstractmethod
    def size(self) -> float:
        """Length [m] in 2D, area [m²] in 3D."""

    @property
    @abstractmethod
    def normal(self) -> Array:
        """Unit vector (dimension,) towards the front."""

    @abstractmethod
    def source(self, spectrum: Array) -> Source:
        """The emitter itself with a flux per colour, as exact methods read it."""

    @abstractmethod
    def wall(self, albedo: Array) -> Wall:
        """The emitter as something that stands in the way of other light."""

    @abstractmethod
    def _cut(self, grid: Grid) -> tuple[Cells, Array]:
        """Cells (K, dimension) under the moved emitter, and the part (K,) of its size in each."""

    def shares(self, grid: Grid) -> tuple[Cells, Array]:
        """Cells (dimension, K) that get light and the part (K,) each gets; parts add up to 1.

        The emitter is moved by half a cell to its front and cut at the cell borders.
        """
        cells, parts = self._cut(grid)
        # Rounding at a border may put a part just outside, and at a corner cut one in two.
        inside = np.clip(cells, 0, np.array(grid.shape) - 1)
        flat = np.ravel_multi_index(tuple(inside.T), grid.shape)
        unique, place = np.unique(flat, return_inverse=True)
        shares = np.bincount(place, parts).astype(float)
        return np.stack(np.unravel_index(unique, grid.shape)), shares

    def leaves(self, grid: Grid) -> bool:
        """Whether it would send light out of the grid."""
        moved, normal = self._moved(grid), self.normal
        # On the border with the front outwards, the cell in front is the one beyond the border.
        probe = np.where(on_border(moved, normal), moved + 0.5 * np.sign(normal), moved)
        return bool(np.any(probe < -ON_BORDER) or np.any(probe > np.array(grid.shape) + ON_BORDER))

    def _moved(self, grid: Grid) -> Array:
        """Its corners, moved by half a cell to the front, in cell units."""
        return grid.to_cells(self.points) + 0.5 * self.normal


class SegmentEmitter(Emitter):
    """Emits to the left of the first point -> the second."""

    whole_cosine: ClassVar = 2.0
    front: ClassVar = (
        "segment, to the left of start -> end; move the segment inwards or swap its ends"
    )

    @property
    def size(self) -> float:
        return float(np.hypot(*(self.points[1] - self.points[0])))

    @property
    def normal(self) -> Array:
        x, y = (self.points[1] - self.points[0]) / self.size
        return np.array([-y, x])

    def source(self, spectrum: Array) -> Source:
        return SegmentSource(self.points[0], self.points[1], spectrum)

    def wall(self, albedo: Array) -> Wall:
        return Segment(self.points[0], self.points[1], albedo)

    def _cut(self, grid: Grid) -> tuple[Cells, Array]:
        cuts, cells = cells_along(self._moved(grid), self.normal)
        return cells, np.diff(cuts)


class PolygonEmitter(Emitter):
    """Emits to the side from which its corners run counter-clockwise."""

    whole_cosine: ClassVar = float(np.pi)
    front: ClassVar = (
        "polygon, where its vertices run counter-clockwise; move the polygon inwards or reverse "
        "the order of its vertices"
    )

    @property
    def size(self) -> float:
        return float(np.linalg.norm(vector_area(self.points)))

    @property
    def normal(self) -> Array:
        # In units of its extent: squares of tiny sizes would underflow.
        arms = self.points - self.points[0]
        vector = vector_area(arms / np.abs(arms).max())
        return np.asarray(vector / np.linalg.norm(vector))

    def source(self, spectrum: Array) -> Source:
        return PolygonSource(self.points, spectrum)

    def wall(self, albedo: Array) -> Wall:
        return Facet(self.points, albedo)

    def _cut(self, grid: Grid) -> tuple[Cells, Array]:
        table = facet_table(grid, [Facet(self.points, np.zeros(1))]).moved(0.5)
        pieces = cut_by_cells(table, grid.shape)
        if not pieces.areas.size:  # too small, or on the border up to rounding
            middle = self._moved(grid).mean(axis=0, keepdims=True)
            return np.floor(middle).astype(np.int64), np.ones(1)
        return pieces.cells, pieces.areas / pieces.areas.sum()
