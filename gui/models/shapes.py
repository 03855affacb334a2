"""Scene items as things to see, grab, move and turn, by the kinds of value that they declare."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatland.grid import Grid
from gui.models.fields import FieldSpec, specs_of_kind
from gui.models.plane import Plane

Array = NDArray[np.float64]
Table = dict[str, Any]
#: An item: "light" or "occluder", and its place in that list.
Place = tuple[str, int]
#: Length of a drawn direction, in cells.
ARROW = 2.0


@dataclass(frozen=True)
class Handle:
    """A point of an item that can be dragged. at: in the plane [m]. part: index in a list."""

    key: str
    kind: str
    at: tuple[float, float]
    part: int | None = None


@dataclass(frozen=True)
class Outline:
    """How an item is drawn: lines through points (K, 2) in the plane [m], closed or not."""

    lines: tuple[Array, ...]
    closed: bool = False


def outline_of(name: str, table: Mapping[str, Any], grid: Grid, plane: Plane) -> Outline:
    """Where an item is, in the plane; lights from everywhere have no lines."""
    specs = _specs(name, table)
    if points := [np.array(table[s.key], float) for s in specs if s.kind == "points"]:
        return Outline(tuple(plane.project(each) for each in points if each.ndim == 2), True)
    if {"start", "end"} <= table.keys():
        return Outline((plane.project(np.array([table["start"], table["end"]], float)),))
    if {"min", "max"} <= table.keys():
        return Outline((_rectangle(*plane.project(np.array([table["min"], table["max"]]))),), True)
    if {"center", "radius"} <= table.keys():
        angles = np.linspace(0, 2 * np.pi, 49)[:-1]
        circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1) * float(table["radius"])
        return Outline((plane.project(np.array(table["center"], float)) + circle,), True)
    if "cell" in table:
        low = grid.to_world(np.array(table["cell"], float))
        ends = plane.project(np.array([low, low + grid.spacing]))
        return Outline((_rectangle(*ends),), True)
    if "position" in table:
        centre = plane.project(np.array(table["position"], float))
        half = 0.35 * grid.spacing
        return Outline((_rectangle(centre - half, centre + half),), True)
    if "side" in table:
        return Outline(_side(str(table["side"]), table, grid, plane))
    return Outline(())


def _side(side: str, table: Mapping[str, Any], grid: Grid, plane: Plane) -> tuple[Array, ...]:
    """The line along the middle of the cells of a side, if the plane cuts it."""
    names = ("left", "right", "bottom", "top", "back", "front")
    axis, upper = divmod(names.index(side), 2) if side in names else (9, 0)
    if axis not in plane.axes:
        return ()
    along = plane.axes[1 - plane.axes.index(axis)]
    first = int(table.get("first", 0) or 0)
    last = table.get("last")
    ends = np.zeros((2, grid.dimension))
    ends[:, axis] = grid.shape[axis] - 0.25 if upper else 0.25
    ends[:, along] = first, grid.shape[along] if last is None else int(last) + 1
    return (plane.project(grid.to_world(ends)),)


def anchor_of(name: str, table: Mapping[str, Any], grid: Grid, plane: Plane) -> Array:
    """The middle of an item in the plane [m]; the grid's for lights from everywhere."""
    lines = outline_of(name, table, grid, plane).lines
    if not lines:
        return np.asarray(plane.project((np.array(grid.origin) + np.array(grid.upper)) / 2))
    points = np.concatenate(lines)
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def handles_of(name: str, table: Mapping[str, Any], grid: Grid, plane: Plane) -> list[Handle]:
    """Points to drag: ends, corners, the rim of a circle, the tip of a direction."""
    handles = []
    for spec in _specs(name, table):
        value = table.get(spec.key)
        if value is None:
            continue
        if spec.kind == "point":
            handles.append(Handle(spec.key, spec.kind, _pair(plane.project(np.array(value)))))
        elif spec.kind == "points":
            for part, point in enumerate(value):
                at = _pair(plane.project(np.array(point, float)))
                handles.append(Handle(spec.key, spec.kind, at, part))
        elif spec.kind == "length" and "center" in table:
            centre = plane.project(np.array(table["center"], float))
            handles.append(
                Handle(spec.key, spec.kind, _pair(centre + np.array([float(value), 0.0])))
            )
        elif spec.kind == "direction":
            vector = plane.project(np.array(value, float))
            size = float(np.hypot(*vector)) or 1.0
            tip = anchor_of(name, table, grid, plane) + vector / size * ARROW * grid.spacing
            handles.append(Handle(spec.key, spec.kind, _pair(tip)))
    return handles


def drag_handle(
    name: str,
    table: Mapping[str, Any],
    handle: Handle,
    to: Sequence[float],
    grid: Grid,
    plane: Plane,
) -> Table:
    """The keys that change when a handle is dragged to a point in the plane [m]."""
    value = table[handle.key]
    if handle.kind == "point":
        return {handle.key: _placed(value, to, plane)}
    if handle.kind == "points":
        points = [list(point) for point in value]
        points[handle.part or 0] = _placed(points[handle.part or 0], to, plane)
        return {handle.key: points}
    if handle.kind == "length":
        centre = plane.project(np.array(table["center"], float))
        radius = float(np.hypot(*(np.array(to) - centre)))
        return {handle.key: _tidy(max(radius, 1e-3 * grid.spacing))}
    vector = np.array(to, float) - anchor_of(name, table, grid, plane)
    size = float(np.hypot(*vector))
    if size == 0:
        return {}
    return {handle.key: _placed([0.0] * len(value), (vector / size).tolist(), plane)}


def transformed(
    name: str, table: Mapping[str, Any], matrix: Array, about: Array, shift: Array, grid: Grid
) -> Table:
    """The keys of an item after x -> matrix (x - about) + about + shift, all (dimension,) [m].

    Directions are turned, cells go to the cell under their moved centre, kept in the grid. A
    mirror swaps start and end of a light, which emits to its left, and the order of vertices.
    """
    mirrored = np.linalg.det(matrix) < 0
    changes: Table = {}

    def moved(point: Any) -> list[float]:
        place = matrix @ (np.array(point, float) - about) + about + shift
        return [_tidy(x) for x in place]

    for spec in _specs(name, table):
        value = table.get(spec.key)
        if value is None:
            continue
        if spec.kind == "point":
            changes[spec.key] = moved(value)
        elif spec.kind == "points":
            points = [moved(point) for point in value]
            changes[spec.key] = points[::-1] if mirrored else points
        elif spec.kind == "direction":
            changes[spec.key] = [_tidy(x) for x in matrix @ np.array(value, float)]
        elif spec.kind == "cell":
            centre = moved(grid.cell_center(value))
            cell = np.floor(grid.to_cells(centre) + 1e-9).astype(int)
            changes[spec.key] = [int(i) for i in np.clip(cell, 0, np.array(grid.shape) - 1)]
    if {"min", "max"} <= changes.keys():
        ends = np.array([changes["min"], changes["max"]])
        changes["min"], changes["max"] = ends.min(axis=0).tolist(), ends.max(axis=0).tolist()
    if mirrored and name == "light" and {"start", "end"} <= changes.keys():
        changes["start"], changes["end"] = changes["end"], changes["start"]
    return {key: value for key, value in changes.items() if value != _listed(table[key])}


def distance_to(outline: Outline, point: Sequence[float]) -> float:
    """Distance of a point from an item in the plane [m]; 0 inside of what is closed."""
    best = np.inf
    for line in outline.lines:
        ring = np.vstack([line, line[:1]]) if outline.closed else line
        if outline.closed and _inside(line, point):
            return 0.0
        start, along = ring[:-1], np.diff(ring, axis=0)
        square = np.maximum(np.sum(along**2, axis=1), 1e-300)
        part = np.clip(np.sum((np.array(point) - start) * along, axis=1) / square, 0, 1)
        nearest = start + part[:, None] * along
        best = min(best, float(np.hypot(*(nearest - point).T).min()))
    return best


def touches(outline: Outline, low: Array, high: Array) -> bool:
    """Whether all points of an item lie in a rectangle."""
    return bool(outline.lines) and all(
        np.all((line >= low) & (line <= high)) for line in outline.lines
    )


def _inside(polygon: Array, point: Sequence[float]) -> bool:
    (x, y), (a, b) = point, (polygon, np.roll(polygon, -1, axis=0))
    crosses = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(crosses, b[:, 1] - a[:, 1], 1.0)
    at = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return bool(np.count_nonzero(crosses & (x < at)) % 2)


def _specs(name: str, table: Mapping[str, Any]) -> list[FieldSpec]:
    """Keys that the table holds, by kind; 3D points, whose kind nobody named, by their form."""
    specs = specs_of_kind(name, str(table.get("kind")))
    return [_guessed(spec, table[spec.key]) for spec in specs if spec.key in table]


def _guessed(spec: FieldSpec, value: Any) -> FieldSpec:
    if spec.kind != "toml" or not isinstance(value, list | tuple) or not value:
        return spec
    nested = all(isinstance(each, list | tuple) and len(each) in (2, 3) for each in value)
    kind = "points" if nested and len(value) >= 2 else spec.kind
    return FieldSpec(spec.key, kind, spec.meaning, spec.required, spec.default)


def _placed(value: Any, to: Sequence[float], plane: Plane) -> list[float]:
    """A point whose place in the plane is `to`; what points out of the plane stays."""
    result = [float(x) for x in value]
    for axis, place in zip(plane.axes, to):
        result[axis] = _tidy(place)
    return result


def _tidy(value: float) -> float:
    """Without the last digits, which no mouse means."""
    return round(float(value), 9) + 0.0


def _pair(point: Array) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _rectangle(low: Array, high: Array) -> Array:
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])], float)


def _listed(value: Any) -> Any:
    return [_listed(entry) for entry in value] if isinstance(value, list | tuple) else value
