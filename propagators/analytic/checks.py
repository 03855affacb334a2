"""Arguments of the analytic reference, checked at its border, and the form of its answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.scene import Scene

Array = NDArray[np.float64]


def checked_points(argument: str, points: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.asarray(points, float)
    fits = array.ndim == len(shape) and array.shape[-1] == shape[-1]
    if not fits or not np.all(np.isfinite(array)):
        rows = f"finite numbers of shape (K, {shape[-1]})"
        numbers = f"{shape[-1]} finite numbers" if len(shape) == 1 else rows
        raise bad_input(argument, points, f"must be {numbers}")
    return array


def checked_directions(
    directions: ArrayLike, argument: str = "directions", dimension: int = 2
) -> Array:
    unit = np.atleast_2d(np.asarray(directions, float))
    lengths = np.linalg.norm(unit, axis=-1)
    fits = unit.ndim == 2 and unit.shape[1] == dimension
    if not fits or not np.all(np.abs(lengths - 1) < 1e-6):
        raise bad_input(argument, directions, f"must be unit vectors of shape (K, {dimension})")
    return np.ascontiguousarray(unit / lengths[:, None])


def checked_surfaces(points: ArrayLike, normals: ArrayLike, dimension: int) -> tuple[Array, Array]:
    """World points (K, dimension) and as many unit normals."""
    places = checked_points("points", points, (-1, dimension))
    unit = checked_directions(normals, "normals", dimension)
    if len(unit) != len(places):
        raise bad_input("normals", normals, f"must be as many as points: {len(places)}")
    return places, unit


def per_colour(scene: Scene, values: Array) -> Array:
    """Without the leading axis (max(1, colours)) if the scene is grey."""
    return values if scene.colours else values[0]
