"""Between cells, metres and pixels of one view."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flatland.grid import Grid
from gui.models.camera import Camera
from gui.models.levels import ratio_of
from gui.models.plane import Plane


@dataclass(frozen=True)
class Frame2D:
    """Where cells lie in a view. zoom: device pixels per cell; left, bottom: of cell (0, 0).

    ratio: device pixels per logical one; width, height: of the view [device pixels].
    """

    grid: Grid
    plane: Plane
    zoom: float
    left: float
    bottom: float
    width: float
    height: float
    ratio: float = 1.0

    @classmethod
    def of(
        cls, grid: Grid, plane: Plane, camera: Camera, width: float, height: float, ratio: float
    ) -> Frame2D:
        left = round(width / 2 - camera.centre[0] * camera.zoom)
        bottom = round(height / 2 + camera.centre[1] * camera.zoom)
        return cls(grid, plane, camera.zoom, left, bottom, width, height, ratio)

    def on(self, grid: Grid, plane: Plane) -> Frame2D:
        """The same view of a coarser grid that begins in the same corner."""
        zoom = self.zoom * ratio_of(grid, self.grid)
        return replace(self, grid=grid, plane=plane, zoom=zoom)

    @property
    def window(self) -> tuple[slice, slice]:
        """Ranges of cells that can be seen."""
        nx, ny = self.plane.shape(self.grid)
        low = self.cell_place(0, self.height / self.ratio)
        high = self.cell_place(self.width / self.ratio, 0)
        ranges = []
        for count, start, stop in zip((nx, ny), low, high):
            first = min(max(int(np.floor(start)), 0), count)
            ranges.append(slice(first, min(max(int(np.ceil(stop)), first), count)))
        return ranges[0], ranges[1]

    def cell_place(self, x: float, y: float) -> tuple[float, float]:
        """Logical pixels as cell coordinates in the plane."""
        return (
            (x * self.ratio - self.left) / self.zoom,
            (self.bottom - y * self.ratio) / self.zoom,
        )

    def cell_at(self, x: float, y: float) -> tuple[int, ...] | None:
        """The cell under logical pixels, or None outside of the grid."""
        right, up = self.cell_place(x, y)
        nx, ny = self.plane.shape(self.grid)
        if not (0 <= right < nx and 0 <= up < ny):
            return None
        return self.plane.cell(int(right), int(up), self.grid.dimension)

    def world_at(self, x: float, y: float) -> tuple[float, float]:
        """Logical pixels as a point of the plane [m]."""
        right, up = self.cell_place(x, y)
        origin = self._origin
        return (
            float(origin[0] + right * self.grid.spacing),
            float(origin[1] + up * self.grid.spacing),
        )

    def pixels(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points of the plane (..., 2) [m] in logical pixels."""
        cells = (np.asarray(points, float) - self._origin) / self.grid.spacing
        return self.cell_pixels(cells)

    def cell_pixels(self, cells: NDArray[np.float64]) -> NDArray[np.float64]:
        """Cell coordinates (..., 2) in logical pixels."""
        places = np.asarray(cells, float) * self.zoom * np.array([1.0, -1.0])
        return (places + np.array([self.left, self.bottom])) / self.ratio

    @property
    def _origin(self) -> NDArray[np.float64]:
        return self.plane.project(np.array(self.grid.origin))
