"""Figure 2 of the cascaded LPV paper: where light goes, the angles of faces, and where walls are.

Left: a cell's stored light goes to its 4 neighbours. Middle: for one neighbour, the flux onto each
face but the shared one, with the angle it subtends. Right: fuzzy blocking keeps surfels at the
corners of cells (open circles) and reads the two of a face that light passes (filled).
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.figures.faces import (
    LIGHT,
    STORED,
    cell_row,
    draw_arrow,
    draw_cell,
    draw_face,
    draw_lobe,
    draw_wedge,
    face_colours,
    faces_data,
)
from studies.figures.workshop import Workshop
from studies.style import Style

PARTS = ("faces",)


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    return {"faces": faces_data()}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    figure, (left, middle, right) = cell_row(3)
    _neighbours(left)
    _angles(middle, data["faces"])
    _blocking(right)
    titles = ("to the neighbours", "onto their faces", "past the nodes of a face")
    for axes, title in zip((left, middle, right), titles):
        axes.set_title(title, fontsize=6)
    return {"": figure}


def _neighbours(axes: Axes) -> None:
    steps = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    for step in [(0, 0), *steps]:
        draw_cell(axes, step)
    draw_lobe(axes, (0, 0), (0.8, 0.6), LIGHT, 0.46)
    for step in steps:
        draw_arrow(axes, 0.34 * step, 0.85 * step)
    axes.set(xlim=(-1.6, 1.6), ylim=(-1.6, 1.6))


def _angles(axes: Axes, faces: xr.Dataset) -> None:
    draw_cell(axes, (0, 0))
    draw_cell(axes, (1, 0))
    for place, colour in enumerate(face_colours()):
        face = faces.isel(row=place)
        draw_wedge(axes, float(face["start"]), float(face["stop"]), 1.5, colour)
        draw_face(axes, face["centre"].values, face["normal"].values, colour)
        tip = face["centre"].values
        draw_arrow(axes, (0, 0), tip)
        where = tip + [0.42, 0.3] * face["normal"].values
        text = f"{np.degrees(float(face['angle'])):.1f}°"
        axes.text(where[0], where[1], text, fontsize=6, ha="center", va="center")
    axes.set(xlim=(-0.6, 2.2), ylim=(-1.4, 1.4))


def _blocking(axes: Axes) -> None:
    for x in (0, 1):
        for y in (0, 1):
            draw_cell(axes, (x, y))
    corners = np.array([(x - 0.5, y - 0.5) for x in range(3) for y in range(3)])
    plain: Style = {"linestyle": "", "marker": "o", "markersize": 4, "markeredgewidth": 0.7}
    axes.plot(*corners.T, color="black", markerfacecolor="white", **plain)
    read = np.array([(0.5, -0.5), (0.5, 0.5)])
    axes.plot(*read.T, color="black", **plain)
    axes.plot([0.32, 0.75], [0.78, 0.22], color="black", linewidth=1.6)
    draw_lobe(axes, (0.5, 0.5), (-0.79, -0.61), STORED, 0.5)
    draw_arrow(axes, (0.1, 0.0), (0.9, 0.0))
    draw_lobe(axes, (0, 0), (1.0, 0.0), LIGHT, 0.28)
    axes.set(xlim=(-0.7, 1.7), ylim=(-0.7, 1.7))
