"""Mirror reflections of a field, by marching along the reflected ray.

Kaplanyan & Dachsbacher 2010, section 7: the light that a glossy surface reflects comes from along
the mirrored view ray r; march through the volume along it and average the intensity I(-r) of the
cells, over the squared distance to each; four cells are enough. The idea is to go back in time:
cells further along the ray hold the same light before it was smeared out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flatland.errors import bad_input
from flatland.field import Field
from flatland.lookup import lookup, places_in, unit_vectors
from flatland.radiance import radiance_weights
from flatland.rays import free_lengths
from flatland.sources import Wall

Array = NDArray[np.float64]
Method = Literal["cross-section", "distance"]
METHODS: tuple[Method, ...] = get_args(Method)


def mirrored(directions: ArrayLike, normals: ArrayLike) -> Array:
    """Directions (..., dimension) after reflection by surfaces with unit normals, d - 2(d·n)n."""
    way, normal = np.asarray(directions, float), np.asarray(normals, float)
    return np.asarray(way - 2 * np.sum(way * normal, axis=-1, keepdims=True) * normal)


def glossy_radiance(
    field: Field,
    points: ArrayLike,
    normals: ArrayLike,
    views: ArrayLike,
    walls: Sequence[Wall] = (),
    method: Method = "cross-section",
    count: int = 4,
    step: float = 1.0,
    start: float = 0.5,
) -> Array:
    """Radiance ([colours,] M) that arrives at surface points along their mirrored view rays.

    A perfect mirror sends it on to the eye; a glossy surface sends on a share. At least 0.
    points: (M, dimension) [m]. normals: unit vectors, to the side that is looked at. views: unit
    vectors from the eye to the points. normals and views may be one for all.
    The field is looked up `count` times on each ray, after start, start + step, ... cells from the
    surface, and the mean is taken. walls (of the scene) and the border end a ray: look-ups beyond
    are left out, and a ray that ends before the first is looked up half-way. Rays that leave the
    grid or enter the surface at once bring nothing.

    cross-section: the mean of radiances, L(-r) = I(-r) / (h^(D-1) χ(r)), see flatland.radiance.
    Radiance does not change along a ray in empty space, so that look-ups at any distance are
    estimates of the same number; a uniform field gives its own.
    distance: the paper's mean of I(-r)/s^(D-1), s the distance. That is the irradiance of points
    that cells are taken for, not a radiance: in a uniform field of radiance L and 4 look-ups it is
    1.17 L (3D) or 0.84 L (2D) times the cross-section, and it goes to zero like 1/count (log(count)
    /count in 2D). The paper says neither where to start nor how to interpolate: half a cell away,
    and linearly, are ours.

    What it gets wrong. A field of n bands knows directions to about π/n: mirror images are blurred
    by that whatever the surface is like. A blocked ray is not lit by the wall that blocks it other
    than through the cells before it. Half a cell from a wall the look-up mixes both of its sides.
    """
    _check(method, count, step, start)
    places = places_in(field, points)
    unit = unit_vectors(field, normals, len(places), "normals")
    rays = mirrored(unit_vectors(field, views, len(places), "views"), unit)
    ends = free_lengths(field.grid, walls, places, rays) / field.grid.spacing
    ends = np.where(np.sum(rays * unit, axis=1) > 0, ends, 0.0)
    weights = _weights(field, rays, method)
    total = np.zeros((*field.values.shape[: -field.grid.dimension - 1], len(places)))
    counts = np.zeros(len(places))
    for number in range(count):
        ways = np.full(len(places), start + number * step)
        if number == 0:
            ways = np.where(ways > ends, 0.5 * ends, ways)
        met = np.flatnonzero((ways <= ends) & (ends > 0))
        total[..., met] += _seen(field, places[met], rays[met], weights[met], ways[met], method)
        counts[met] += 1
    return np.asarray(np.maximum(0.0, total / np.maximum(counts, 1)))


def _weights(field: Field, rays: Array, method: Method) -> Array:
    """What coefficients are multiplied with, (M, size), but for the distance."""
    if method == "cross-section":
        return radiance_weights(field.basis, -rays, field.grid.spacing)
    return field.basis.evaluate(-rays) / field.grid.spacing ** (field.grid.dimension - 1)


def _seen(
    field: Field, places: Array, rays: Array, weights: Array, ways: Array, method: Method
) -> Array:
    """One look-up ([colours,] M) on each ray, `ways` (M,) cells from its start."""
    light = lookup(field, places + (field.grid.spacing * ways)[:, None] * rays)
    fading = 1.0 if method == "cross-section" else ways ** (1 - field.grid.dimension)
    return np.asarray(np.einsum("...mk,mk->...m", light, weights) * fading)


def _check(method: str, count: int, step: float, start: float) -> None:
    if method not in METHODS:
        raise bad_input("method", method, "is no way to march", METHODS)
    if count < 1:
        raise bad_input("count", count, "must be at least 1")
    for argument, value in (("step", step), ("start", start)):
        if not (np.isfinite(value) and value > 0):
            raise bad_input(argument, value, "must be finite and greater than 0")
