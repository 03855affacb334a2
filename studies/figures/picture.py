"""One picture of a field: how bright its cells are, in false colours or in its own."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flatland.field import Field
from flatland.scene import Scene
from studies.figures.level_borders import draw_level_borders
from studies.figures.lobes import draw_scene
from studies.figures.slices import Slice, cut, extent_of, plane_data
from studies.style import COLUMN

Array = NDArray[np.float64]

#: Darkest over brightest of what is told apart.
_RANGE = 1e-4
#: Brightness that the mean of the lit cells is brought to before compression.
_KEY = 0.18


def draw_picture(
    field: Field,
    scene: Scene,
    layer: Slice | None = None,
    index: NDArray[np.integer] | None = None,
) -> Figure:
    """Scalar flux of every cell, a column wide, lengths in metres.

    Three colours are shown as red, green and blue, see `tone_mapped`; one, or any other number
    added up, on a logarithmic scale over four decades, where darker and negative cells count as
    darkest. Outlines of lights and walls are drawn; in 3D, where the plane through the middles of
    the layer's cells cuts them. layer: as `read_slice` makes it. index: the level of an octree that
    each cell was read from; lines are drawn where levels meet.
    """
    flux = cut(field.scalar_flux(), layer)
    data = plane_data(scene, layer, field.grid)
    left, right, lower, upper = extent_of(data)
    colour = field.coloured and len(flux) == 3
    width = COLUMN - (0.45 if colour else 0.95)
    tall = width * (upper - lower) / (right - left)
    height = float(np.clip(tall, 0.4, 3 * COLUMN)) + 0.55
    figure = Figure(figsize=(COLUMN, height), layout="constrained")
    axes = figure.subplots()
    _show(figure, axes, flux, (left, right, lower, upper))
    if index is not None:
        draw_level_borders(axes, cut(index, layer), (left, right, lower, upper))
    draw_scene(axes, data, cells=False)
    axes.set_title(" at ".join(part for part in (scene.title, data.attrs["place"]) if part))
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
