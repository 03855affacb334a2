"""Cells drawn as polar plots of the intensity that leaves them."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from studies.figures.slices import extent_of
from studies.style import LINES, line_of

Array = NDArray[np.float64]

#: Lobes of a cell are scaled together, so that methods can be compared in it; cells among each
#: other by this power of their brightness: in proportion, all but the cells at the lights would
#: vanish.
_COMPRESSION = 0.06
#: Radius of the brightest lobe, in cells.
_LARGEST = 0.49
#: Cells darker than this, relative to the brightest, are left empty.
_DARK = 1e-6
#: Lines of a picture, one layer over another. Walls have a halo, to be seen in dark rooms.
_LAYERS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("walls", {"colors": "#a0a0a0", "linewidths": 1.8, "capstyle": "projecting"}),
    ("lights", {"colors": "#e6b800", "linewidths": 1.8, "capstyle": "butt"}),
    ("walls", {"colors": "black", "linewidths": 1.2, "capstyle": "projecting"}),
)


def draw_lobes(axes: Axes, data: xr.Dataset, bands: int) -> None:
    """Exact intensity in grey, every method's as a line; negative parts are not drawn.

    data: as `comparison_data` makes it. Lengths in metres. In 3D lobes are true slices of the
    spherical function: the intensity in the directions that lie in the picture's plane.
    """
    methods = data["intensity"].sel(bands=bands)
    exact = data["exact"].values
    size = _sizes(exact, methods.values)
    angles = data["direction"].values
    middles = (data[data.attrs[name]].values for name in ("across", "up"))
    centres = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1)
    spacing = float(data.attrs["spacing"])
    outline = _outlines(np.maximum(exact, 0) * size * spacing, angles, centres)
    axes.add_collection(PolyCollection(outline, facecolors=LINES["analytic"].colour, linewidths=0))
    for name in methods["scheme"].values:
        line, values = line_of(str(name)), methods.sel(scheme=name).values * size * spacing
        curves = _outlines(np.maximum(values, 0), angles, centres)
        lines = LineCollection(curves, colors=line.colour, linewidths=line.width)
        lines.set_linestyle(line.dashes)
        axes.add_collection(lines)
    draw_scene(axes, data)


def draw_scene(axes: Axes, data: xr.Dataset, cells: bool = True) -> None:
    """Borders of cells if wanted, lights and occluders; equal scales and names of axes in metres.

    data: as `plane_data` makes it.
    """
    left, right, lower, upper = extent_of(data)
    if cells:
        box: dict[str, Any] = {"color": "#d0d0d0", "linewidth": 0.3, "zorder": 0}
        columns, rows = (data.sizes[data.attrs[name]] + 1 for name in ("across", "up"))
        axes.vlines(np.linspace(left, right, columns), lower, upper, **box)
        axes.hlines(np.linspace(lower, upper, rows), left, right, **box)
    for name, look in _LAYERS:
        axes.add_collection(LineCollection(list(data[name].values), **look))
    axes.set_xlim(left, right)
    axes.set_ylim(lower, upper)
    axes.set_aspect("equal")
    axes.set_xlabel(f"{data.attrs['across']} [m]")
    axes.set_ylabel(f"{data.attrs['up']} [m]")


def legend_entries(names: list[str]) -> list[Patch | Line2D]:
    """Handles for a legend of the exact answer and of methods."""
    entries: list[Patch | Line2D] = [Patch(color=LINES["analytic"].colour, label="exact")]
    for name in names:
        line = line_of(name)
        entry = Line2D([], [], label=name.upper(), color=line.colour, linewidth=line.width)
        entry.set_linestyle(line.dashes)
        entries.append(entry)
    return entries


def _sizes(exact: Array, methods: Array) -> Array:
    """Radius per unit of intensity, (nx, ny)."""
    largest = np.maximum(np.abs(exact).max(axis=0), np.abs(methods).max(axis=(0, 1)))
    top = float(largest.max()) or 1.0
    lit = largest > _DARK * top
    relative = np.where(lit, largest / top, 1.0)
    return np.where(lit, _LARGEST * relative**_COMPRESSION / (relative * top), 0.0)


def _outlines(radii: Array, angles: Array, centres: Array) -> list[Array]:
    """Closed curves (K + 1, 2), one per cell with any light; radii (K, nx, ny)."""
    closed = np.concatenate([radii, radii[:1]])
    theta = np.append(angles, angles[0])
    unit = np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    lit = radii.max(axis=0) > 0
    curves = closed[:, lit].T[..., None] * unit + centres[lit][:, None, :]
    return list(curves)
