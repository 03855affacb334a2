"""One view as a picture: cells in, packed pixels out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatland.field import Field
from flatland.harmonics import AngularBasis
from gui.models.plane import Plane, grey
from gui.render.colours import Packed, Palette, heat_map, hues_on, light_hues, pack
from gui.render.kernel import fill_cells, paint_lobes
from gui.render.scaling import radius_factors, shown_sizes
from gui.render.tables import peaks, pixel_table

#: Below so many pixels a cell's lobe cannot be read: the flux is drawn instead.
LEAST_FOR_LOBES = 6


@dataclass(frozen=True, eq=False)
class Cut:
    """Light in the plane. cells (nx, ny, size) float32; peaks (nx, ny); flux (nx, ny) [W].

    hues: of coloured light (nx, ny, 3), or None.
    """

    basis: AngularBasis
    axes: tuple[int, int]
    cells: NDArray[np.float32]
    peaks: NDArray[np.floating]
    flux: NDArray[np.floating]
    hues: NDArray[np.float64] | None = None


@dataclass(frozen=True, eq=False)
class Layer:
    """A cut as it is drawn. width: of its line [device pixels], 0 if it is filled."""

    cut: Cut
    colour: str
    hued: bool = False
    width: float = 0.0
    opacity: float = 1.0

    def colours(self, window: tuple[slice, slice], palette: Palette) -> Packed:
        """The packed colour of every cell of a window, contiguous."""
        if self.hued and self.cut.hues is not None:
            return np.ascontiguousarray(hues_on(self.cut.hues[window], palette.dark))
        shape = tuple(each.stop - each.start for each in window)
        return np.full(shape, pack(self.colour), np.uint32)


def cut_of(field: Field, plane: Plane, channel: int | None = None) -> Cut:
    """The cut of a field, of all colours together or of one channel."""
    dimension = field.grid.dimension
    cut = plane.cut(grey(field, channel), dimension)
    cells = np.ascontiguousarray(np.moveaxis(cut, 0, -1), dtype=np.float32)
    flux = np.asarray(cut[0], float) * field.basis.flux_weight
    hues = None
    if channel is None and field.coloured and len(field.values) == 3:
        hues = light_hues(np.maximum(plane.cut(field.scalar_flux(), dimension), 0.0))
    sizes = peaks(field.basis, plane.axes, cut)
    return Cut(field.basis, plane.axes, cells, sizes, flux, hues)


@dataclass(frozen=True)
class Scale:
    """How sizes are shown; see gui.render.scaling."""

    top: float = 1.0
    kind: str = "linear"
    decades: float = 4.0
    each: bool = False


def paint(
    layers: list[Layer],
    scale: Scale,
    window: tuple[slice, slice],
    pixels: int,
    palette: Palette,
    heat: str = "off",
    borders: bool = True,
    lobes: bool = True,
) -> Packed:
    """The cells of a window (ranges along right and up) as (ny p, nx p), first row on top.

    The first layer gives the heat map under the lobes; layers are drawn in their order. lobes: draw
    them, or leave them to outlines.
    """
    right, up = window
    count = (right.stop - right.start, up.stop - up.start)
    image = np.empty((count[1] * pixels, count[0] * pixels), np.uint32)
    if heat == "off" or not layers:
        image.fill(pack(palette.paper))
    else:
        under = heat_colours(layers[0].cut, scale, window, palette)
        fill_cells(_faded(under, palette), pixels, image)
    if borders:
        colour = np.uint32(pack(palette.grid))
        image[pixels - 1 :: pixels] = colour
        image[:, ::pixels] = colour
    for layer in layers if lobes else []:
        cut = layer.cut
        table = pixel_table(cut.basis, cut.axes, pixels)
        cells, sizes = cut.cells[window], cut.peaks[window]
        factors = radius_factors(sizes, scale.top, scale.kind, scale.decades, scale.each) * pixels
        # What would not reach half a pixel is not worth a look at its pixels.
        factors[factors * sizes < 0.35] = 0.0
        paint_lobes(
            np.ascontiguousarray(cells),
            factors.astype(np.float32),
            layer.colours(window, palette),
            np.uint32(pack(palette.negative)),
            *table,
            np.float32(layer.width),
            np.float32(layer.opacity),
            image,
        )
    return image


def heat_colours(layer: Cut, scale: Scale, window: tuple[slice, slice], palette: Palette) -> Packed:
    """The flux of each cell as a colour; negative flux in the palette's own."""
    flux = layer.flux[window]
    # A lobe of `top` in all directions fills its cell; so does its flux the map.
    top = scale.top * layer.basis.total_angle / 4
    kind = "logarithmic" if scale.each else scale.kind
    shown = np.clip(shown_sizes(flux, top, kind, scale.decades), 0, 1)
    colours = heat_map()[np.rint(shown * 255).astype(int)]
    dark = flux < -1e-9 * top
    return np.where(dark, np.uint32(pack(palette.negative)), colours)


def _faded(colours: Packed, palette: Palette) -> Packed:
    """The map as a ground for lobes: halfway to the paper."""
    halves = [
        np.asarray(each, np.uint32) >> 1 & 0x7F7F7F for each in (colours, pack(palette.paper))
    ]
    return np.asarray(0xFF000000 | halves[0] + halves[1], np.uint32)
