"""What every shadow map tells, whatever its dimension."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatland.grid import Grid
from flatland.sources import Source

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class CellShares(NamedTuple):
    """Cells (M, dimension) in front of lit surfaces, the flux (M,) in each, its normal (M, D)."""

    cells: Indices
    shares: Array
    normals: Array


@dataclass(frozen=True, eq=False)
class ShadowMap(ABC):
    """K lit pieces of surface, at least one per texel and surface seen in it.

    normals: (K, dimension), towards the light. walls: (K,) place of the surface in the list of
    walls. texels: (K,) texel that each belongs to. received: (K,), flux of a light of unit strength
    that arrives; a share of the flux of a point light, a width [m] or an area [m²] across a
    directional one. cosines: (K,), between the surface's normal and the light, in the middle of
    the piece. emitted: what a light of unit strength sends into the grid, in the same unit.
    """

    normals: Array
    walls: Indices
    texels: Indices
    received: Array
    cosines: Array
    emitted: float

    @property
    def escaped(self) -> float:
        """What meets no surface in the grid, in the unit of `emitted`."""
        return self.emitted - float(self.received.sum())

    @property
    @abstractmethod
    def positions(self) -> Array:
        """Middles of the pieces (K, dimension) [m]."""

    @abstractmethod
    def cell_shares(self, chosen: Indices, flux: Array, grid: Grid) -> CellShares:
        """Where flux (K,) of those pieces that are chosen goes: half a cell away from the surface.

        Each piece is moved by half a cell along its normal (Kaplanyan & Dachsbacher 2010, section
        3.1) and cut at the cell borders. What then lies outside the grid is left out.
        """

    @abstractmethod
    def source_map(self) -> ShadowMap:
        """The same light in pieces that `sources` can make surfaces of."""

    @abstractmethod
    def sources(self, flux: Array, grid: Grid) -> Sequence[Source]:
        """The pieces of a `source_map` as Lambertian surfaces of flux (K, C) in all."""
