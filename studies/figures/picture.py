"""One picture of a field: how bright its cells are, in false colours or in its own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flatland.errors import bad_input
from flatland.field import Field
from flatland.grid import Grid
from flatland.scene import Scene, scene_to_toml
from studies.figures.level_borders import draw_level_borders
from studies.figures.lobes import draw_scene
from studies.style import COLUMN

Array = NDArray[np.float64]

_AXES = ("x", "y", "z")
#: Darkest over brightest of what is told apart.
_RANGE = 1e-4
#: Brightness that the mean of the lit cells is brought to before compression.
_KEY = 0.18


class Slice(NamedTuple):
    """A layer of cells of a 3D grid: all cells whose index along `axis` is `cell`."""

    axis: int
    cell: int


def read_slice(text: str | None, grid: Grid) -> Slice | None:
    """`axis=index` as a slice, the middle along z if not given; None in 2D. Raises InputError."""
    if grid.dimension == 2:
        if text is not None:
            raise bad_input("--slice", text, "needs a scene in 3D")
        return None
    if text is None:
        return Slice(2, grid.shape[2] // 2)
    name, _, number = (part.strip() for part in text.partition("="))
    if name not in _AXES or not (number.isascii() and number.isdigit()):
        raise bad_input("--slice", text, "must be axis=index, as in z=4", _AXES)
    axis, index = _AXES.index(name), int(number)
    if index >= grid.shape[axis]:
        rule = f"has no such cell: the index along {name} must be at most {grid.shape[axis] - 1}"
        raise bad_input("--slice", text, rule)
    return Slice(axis, index)


def draw_picture(
    field: Field,
    scene: Scene,
    layer: Slice | None = None,
    index: NDArray[np.integer] | None = None,
) -> Figure:
    """Scalar flux of every cell, a column wide, lengths in metres.

    Three colours are shown as red, green and blue, see `tone_mapped`; one, or any other number
    added up, on a logarithmic scale over four decades, where darker and negative cells count as
    darkest. Outlines of lights and walls are drawn in 2D. layer: as `read_slice` makes it. index:
    the level of an octree that each cell was read from; lines are drawn where levels meet.
    """
    flux = field.scalar_flux()
    if layer is not None:
        flux = np.take(flux, layer.cell, axis=flux.ndim - 3 + layer.axis)
    across, up = (i for i in range(field.grid.dimension) if layer is None or i != layer.axis)
    extent = field.grid.extent
    colour = field.coloured and len(flux) == 3
    width = COLUMN - (0.45 if colour else 0.95)
    height = float(np.clip(width * extent[up] / extent[across], 0.4, 3 * COLUMN)) + 0.55
    figure = Figure(figsize=(COLUMN, height), layout="constrained")
    axes = figure.subplots()
    _show(figure, axes, flux, _edges(field.grid, across, up))
    if index is not None:
        levels = index if layer is None else np.take(index, layer.cell, axis=layer.axis)
        draw_level_borders(axes, levels, _edges(field.grid, across, up))
    if field.grid.dimension == 2:
        outlines = xr.Dataset(attrs={"scene": scene_to_toml(scene)})
        draw_scene(axes, outlines, cells=False)
    axes.set_xlabel(f"{_AXES[across]} [m]")
    axes.set_ylabel(f"{_AXES[up]} [m]")
    axes.set_title(_title(field.grid, scene, layer))
    return figure


def tone_mapped(flux: Array) -> Array:
    """Flux (3, nx, ny) of red, green and blue as sRGB in [0, 1], (nx, ny, 3).

    x / (1 + x) with one exposure for all cells and colours that brings the geometric mean of the
    lit cells to 0.18 (Reinhard et al. 2002, equations 1 to 3), then the sRGB curve.
    """
    light = np.maximum(flux, 0.0)
    # Luminance of linear sRGB (IEC 61966-2-1).
    brightness = np.tensordot([0.2126, 0.7152, 0.0722], light, axes=1)
    lit = brightness[brightness > _RANGE * brightness.max(initial=0.0)]
    exposure = _KEY / np.exp(np.mean(np.log(lit))) if lit.size else 1.0
    shown = light * exposure / (1 + light * exposure)
    curve = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    return np.asarray(np.moveaxis(np.clip(curve, 0, 1), 0, -1))


def _show(
    figure: Figure, axes: Axes, flux: Array, edges: tuple[float, float, float, float]
) -> None:
    """The image and, in false colours, its bar."""
    if flux.ndim == 3 and len(flux) == 3:
        axes.imshow(np.swapaxes(tone_mapped(flux), 0, 1), origin="lower", extent=edges)
        return
    grey = flux.sum(axis=0) if flux.ndim == 3 else flux
    top = max(float(grey.max()), 0.0) or 1.0
    shown = np.maximum(grey.T, top * _RANGE)
    image = axes.imshow(shown, origin="lower", extent=edges, norm=LogNorm(top * _RANGE, top))
    figure.colorbar(image, ax=axes, label="flux that leaves a cell [W]", pad=0.02, extend="min")


def _edges(grid: Grid, across: int, up: int) -> tuple[float, float, float, float]:
    return (grid.origin[across], grid.upper[across], grid.origin[up], grid.upper[up])


def _title(grid: Grid, scene: Scene, layer: Slice | None) -> str:
    if layer is None:
        return scene.title
    place = grid.origin[layer.axis] + (layer.cell + 0.5) * grid.spacing
    return f"{scene.title}{' at ' if scene.title else ''}{_AXES[layer.axis]} = {place:.4g} m"
