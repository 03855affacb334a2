"""Edits of a scene as new texts; nothing is changed until a document takes one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.grid import Grid
from gui.models.fields import FieldSpec, specs_of_kind
from gui.models.plane import Plane
from gui.models.shapes import Place, Table, anchor_of, transformed
from gui.models.toml_text import (
    insert_tables,
    remove_tables,
    tables_of,
    update_table,
    update_tables,
)

Array = NDArray[np.float64]


def add(text: str, name: str, tables: Sequence[Mapping[str, Any]]) -> tuple[str, list[Place]]:
    """The text with more items, and where they stand."""
    first = len(tables_of(text).get(name, []))
    places = [(name, first + i) for i in range(len(tables))]
    return insert_tables(text, name, tables), places


def remove(text: str, places: Iterable[Place]) -> str:
    known = tables_of(text)
    good = [(name, i) for name, i in dict.fromkeys(places) if i < len(known.get(name, []))]
    return remove_tables(text, good) if good else text


def clear(text: str, name: str) -> str:
    """Without any lights, or without any occluders."""
    return remove(text, [(name, i) for i in range(len(tables_of(text).get(name, [])))])


def change(text: str, place: Place, changes: Mapping[str, Any]) -> str:
    """Some keys of one item; REMOVED takes one away."""
    return update_table(text, place, changes)


def move(text: str, places: Iterable[Place], shift: ArrayLike, grid: Grid) -> str:
    """Items moved by a vector (dimension,) [m]."""
    return transform(
        text, places, np.eye(grid.dimension), np.zeros(grid.dimension), grid, np.array(shift, float)
    )


def transform(
    text: str,
    places: Iterable[Place],
    matrix: Array,
    about: Array,
    grid: Grid,
    shift: Array | None = None,
) -> str:
    """Items after x -> matrix (x - about) + about + shift, in world coordinates."""
    moved = np.zeros(grid.dimension) if shift is None else shift
    tables = tables_of(text)
    changes: dict[tuple[str | int, ...], Table] = {
        place: transformed(place[0], tables[place[0]][place[1]], matrix, about, moved, grid)
        for place in places
        if place[1] < len(tables.get(place[0], []))
    }
    return update_tables(text, changes)


def turn_matrix(quarters: int, plane: Plane, dimension: int) -> Array:
    """Rotation in the plane by quarters of a turn, from right towards up."""
    a, b = plane.axes
    matrix = np.eye(dimension)
    cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters % 4]
    matrix[[a, a, b, b], [a, b, a, b]] = cos, -sin, sin, cos
    return matrix


def mirror_matrix(across: int, plane: Plane, dimension: int) -> Array:
    """Mirror along the plane's axis 0 (left to right) or 1 (up to down)."""
    matrix = np.eye(dimension)
    matrix[plane.axes[across], plane.axes[across]] = -1
    return matrix


def middle_of(text: str, places: Iterable[Place], grid: Grid, plane: Plane) -> Array:
    """The middle of items, in world coordinates, on half cells, so that turns keep to the grid."""
    tables = tables_of(text)
    anchors = [
        anchor_of(name, table, grid, plane)
        for name, index in places
        for table in tables.get(name, [])[index : index + 1]
    ]
    if not anchors:
        return (np.array(grid.origin) + np.array(grid.upper)) / 2
    points = np.array(anchors)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = 0.5 * grid.spacing
    origin = plane.project(np.array(grid.origin))
    middle = origin + np.round((middle - origin) / half) * half
    return np.array(plane.point((float(middle[0]), float(middle[1])), grid))


def copied(text: str, places: Iterable[Place]) -> dict[str, list[Table]]:
    """Items as tables, as `paste` takes them."""
    known = tables_of(text)
    tables: dict[str, list[Table]] = {}
    for name, index in sorted(places):
        tables.setdefault(name, []).extend(known.get(name, [])[index : index + 1])
    return tables


def paste(text: str, tables: Mapping[str, Sequence[Table]]) -> tuple[str, list[Place]]:
    """The text with copies of items, and where these stand."""
    places: list[Place] = []
    for name in ("light", "occluder"):
        if entries := tables.get(name):
            text, more = add(text, name, entries)
            places += more
    return text, places


def starting_table(name: str, kind: str, grid: Grid, plane: Plane) -> Table:
    """A new item in the middle of the grid, from what its kind declares."""
    table: Table = {"kind": kind}
    used = 0
    for spec in specs_of_kind(name, kind):
        wanted = spec.required or (kind, spec.key) == ("area", "flux")
        value = _first_value(spec, grid, plane, used)
        if wanted or (spec.optional and spec.kind in ("point", "points") and _fits(spec, value)):
            table[spec.key] = value
            used += spec.kind in ("point", "points")
    return table


def _fits(spec: FieldSpec, value: Any) -> bool:
    """Whether a key takes points of this dimension; kinds for both may have a key for each."""
    try:
        return spec.check is not None and spec.check(value) is not None
    except ValueError:
        return False


def _first_value(spec: FieldSpec, grid: Grid, plane: Plane, used: int) -> Any:
    """A sensible value of one key. used: points that the item has so far."""
    low, size = np.array(grid.origin), np.array(grid.extent)
    middle = low + size / 2
    quarter = 0.25 * float(min(size)) * (1 if grid.dimension == 2 else 0.5)
    unit = np.zeros(grid.dimension)
    unit[plane.axes[0]] = 1.0
    if spec.kind == "point":
        # On quarters of a cell, so that a lamp sits on no border; two points are apart.
        if spec.key == "max" or spec.key == "min":
            return (middle + (quarter if spec.key == "max" else -quarter)).tolist()
        offset = (1 if used else -1) * quarter * unit if spec.key in ("start", "end") else 0.0
        return (middle + offset + (0.25 * grid.spacing if spec.key == "position" else 0)).tolist()
    if spec.kind == "points" or spec.key == "vertices":
        right, up = unit, np.zeros(grid.dimension)
        up[plane.axes[1]] = 1.0
        corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        return [(middle + quarter * (a * right + b * up)).tolist() for a, b in corners]
    values: dict[str, Any] = {
        "cell": [n // 2 for n in grid.shape],
        "direction": unit.tolist(),
        "length": quarter,
        "number": 1.0,
        "per colour": 1.0,
        "whole": 1,
        "truth": False,
        "vector": [0.0] * grid.dimension,
        "text": "",
        "file": "light.npz",
    }
    if spec.kind == "choice":
        return spec.choices[0]
    return values.get(spec.kind, 1.0)
