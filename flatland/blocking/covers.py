"""What one wall takes of one beam."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Cells = NDArray[np.int64]


class Covers(NamedTuple):
    """Walls in beams (M,), in 2D or 3D; a wall may occur in a beam more than once, in pieces.

    cells: (M, dimension), the source cells of the links; they may lie outside the grid. shares:
    (M,), the part of the beam that the wall covers; 0 for one that only reaches its centre ray.
    walls: (M,), which wall. normals: (M, dimension), unit vectors of the walls, either way.
    """

    cells: Cells
    shares: Array
    walls: Cells
    normals: Array

    def within(self, shape: tuple[int, ...]) -> Covers:
        """Those of links that start in the grid."""
        inside = np.all((self.cells >= 0) & (self.cells < shape), axis=1)
        cells, shares, walls, normals = self
        return Covers(cells[inside], shares[inside], walls[inside], normals[inside])
