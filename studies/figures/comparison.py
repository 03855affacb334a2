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
from studies.style import COLUMN

#: Longest side, in cells, of a grid whose lobes can still be told apart in a column.
LARGEST_FOR_LOBES = 20


def comparison_data(comparison: Comparison) -> xr.Dataset:
    """Intensities [W/rad] over direction (angle of travel from +x [rad]) for every cell and method.

    Colours are added up. `intensity` is NaN for a method and band count that did not run.
    """
    reference, grid = comparison.reference, comparison.scene.grid
    angles = np.arctan2(reference.directions[:, 1], reference.directions[:, 0]) % (2 * np.pi)
    names = list(dict.fromkeys(run.method.propagator.name for run in comparison.runs))
    bands = sorted({run.method.bands for run in comparison.runs})
    values = np.full((len(names), len(bands), len(angles), *grid.shape), np.nan)
    errors = np.full((len(names), len(bands)), np.nan)
    for run, measured in zip(comparison.runs, comparison.errors):
        place = names.index(run.method.propagator.name), bands.index(run.method.bands)
        values[place] = _grey(run.accumulated.evaluate(reference.directions), len(grid.shape))
        errors[place] = measured["coefficients"]
    axes = ("x", "y")
    dims = ("scheme", "bands", "direction", *axes)
    data = xr.Dataset(
        {
            "exact": (dims[2:], _grey(reference.intensity, len(grid.shape)), {"units": "W/rad"}),
            "intensity": (dims, values, {"units": "W/rad"}),
            "relative_l2": (dims[:2], errors),
        },
        coords={
            "scheme": names,
            "bands": bands,
            "direction": angles,
            "x": grid.origin[0] + (np.arange(grid.shape[0]) + 0.5) * grid.spacing,
            "y": grid.origin[1] + (np.arange(grid.shape[1]) + 0.5) * grid.spacing,
        },
    )
    data.attrs = {
        "scene": scene_to_toml(comparison.scene),
        "title": comparison.scene.title,
        "spacing": grid.spacing,
        "methods": json.dumps([run.method.as_dict() for run in comparison.runs], default=str),
        "versions": json.dumps(versions(), sort_keys=True),
    }
    return data


def draw_comparison(data: xr.Dataset) -> Figure:
    """One panel per number of bands, one under another, a column wide."""
    if max(data.sizes["x"], data.sizes["y"]) > LARGEST_FOR_LOBES:
        return _draw_flux(data)
    bands = [int(n) for n in data["bands"].values]
    names = [str(name) for name in data["scheme"].values]
    ratio = data.sizes["y"] / data.sizes["x"]
    height = 0.35 + len(bands) * (0.86 * COLUMN * ratio + 0.42)
    figure = Figure(figsize=(COLUMN, height), layout="constrained")
    for axes, n in zip(figure.subplots(len(bands), squeeze=False)[:, 0], bands):
        draw_lobes(axes, data, n)
        axes.set_title(f"{n} bands")
        axes.set_ylabel("y [m]")
        axes.set_xlabel("x [m]")
    figure.legend(handles=legend_entries(names), loc="outside upper center", ncols=len(names) + 1)
    return figure


def _draw_flux(data: xr.Dataset) -> Figure:
    """Scalar flux of every method and of the exact answer, on one logarithmic scale."""
    angle = 2 * np.pi / data.sizes["direction"]
    exact = data["exact"].values.sum(axis=0) * angle
    columns = ["exact", *[str(name) for name in data["scheme"].values]]
    bands = [int(n) for n in data["bands"].values]
    top = float(exact.max()) or 1.0
    scale = LogNorm(top * 1e-4, top)
    wide = COLUMN * 0.6
    tall = wide * data.sizes["y"] / data.sizes["x"] + 0.2
    size = (wide * len(columns) + 0.6, tall * len(bands) + 0.2)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(len(bands), len(columns), squeeze=False)
    for row, n in zip(grid, bands):
        for axes, name in zip(row, columns):
            if name == "exact":
                flux = exact
            else:
                flux = data["intensity"].sel(scheme=name, bands=n).values.sum(axis=0) * angle
            extent = _extent(data)
            shown = np.maximum(flux.T, top * 1e-4)
            image = axes.imshow(shown, origin="lower", extent=extent, norm=scale)
            draw_scene(axes, data, cells=False)
            axes.set_title(name.upper() if name != "exact" else "exact")
            axes.set_xlabel("x [m]")
        row[0].set_ylabel(f"{n} bands: y [m]")
    figure.colorbar(image, ax=grid, label="flux that leaves a cell [W]", aspect=40, pad=0.01)
    return figure


def _extent(data: xr.Dataset) -> tuple[float, float, float, float]:
    half = float(data.attrs["spacing"]) / 2
    x, y = data["x"].values, data["y"].values
    return (float(x[0] - half), float(x[-1] + half), float(y[0] - half), float(y[-1] + half))


def _grey(values: np.ndarray, dimension: int) -> np.ndarray:
    """Colours, if any, added up."""
    return values.sum(axis=0) if values.ndim == dimension + 2 else values
