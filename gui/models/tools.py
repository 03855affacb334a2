"""What the mouse does: tools, and the tables that their strokes make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from flatland.grid import Grid
from gui.models.plane import Plane

Point = tuple[float, float]
Table = dict[str, Any]


class Tool(Enum):
    """Tools by their number keys."""

    INJECT = 1
    OCCLUDE = 2
    ERASE = 3
    PICK_UP = 4
    SELECT = 5
    PAN = 6

    @property
    def label(self) -> str:
        return self.name.capitalize().replace("_", " ")


#: What each tool does, in one line.
MEANINGS = {
    Tool.INJECT: "Draw lights; the right button erases",
    Tool.OCCLUDE: "Draw occluders; the right button erases",
    Tool.ERASE: "Remove what the mouse touches",
    Tool.PICK_UP: "Take kind and strength from an item to draw with",
    Tool.SELECT: "Select, move, and drag handles",
    Tool.PAN: "Move the view; the middle button does so with every tool",
}


@dataclass
class Brush:
    """What is drawn: a kind for each of the lists, and the keys that drawing does not set.

    Strokes: `cell` paints cell by cell, `area` and `segment` run from press to release, `point`
    sits where the button is pressed, `circle` grows from its centre, `polygon` is a rectangle.
    """

    kind: dict[str, str] = field(default_factory=lambda: {"light": "cell", "occluder": "segment"})
    keys: dict[str, Table] = field(default_factory=lambda: {"light": {"flux": 1.0}, "occluder": {}})

    def take(self, name: str, table: Table) -> None:
        """Draw things like this one from now on, if the mouse can draw its kind."""
        if table["kind"] not in STROKES[name]:
            return
        self.kind[name] = table["kind"]
        placed = {"kind", "start", "end", "cell", "position", "center", "radius", "vertices"}
        placed |= {"min", "max"}
        self.keys[name] = {key: value for key, value in table.items() if key not in placed}


#: Kinds that a stroke can draw, in 2D and 3D, with what it sets.
STROKES: dict[str, dict[str, tuple[int, ...]]] = {
    "light": {"cell": (2, 3), "area": (2,), "point": (2, 3)},
    "occluder": {"segment": (2,), "polygon": (2,), "circle": (2,), "box": (3,)},
}


def kinds_for(name: str, dimension: int) -> list[str]:
    """Kinds that can be drawn in a grid of this dimension."""
    return [kind for kind, dimensions in STROKES[name].items() if dimension in dimensions]


def stroke_tables(
    name: str, brush: Brush, path: Sequence[Point], grid: Grid, plane: Plane
) -> list[Table]:
    """The tables that a stroke draws. path: where the mouse was, in the plane [m].

    Nothing for a stroke that has no size yet, or leaves the grid where it may not.
    """
    kind, keys = brush.kind[name], dict(brush.keys[name])
    if kind not in kinds_for(name, grid.dimension):
        kind = kinds_for(name, grid.dimension)[0]
        keys = {"flux": 1.0} if name == "light" else {}
    start, end = np.array(path[0]), np.array(path[-1])
    size = float(np.hypot(*(end - start)))
    if kind == "cell":
        return [{"kind": kind, "cell": list(c), **keys} for c in cells_along(path, grid, plane)]
    if kind == "point":
        inside = cells_along(path[-1:], grid, plane)
        place = [float(x) for x in plane.point(_pair(end), grid)]
        return [{"kind": kind, "position": place, **keys}] if inside else []
    if size < 1e-9 * grid.spacing:
        return []
    if kind in ("area", "segment"):
        return [{"kind": kind, "start": start.tolist(), "end": end.tolist(), **keys}]
    if kind == "circle":
        return [{"kind": kind, "center": start.tolist(), "radius": size, **keys}]
    low, high = np.minimum(start, end), np.maximum(start, end)
    if np.any(high - low < 1e-9 * grid.spacing):
        return []
    if kind == "polygon":
        corners = [low.tolist(), [high[0], low[1]], high.tolist(), [low[0], high[1]]]
        return [{"kind": kind, "vertices": [[float(x) for x in c] for c in corners], **keys}]
    depth, half = plane.depth(grid), 0.5 * grid.spacing
    ends = [plane.lift(_pair(low), depth - half, 3), plane.lift(_pair(high), depth + half, 3)]
    return [{"kind": kind, "min": list(ends[0]), "max": list(ends[1]), **keys}]


def cells_along(path: Sequence[Point], grid: Grid, plane: Plane) -> list[tuple[int, ...]]:
    """Cells of the grid under a path in the plane [m], each once, without holes."""
    places = [_cell_of(point, grid, plane) for point in path]
    walked = places[:1]
    for place in places[1:]:
        walked += line(walked[-1], place)[1:]
    shape = plane.shape(grid)
    inside = [c for c in walked if 0 <= c[0] < shape[0] and 0 <= c[1] < shape[1]]
    return [plane.cell(*place, grid.dimension) for place in dict.fromkeys(inside)]


def line(start: tuple[int, int], end: tuple[int, int]) -> list[tuple[int, int]]:
    """Cells from start to end, each next to the one before (Bresenham 1965)."""
    (x, y), (dx, dy) = start, (abs(end[0] - start[0]), -abs(end[1] - start[1]))
    step_x, step_y = (1 if end[0] > x else -1), (1 if end[1] > y else -1)
    error, cells = dx + dy, [start]
    while (x, y) != end:
        twice = 2 * error
        if twice >= dy:
            error, x = error + dy, x + step_x
        if twice <= dx:
            error, y = error + dx, y + step_y
        cells.append((x, y))
    return cells


def snapped(point: Point, grid: Grid, plane: Plane) -> Point:
    """The nearest corner or middle of a cell's side or of a cell [m]."""
    origin = plane.project(np.array(grid.origin))
    half = 0.5 * grid.spacing
    return _pair(origin + np.round((np.array(point) - origin) / half) * half)


def constrained(start: Point, end: Point) -> Point:
    """The end turned to the nearest multiple of 45 degrees round the start."""
    vector = np.array(end) - np.array(start)
    size = float(np.hypot(*vector))
    angle = np.round(np.arctan2(vector[1], vector[0]) / (np.pi / 4)) * (np.pi / 4)
    return _pair(np.array(start) + size * np.array([np.cos(angle), np.sin(angle)]).round(12))


def _cell_of(point: Point, grid: Grid, plane: Plane) -> tuple[int, int]:
    place = (np.array(point) - plane.project(np.array(grid.origin))) / grid.spacing
    return int(np.floor(place[0])), int(np.floor(place[1]))


def _pair(point: Any) -> Point:
    return float(point[0]), float(point[1])
