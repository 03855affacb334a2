"""Layers of cells of a 3D grid, and what a scene looks like where one cuts it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.grid import Grid
from flatland.injectors import AreaLight
from flatland.scene import Scene

Array = NDArray[np.float64]

AXES = ("x", "y", "z")
#: In cells: what is this close to a plane lies in it.
_IN_PLANE = 1e-9


class Slice(NamedTuple):
    """A layer of cells of a 3D grid: all cells whose index along `axis` is `cell`."""

    axis: int
    cell: int

    def place(self, grid: Grid) -> float:
        """Where the plane through the middles of its cells is along the axis [m]."""
        return float(grid.origin[self.axis] + (self.cell + 0.5) * grid.spacing)

    def label(self, grid: Grid) -> str:
        return f"{AXES[self.axis]} = {self.place(grid):.4g} m"


def read_slice(text: str | None, grid: Grid) -> Slice | None:
    """`axis=index` as a slice, the middle along z if not given; None in 2D. Raises InputError."""
    if grid.dimension == 2:
        if text is not None:
            raise bad_input("--slice", text, "needs a scene in 3D")
        return None
    if text is None:
        return Slice(2, grid.shape[2] // 2)
    name, _, number = (part.strip() for part in text.partition("="))
    if name not in AXES or not (number.isascii() and number.isdigit()):
        raise bad_input("--slice", text, "must be axis=index, as in z=4", AXES)
    axis, index = AXES.index(name), int(number)
    if index >= grid.shape[axis]:
        rule = f"has no such cell: the index along {name} must be at most {grid.shape[axis] - 1}"
        raise bad_input("--slice", text, rule)
    return Slice(axis, index)


def shown_axes(layer: Slice | None) -> tuple[int, int]:
    """The axes that a picture shows across and up."""
    if layer is None:
        return 0, 1
    across, up = (axis for axis in range(3) if axis != layer.axis)
    return across, up


def in_space(directions: Array, layer: Slice | None) -> Array:
    """Directions (K, 2) in a picture's plane as (K, dimension)."""
    return directions if layer is None else np.insert(directions, layer.axis, 0.0, axis=1)


def cut(values: NDArray[Any], layer: Slice | None) -> NDArray[Any]:
    """Arrays (..., *shape) of cells, in 3D the layer alone."""
    return values if layer is None else np.take(values, layer.cell, axis=layer.axis - 3)


def plane_data(scene: Scene, layer: Slice | None, grid: Grid | None = None) -> xr.Dataset:
    """What pictures of a scene have in common: the middles of cells [m] along two named axes, and
    `lights` and `walls` (line, end, coordinate) [m] as lines, in 3D where the plane through the
    middles of the layer's cells cuts them. grid: of the cells, if it is not the scene's.
    """
    grid, shown = grid or scene.grid, shown_axes(layer)
    coords = {
        AXES[axis]: grid.origin[axis] + (np.arange(grid.shape[axis]) + 0.5) * grid.spacing
        for axis in shown
    }
    emitters = [light.emitter.points for light in scene.lights if isinstance(light, AreaLight)]
    corners = [np.array([wall.start, wall.stop]) for wall in scene.segments()]
    corners += [facet.vertices for facet in scene.facets()]
    lines = {
        name: ((name[:-1], "end", "coordinate"), _lines(polygons, grid, layer), {"units": "m"})
        for name, polygons in (("lights", emitters), ("walls", corners))
    }
    data = xr.Dataset(lines, coords)
    data.attrs = {"across": AXES[shown[0]], "up": AXES[shown[1]], "spacing": grid.spacing}
    data.attrs["place"] = layer.label(grid) if layer else ""
    return data


def _lines(polygons: Sequence[Array], grid: Grid, layer: Slice | None) -> Array:
    """Segments (2, 2), or where a plane cuts polygons (V, 3), as (L, 2, 2)."""
    if layer is None:
        return np.reshape(polygons, (-1, 2, 2))
    slack = _IN_PLANE * grid.spacing
    found = [section(each, layer.axis, layer.place(grid), slack) for each in polygons]
    return np.concatenate([np.empty((0, 2, 2)), *found])


def section(polygon: Array, axis: int, place: float, slack: float = 0.0) -> Array:
    """Lines (L, 2, 2) in which the plane x[axis] = place cuts a planar polygon (V, 3).

    A polygon in the plane is cut in all of its edges. slack: how near the plane counts as in it.
    """
    height = polygon[:, axis] - place
    height = np.where(np.abs(height) <= slack, 0.0, height)
    if height.min() > 0 or height.max() < 0:
        return np.empty((0, 2, 2))
    flat = np.delete(polygon, axis, axis=1)
    after, next_height = np.roll(flat, -1, axis=0), np.roll(height, -1)
    lying = (height == 0) & (next_height == 0)
    crossing = (height > 0) != (next_height > 0)
    part = height[crossing] / (height - next_height)[crossing]
    points = flat[crossing] + part[:, None] * (after - flat)[crossing]
    # Along the line of the cut, inside and outside take turns.
    along = np.argmax(np.ptp(points, axis=0)) if len(points) else 0
    pairs = points[np.argsort(points[:, along], kind="stable")].reshape(-1, 2, 2)
    pairs = pairs[np.any(pairs[:, 0] != pairs[:, 1], axis=1)]
    return np.concatenate([pairs, np.stack([flat, after], axis=1)[lying]])


def extent_of(data: xr.Dataset) -> tuple[float, float, float, float]:
    """Outer borders of the cells [m]: left, right, lower, upper."""
    half = float(data.attrs["spacing"]) / 2
    sides: Iterable[Array] = (data[data.attrs[name]].values for name in ("across", "up"))
    left, right, lower, upper = (
        float(end) for side in sides for end in (side[0] - half, side[-1] + half)
    )
    return left, right, lower, upper
