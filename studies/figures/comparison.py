"""The picture of a comparison: lobes in every cell, or flux maps where cells are too many."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from flatland.results import versions
from flatland.scene import scene_to_toml
from studies.comparison import Comparison
from studies.figures.lobes import draw_lobes, draw_scene, legend_entries
from studies.figures.slices import Slice, cut, extent_of, in_space, plane_data
from studies.reference import DIRECTIONS, even_directions
from studies.style import COLUMN

#: Longest side, in cells, of a grid whose lobes can still be told apart in a column.
LARGEST_FOR_LOBES = 20


def comparison_data(comparison: Comparison, layer: Slice | None = None) -> xr.Dataset:
    """Intensities [W/rad, W/sr in 3D] over direction for every cell and method, and fluxes [W].

    Directions are angles of travel [rad] in the picture's plane, from its axis across. In 3D only
    cells of the layer are in it, and directions that lie in its plane. Colours are added up.
    `intensity` and `flux` are NaN for a method and band count that did not run.
    """
    data = plane_data(comparison.scene, layer)
    unit = even_directions(2, DIRECTIONS[2])
    directions = in_space(unit, layer)
    names = list(dict.fromkeys(run.method.propagator.name for run in comparison.runs))
    bands = sorted({run.method.bands for run in comparison.runs})
    cells = tuple(data.sizes[data.attrs[name]] for name in ("across", "up"))
    intensity = np.full((len(names), len(bands), len(unit), *cells), np.nan)
    flux, errors = (np.full((len(names), len(bands), *each), np.nan) for each in (cells, ()))
    for run, measured in zip(comparison.runs, comparison.errors):
        place = names.index(run.method.propagator.name), bands.index(run.method.bands)
        field = run.accumulated
        light = _grey(comparison, cut(field.values.astype(float), layer))
        intensity[place] = np.tensordot(field.basis.evaluate(directions), light, axes=1)
        flux[place] = light[0] * field.basis.flux_weight
        errors[place] = measured["coefficients"]
    reference = comparison.reference
    exact = _grey(comparison, cut(reference.intensity_at(directions), layer))
    exact_flux = _grey(comparison, cut(reference.field(1).scalar_flux(), layer))
    unit_of = {"units": "W/rad" if layer is None else "W/sr"}
    axes = (data.attrs["across"], data.attrs["up"])
    dims = ("scheme", "bands", "direction", *axes)
    data = data.assign(
        exact=(dims[2:], exact, unit_of),
        exact_flux=(axes, exact_flux, {"units": "W"}),
        intensity=(dims, intensity, unit_of),
        flux=((*dims[:2], *axes), flux, {"units": "W"}),
        relative_l2=(dims[:2], errors),
    )
    angles = np.arctan2(unit[:, 1], unit[:, 0]) % (2 * np.pi)
    data = data.assign_coords(scheme=names, bands=bands, direction=angles)
    data.attrs |= {
        "scene": scene_to_toml(comparison.scene),
        "title": comparison.scene.title,
        "methods": json.dumps([run.method.as_dict() for run in comparison.runs], default=str),
        "versions": json.dumps(versions(), sort_keys=True),
    }
    return data


def draw_comparison(data: xr.Dataset) -> Figure:
    """One panel per number of bands, one under another, a column wide."""
    columns, rows = _sides(data)
    if max(columns, rows) > LARGEST_FOR_LOBES:
        return _draw_flux(data)
    bands = [int(n) for n in data["bands"].values]
    names = [str(name) for name in data["scheme"].values]
    height = 0.35 + len(bands) * (0.86 * COLUMN * rows / columns + 0.42)
    figure = Figure(figsize=(COLUMN, height), layout="constrained")
    for axes, n in zip(figure.subplots(len(bands), squeeze=False)[:, 0], bands):
        draw_lobes(axes, data, n)
        place = data.attrs["place"]
        axes.set_title(f"{n} bands" + (f", {place}" if place else ""))
    figure.legend(handles=legend_entries(names), loc="outside upper center", ncols=len(names) + 1)
    return figure


def _draw_flux(data: xr.Dataset) -> Figure:
    """Scalar flux of every method and of the exact answer, on one logarithmic scale."""
    exact = data["exact_flux"].values
    columns = ["exact", *[str(name) for name in data["scheme"].values]]
    bands = [int(n) for n in data["bands"].values]
    top = float(exact.max()) or 1.0
    scale = LogNorm(top * 1e-4, top)
    across, up = _sides(data)
    wide, tall = COLUMN * 0.6, COLUMN * 0.6 * up / across + 0.2
    size = (wide * len(columns) + 0.6, tall * len(bands) + 0.2)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(len(bands), len(columns), squeeze=False)
    for row, n in zip(grid, bands):
        for axes, name in zip(row, columns):
            flux = exact if name == "exact" else data["flux"].sel(scheme=name, bands=n).values
            shown = np.maximum(flux.T, top * 1e-4)
            image = axes.imshow(shown, origin="lower", extent=extent_of(data), norm=scale)
            draw_scene(axes, data, cells=False)
            axes.set_title(name.upper() if name != "exact" else "exact")
            axes.set_ylabel("")
        row[0].set_ylabel(f"{n} bands: {data.attrs['up']} [m]")
    if data.attrs["place"]:
        figure.suptitle(data.attrs["place"])
    figure.colorbar(image, ax=grid, label="flux that leaves a cell [W]", aspect=40, pad=0.01)
    return figure


def _sides(data: xr.Dataset) -> tuple[int, int]:
    """Numbers of cells across and up."""
    across, up = (data.sizes[data.attrs[name]] for name in ("across", "up"))
    return across, up


def _grey(comparison: Comparison, values: np.ndarray) -> np.ndarray:
    """Colours, if any, added up."""
    return values.sum(axis=0) if comparison.scene.colours else values
