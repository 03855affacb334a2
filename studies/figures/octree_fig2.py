"""Figure 2 of the octree thesis: the three steps of light on its way from cell A to cell B.

1: A's light is evaluated towards the middle of each face of B but the shared one. 2: each value
stands for the angle that its face subtends. 3: each flux becomes a clamped-cosine lobe in the
middle of B that points at the face. Flattened to two dimensions, as there.
"""

from __future__ import annotations

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.figures.faces import (
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

PARTS = ("faces",)


def compute(workshop: Workshop) -> dict[str, xr.Dataset]:
    return {"faces": faces_data()}


def draw(data: dict[str, xr.Dataset]) -> dict[str, Figure]:
    figure, grid = cell_row(3)
    for number, (axes, drawing) in enumerate(zip(grid, (_evaluated, _subtended, _sent)), 1):
        draw_cell(axes, (0, 0), "A")
        draw_cell(axes, (1, 0), "B")
        for place, colour in enumerate(face_colours()):
            drawing(axes, data["faces"].isel(row=place), colour)
        axes.set(xlim=(-0.6, 1.7), ylim=(-0.75, 0.75))
        axes.set_title(f"{number}", fontsize=6)
    return {"": figure}


def _evaluated(axes: Axes, face: xr.Dataset, colour: str) -> None:
    draw_face(axes, face["centre"].values, face["normal"].values, colour)
    draw_arrow(axes, (0, 0), face["centre"].values)


def _subtended(axes: Axes, face: xr.Dataset, colour: str) -> None:
    draw_wedge(axes, float(face["start"]), float(face["stop"]), 0.9, colour)
    draw_face(axes, face["centre"].values, face["normal"].values, colour)


def _sent(axes: Axes, face: xr.Dataset, colour: str) -> None:
    draw_face(axes, face["centre"].values, face["normal"].values, colour)
    draw_lobe(axes, (1, 0), face["normal"].values.tolist(), colour, 0.42)
