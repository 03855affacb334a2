"""A field between its cell centres."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.field import Field

Array = NDArray[np.float64]


def interpolate(field: Field, points: ArrayLike) -> Array:
    """Coefficients ([colours,] M, size) at world points, bi- or trilinear between cell centres.

    Between the outermost centres and the border the outermost cells count alone. Raises InputError
    for points outside the grid. What it gets wrong: it knows no walls, so that half a cell from
    one it mixes the light of both sides.
    """
    return lookup(field, places_in(field, points))


def lookup(field: Field, points: Array) -> Array:
    """`interpolate` without the check: points outside get the nearest cells' light."""
    last = np.array(field.grid.shape) - 1
    cells = np.clip(field.grid.to_cells(points) - 0.5, 0, last)
    base = np.floor(cells).astype(np.int64)
    part = cells - base
    shape = field.values.shape[: -field.grid.dimension]
    result = np.zeros((*shape, len(points)))
    for corner in product((0, 1), repeat=field.grid.dimension):
        weight = np.prod(np.where(corner, part, 1 - part), axis=1)
        index = tuple(np.minimum(base + corner, last).T)
        result += weight * field.values[(..., *index)]
    return np.moveaxis(result, -2, -1)


def places_in(field: Field, points: ArrayLike) -> Array:
    """Points (M, dimension) [m], checked to lie in the grid."""
    places = np.asarray(points, float)
    if places.ndim != 2 or places.shape[1] != field.grid.dimension:
        raise bad_input("points", places.shape, f"must be (M, {field.grid.dimension})")
    outside = ~field.grid.contains(places)
    if np.any(outside):
        rule = f"lies outside the grid from {field.grid.origin} to {field.grid.upper}"
        raise bad_input("points", places[outside][0].tolist(), rule)
    return places


def unit_vectors(field: Field, vectors: ArrayLike, count: int, argument: str) -> Array:
    """(count, dimension), from as many or from one for all, checked to be of length 1."""
    unit = np.asarray(vectors, float)
    shape = (count, field.grid.dimension)
    if unit.shape not in (shape, shape[1:]):
        raise bad_input(argument, unit.shape, f"must be of shape {shape} or {shape[1:]}")
    if not np.all(np.abs(np.linalg.norm(unit, axis=-1) - 1) < 1e-6):
        raise bad_input(argument, vectors, "must be finite and of length 1")
    return np.broadcast_to(unit, shape)
