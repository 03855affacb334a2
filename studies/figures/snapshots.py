"""Fields at several moments of a run: as lobes in every cell, or as maps of flux."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from flatland.field import Field
from flatland.results import versions
from flatland.scene import Scene, scene_to_toml
from studies.figures.lobes import draw_scene
from studies.figures.slices import plane_data
from studies.style import COLUMN

Array = NDArray[np.float64]

#: Directions that a lobe is drawn with.
_DIRECTIONS = 96
#: The radius of a lobe grows with this power of its intensity, the same in all cells and panels:
#: faint light would vanish in proportion.
_COMPRESSION = 0.35
_LARGEST = 0.48
#: Lobes smaller than this part of the largest are left out.
_FAINTEST = 0.02
POSITIVE, NEGATIVE = "#d55e00", "#0072b2"
#: Darkest over brightest flux of a map.
_RANGE = 1e-4


def snapshot_data(
    scene: Scene, fields: dict[str, Field], commands: Sequence[str], **extra: Any
) -> xr.Dataset:
    """Intensity over direction and scalar flux of each field, by snapshot, with how to get them.

    extra: further variables over the snapshots, each (values, meaning).
    """
    angles = np.linspace(0, 2 * np.pi, _DIRECTIONS, endpoint=False)
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    cells = scene.grid.dimension
    intensity = [_grey(field.evaluate(unit), cells + 1) for field in fields.values()]
    flux = [_grey(field.scalar_flux(), cells) for field in fields.values()]
    data = plane_data(scene, None).assign(
        intensity=(("snapshot", "direction", "x", "y"), intensity, {"units": "W/rad"}),
        flux=(("snapshot", "x", "y"), flux, {"units": "W"}),
        command=("snapshot", list(commands)),
    )
    data = data.assign_coords(snapshot=list(fields), direction=angles)
    for name, (values, meaning) in extra.items():
        data[name] = ("snapshot", np.asarray(values), {"long_name": meaning})
    data.attrs |= {
        "scene": scene_to_toml(scene),
        "title": scene.title,
        "versions": json.dumps(versions(), sort_keys=True),
    }
    return data


def draw_snapshot(axes: Axes, data: xr.Dataset, name: str, window: Sequence[float]) -> None:
    """Lobes of one snapshot in a part of the scene, (left, right, bottom, top) [m].

    Negative intensity, which few bands cannot avoid, is drawn in blue.
    """
    values = data["intensity"].sel(snapshot=name).values
    top = float(np.abs(data["intensity"].values).max()) or 1.0
    spacing = float(data.attrs["spacing"])
    centres = np.stack(np.meshgrid(data["x"].values, data["y"].values, indexing="ij"), axis=-1)
    for sign, colour in ((1.0, POSITIVE), (-1.0, NEGATIVE)):
        part = np.maximum(sign * values, 0) / top
        radii = _LARGEST * spacing * part**_COMPRESSION
        radii[:, radii.max(axis=0) < _FAINTEST * spacing] = 0
        outlines = _outlines(radii, data["direction"].values, centres)
        lobes = PolyCollection(outlines, facecolors=colour, edgecolors="black", linewidths=0.2)
        axes.add_collection(lobes)
    draw_scene(axes, data)
    _crop(axes, window)


def draw_flux(axes: Axes, data: xr.Dataset, name: str, top: float) -> Any:
    """A map of flux over four decades below `top` [W]; gives the image for a colour bar."""
    shown = np.maximum(data["flux"].sel(snapshot=name).values.T, top * _RANGE)
    half = float(data.attrs["spacing"]) / 2
    x, y = data["x"].values, data["y"].values
    extent = (x[0] - half, x[-1] + half, y[0] - half, y[-1] + half)
    image = axes.imshow(shown, origin="lower", extent=extent, norm=LogNorm(top * _RANGE, top))
    draw_scene(axes, data, cells=False)
    axes.set(xlabel="", ylabel="")
    axes.tick_params(labelsize=5)
    return image


def draw_maps(
    data: xr.Dataset, rows: int, columns: int, height: float, title: Callable[[str], str]
) -> tuple[Figure, dict[str, Axes]]:
    """Maps of flux of all snapshots, up to the largest of the last one, and their axes by name.

    height: of the figure, in column widths. title: of a snapshot, below its name.
    """
    names = [str(name) for name in data["snapshot"].values]
    top = float(data["flux"].sel(snapshot=names[-1]).max())
    figure = Figure(figsize=(COLUMN, height * COLUMN), layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, sharey=True)
    for axes, name in zip(grid.flat, names):
        image = draw_flux(axes, data, name, top)
        axes.set_title(f"{name}\n{title(name)}", fontsize=6)
    flux_bar(figure, grid, image)
    return figure, dict(zip(names, grid.flat))


def name_axes(figure: Figure) -> None:
    """Names of the axes, once for all panels."""
    figure.supxlabel("x [m]", fontsize=6)
    figure.supylabel("y [m]", fontsize=6)


def flux_bar(figure: Figure, grid: NDArray[Any], image: Any) -> None:
    """One bar below all maps, and names of axes beside the outer ones."""
    for row in grid:
        row[0].set_ylabel("y [m]", fontsize=6)
    for axes in grid[-1]:
        axes.set_xlabel("x [m]", fontsize=6)
    bar = figure.colorbar(image, ax=grid, location="bottom", aspect=40, pad=0.02)
    bar.set_label("flux that leaves a cell [W]")


def _crop(axes: Axes, window: Sequence[float]) -> None:
    left, right, bottom, top = window
    axes.set(xlim=(left, right), ylim=(bottom, top), xlabel="", ylabel="")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(4, integer=True))
    axes.tick_params(labelsize=5)


def _outlines(radii: Array, angles: Array, centres: Array) -> list[Array]:
    """Closed curves (K, 2), one per cell with any light; radii (K, nx, ny)."""
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    lit = radii.max(axis=0) > 0
    return list(radii[:, lit].T[..., None] * unit + centres[lit][:, None, :])


def _grey(values: Array, dimensions: int) -> Array:
    """Colours, if any, added up."""
    return values.sum(axis=0) if values.ndim > dimensions else values
