"""How far light spreads in a medium, against the truth: moments of where it collides.

Mean square r2 and mean fourth power r4 of the distance between an isotropic pulse and the
collisions of its light in an endless medium, as shares of the exact ones (see `flatland.moments`),
by collisions per cell. r2 is the same for every albedo; r4 is for albedo 0.9. A mean square that is
1 is a diffusion with the right coefficient. LPV's own lobes scatter light where the medium does
not: it needs thick cells.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flatland.grid import Grid
from flatland.harmonics import basis_for
from flatland.medium import Medium
from flatland.medium_step import in_medium
from flatland.moments import Moments, exact_moments, step_moments
from flatland.results import versions
from propagators import create
from propagators.base import StencilPropagator
from propagators.lattice_boltzmann.rules import THICKEST, lattice_moments
from studies.figures.curves import legend_above, panels, plain_log, present
from studies.figures.workshop import Workshop
from studies.style import Style

PARTS = ("rows",)
ALBEDO = 0.9
OPTICAL = tuple(np.geomspace(0.05, 8, 14).tolist())
#: name: how it is drawn.
_STYLES: dict[str, Style] = {
    "lpv, 2 bands": {"color": "#d55e00", "marker": "o"},
    "dom4, 8 bands": {"color": "#0072b2", "marker": "s", "linestyle": (0, (4, 1.5))},
    "dom8, 2 bands": {"color": "#009e73", "marker": "^", "linestyle": (0, (4, 1.2, 1, 1.2))},
    "dom8, 16 bands": {"color": "#009e73", "marker": "v", "linestyle": (0, (1.2, 1.2))},
    "lattice-boltzmann": {"color": "black", "marker": "D"},
    "the same, p = σh": {"color": "#808080", "marker": "x", "linestyle": (0, (6, 1))},
}
#: scheme and bands of the stencils among them; the rule of the probability of the lattices.
_STENCILS = {
    "lpv, 2 bands": ("lpv", 2),
    "dom4, 8 bands": ("dom4", 8),
    "dom8, 2 bands": ("dom8", 2),
    "dom8, 16 bands": ("dom8", 16),
}
_LATTICES = {"lattice-boltzmann": "calibrated", "the same, p = σh": "linear"}
_PYTHON = 'python -c "from studies.figures.medium_moments import {0}; print({0}({1}))"'


class _Row(NamedTuple):
    name: str
    optical: float
    shares: Moments
    command: str


def stencil_shares(name: str, bands: int, optical: float) -> Moments:
    """Of a stencil with its defaults, over the exact ones."""
    scheme = create(name)
    assert isinstance(scheme, StencilPropagator)
    medium = Medium(optical, ALBEDO)
    step = in_medium(scheme.stencil(basis_for(2, bands)), medium, Grid((2, 2)))
    return _shares(step_moments(step), optical)


def lattice_shares(rule: str, optical: float) -> Moments:
    """Of the lattice, over the exact ones."""
    return _shares(lattice_moments(optical, ALBEDO, rule), optical)


def _shares(found: Moments, optical: float) -> Moments:
    return Moments(*(one / other for one, other in zip(found, exact_moments(optical, ALBEDO))))


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    found = list(_rows())
    columns: dict[str, Any] = {
        "method": [row.name for row in found],
        "optical": [row.optical for row in found],
        **{key: [getattr(row.shares, key) for row in found] for key in ("m0", "r2", "r4")},
        "command": [row.command for row in found],
    }
    data = xr.Dataset({name: ("row", values) for name, values in columns.items()})
    data["optical"].attrs["long_name"] = "collisions per cell length"
    for key, meaning in (("m0", "number"), ("r2", "mean square"), ("r4", "fourth power")):
        data[key].attrs["long_name"] = f"{meaning} of collisions, over the exact one"
    data.attrs = {"albedo": ALBEDO, "versions": json.dumps(versions(), sort_keys=True)}
    return {"rows": data}


def _rows() -> Iterator[_Row]:
    for optical in OPTICAL:
        for label, (name, bands) in _STENCILS.items():
            command = _PYTHON.format("stencil_shares", f"'{name}', {bands}, {optical!r}")
            yield _Row(label, optical, stencil_shares(name, bands, optical), command)
        for label, rule in _LATTICES.items():
            if optical <= (THICKEST if rule == "calibrated" else 1.0):
                command = _PYTHON.format("lattice_shares", f"'{rule}', {optical!r}")
                yield _Row(label, optical, lattice_shares(rule, optical), command)


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    rows = data["rows"]
    figure, (left, right) = panels(2, sharex=True, sharey=True, legend=0.42)
    for axes, key in ((left, "r2"), (right, "r4")):
        axes.axhline(1, color="#b0b0b0", linewidth=2.5, zorder=0)
        for name in present(rows, "method"):
            own = rows.isel(row=rows["method"].values == name).sortby("optical")
            axes.plot(own["optical"], own[key], markersize=2, markevery=2, **_STYLES[name])
        plain_log(axes, [0.1, 0.3, 1, 3], "x")
        axes.set_ylim(0, 1.4)
        axes.set_xlabel("collisions per cell, σ h")
    left.set(ylabel="over the exact one", title="mean square")
    right.set_title(f"fourth power, albedo {rows.attrs['albedo']:g}")
    entries = [Line2D([], [], label=name, markersize=2.6, **_STYLES[name]) for name in _STYLES]
    legend_above(figure, entries, 3)
    return {"": figure}
