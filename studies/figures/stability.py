"""When does light grow? The spectral radius of every scheme, and the engine itself.

From the study `stability`. The maps hold every combination of options that is a stencil of its
own, without clamping (whose linear twin it shares); hatched cells grow. The curves are the norm of
the light over real steps on a grid with open borders, from light in every cell at random: it fades
through the border, unless it grows faster. Points are float32, lines float64.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from flatland.stability import RADIUS_TOLERANCE
from studies.figures.curves import legend_above, present
from studies.figures.workshop import Workshop, good_rows
from studies.style import COLUMN, Style, line_of

PARTS = ("radius", "growth")
#: Height of a line of the map [inch].
_LINE = 0.135
#: Radius of the darkest red.
_DARKEST = 1.6


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    rows = workshop.study("stability")
    return {
        "radius": good_rows(rows, kind="radius", clamped=False),
        "growth": good_rows(rows, kind="growth"),
    }


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    radius = data["radius"]
    maps = {
        f"map-{dimension}d": _map(radius.isel(row=radius["dimension"].values == dimension))
        for dimension in present(radius, "dimension")
    }
    return {**maps, "growth": _growth(data["growth"])}


def _map(rows: xr.Dataset) -> Figure:
    schemes, bands = present(rows, "scheme"), present(rows, "bands")
    radius = np.full((len(schemes), len(bands)), np.nan)
    places = zip(rows["scheme"].values, rows["bands"].values.tolist(), rows["radius"].values)
    for scheme, count, value in places:
        radius[schemes.index(scheme), bands.index(count)] = value
    figure = Figure(figsize=(COLUMN, _LINE * len(schemes) + 0.5), layout="constrained")
    axes = figure.subplots()
    axes.imshow(radius, cmap="RdBu_r", norm=TwoSlopeNorm(1, 0, _DARKEST), aspect="auto", alpha=0.5)
    for (row, column), value in np.ndenumerate(radius):
        _cell(axes, column, row, value)
    axes.set_yticks(range(len(schemes)), [short_name(str(name)) for name in schemes], fontsize=4.6)
    axes.set_xticks(range(len(bands)), [str(count) for count in bands])
    axes.tick_params(length=0)
    axes.set_xlabel("bands n")
    dimension = int(rows["dimension"][0])
    figure.suptitle(f"spectral radius ρ in {dimension}D; hatched: light grows", fontsize=7)
    return figure


def _cell(axes: Axes, column: int, row: int, value: float) -> None:
    grows = value > 1 + RADIUS_TOLERANCE
    if grows:
        box = Rectangle((column - 0.5, row - 0.5), 1, 1, hatch="////", fill=False, linewidth=0)
        box.set_edgecolor("#00000050")
        axes.add_patch(box)
    text = "–" if np.isnan(value) else f"{value:.3f}".rstrip("0").rstrip(".")
    weight = "bold" if grows else "normal"
    axes.text(column, row, text, ha="center", va="center", fontsize=4.6, weight=weight)


def short_name(scheme: str) -> str:
    """`lpv(flux='central', clamp=True)` as `lpv central, clamp`."""
    name, _, rest = scheme.partition("(")
    pairs = [part.partition("=") for part in rest.rstrip(")").split(", ") if part]
    values = [key if value == "True" else value.strip("'") for key, _, value in pairs]
    return f"{name} {', '.join(values)}".strip()


def _growth(rows: xr.Dataset) -> Figure:
    """Left: many steps of some schemes. Right: growth comes closer to ρ on larger grids."""
    figure = Figure(figsize=(COLUMN, 0.62 * COLUMN), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1.5, 1])
    chosen = rows.isel(
        row=(rows["start"].values == "random") & (rows["side"].values == _side(rows))
    )
    most = int(chosen["bands"].max())
    chosen = chosen.isel(row=chosen["bands"].values == most)
    # A clamped scheme's curve covers that of its linear twin.
    drawn = [str(name) for name in present(chosen, "scheme") if "clamp" not in str(name)]
    entries = [_norms(left, chosen, name) for name in drawn]
    left.set_xscale("log")
    left.set_yscale("log")
    left.set_ylim(1e-13, 1e13)
    left.set_xlim(0.8, 1200)
    left.set_xlabel("steps")
    left.set_ylabel("newest light over first, L2")
    left.set_title(f"random start, {most} bands")
    _approach(right, rows, most)
    legend_above(figure, entries, 3)
    return figure


def _side(rows: xr.Dataset) -> int:
    """The grid that most runs were on."""
    sides, counts = np.unique(rows["side"].values, return_counts=True)
    return int(sides[np.argmax(counts)])


def _norms(axes: Axes, rows: xr.Dataset, scheme: str) -> Line2D:
    own = rows.isel(row=rows["scheme"].values == scheme)
    line = line_of(str(own["propagator"].values[0]))
    plain = "(" not in scheme
    for precision in present(own, "precision"):
        some = own.isel(row=own["precision"].values == precision)
        longest = some["case"].values[int(np.argmax(some["iterations"].values))]
        some = some.isel(row=some["case"].values == longest).sortby("iterations")
        norms = np.where(some["norm"].values > 0, some["norm"].values, np.nan)
        if precision == "float32":
            marks: Style = {"marker": line.marker, "markersize": 2, "linestyle": ""}
            axes.plot(some["iterations"], norms, color=line.colour, **marks)
        else:
            dashes = "-" if plain else (0, (2, 1))
            axes.plot(some["iterations"], norms, color=line.colour, linestyle=dashes)
    return Line2D(
        [], [], color=line.colour, linestyle="-" if plain else (0, (2, 1)), marker=line.marker,
        markersize=2, label=short_name(scheme),
    )  # fmt: skip


def _approach(axes: Axes, rows: xr.Dataset, bands: int) -> None:
    """Measured growth of what grows, by size of the grid, and the radius it stays below."""
    wild = rows.isel(
        row=rows["wild"].values
        & (rows["bands"].values == bands)
        & (rows["start"].values == "random")
        & (rows["precision"].values == "float64")
    )
    for scheme in present(wild, "scheme"):
        own = wild.isel(row=wild["scheme"].values == scheme).sortby("side")
        line = line_of(str(own["propagator"].values[0]))
        style: Style = {"marker": line.marker, "markersize": 2.6, "color": line.colour}
        axes.plot(own["side"], own["growth"], linestyle=(0, (2, 1)), **style)
        axes.axhline(float(own["radius"][0]), color="black", linewidth=0.5, linestyle=":")
    axes.set_xscale("log", base=2)
    sides = sorted(set(wild["side"].values.tolist()))
    axes.set_xticks(sides, [str(side) for side in sides])
    axes.set_xlabel("cells along a side")
    axes.set_ylabel("growth a step")
    axes.set_title("dotted: ρ")
