"""Sets of directions that faces or bins cover: arcs in 2D, spherical polygons in 3D."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flatland.harmonics import AngularBasis, CircularHarmonics, SphericalHarmonics
from propagators.directions import Array, Offsets, angle, perpendicular, unit

#: A corner of a bin of 26 neighbours: as far from (1, 0, 0) as from (1, 1, 0) and (1, 1, 1). The
#: others are its 48 mirror images.
_CORNER_OF_26 = np.array([1.0, np.sqrt(2) - 1, np.sqrt(3) - np.sqrt(2)])
_CORNERS = {6: np.array([1.0, 1.0, 1.0]), 26: _CORNER_OF_26}


class Regions(Protocol):
    """F sets of directions, each in one piece; a basis fits if its dimension does."""

    @property
    def angles(self) -> Array:
        """Size (F,) of each: an angle [rad], or a solid angle [sr]."""

    def integral(self, basis: AngularBasis) -> Array:
        """∫ y dω over each region, (F, size)."""

    def gram(self, basis: AngularBasis) -> Array:
        """∫ y yᵀ dω over each region, (F, size, size)."""

    def middle_values(self, basis: AngularBasis) -> Array:
        """Basis functions (F, size) in the middle of each region, the direction of ∫ ω dω."""


@dataclass(frozen=True, eq=False)
class Arcs:
    """Arcs of the circle of directions, counter-clockwise from starts to stops (F,) [rad]."""

    starts: Array
    stops: Array
    angles: Array

    def integral(self, basis: AngularBasis) -> Array:
        return _circular(basis).arc_integral(self.starts, self.stops)

    def gram(self, basis: AngularBasis) -> Array:
        arcs = zip(self.starts, self.stops)
        return np.array([_circular(basis).arc_gram(start, stop) for start, stop in arcs])

    def middle_values(self, basis: AngularBasis) -> Array:
        return _circular(basis).evaluate_angles(self.starts + self.angles / 2)


@dataclass(frozen=True, eq=False)
class Polygons:
    """Spherical polygons, vertices (F, V, 3) counter-clockwise seen from outside the sphere."""

    vertices: Array

    @property
    def angles(self) -> Array:
        constant = SphericalHarmonics(1)
        return constant.polygon_integral(self.vertices)[:, 0] * constant.flux_weight

    def integral(self, basis: AngularBasis) -> Array:
        return _spherical(basis).polygon_integral(self.vertices)

    def gram(self, basis: AngularBasis) -> Array:
        return _spherical(basis).polygon_gram(self.vertices)

    def middle_values(self, basis: AngularBasis) -> Array:
        first_band = SphericalHarmonics(2).polygon_integral(self.vertices)[:, 1:]
        # Band 1 is √(3/4π) times (−y, z, −x).
        return basis.evaluate(unit(first_band[:, [2, 0, 1]] * [-1.0, -1.0, 1.0]))


def voronoi_cells(offsets: Offsets) -> Regions:
    """Of all directions, those nearest to each neighbour's: 4 or 8 in 2D, 6 or 26 in 3D.

    In 2D equal arcs. In 3D the faces of a cube seen from its centre; or 6 octagons, 12 rectangles
    and 8 hexagons, whose corners are the 48 mirror images of one (a truncated cuboctahedron).
    """
    if offsets.shape[1] == 2:
        middle, half = angle(offsets), np.pi / len(offsets)
        starts, stops = middle - half, middle + half
        return Arcs(starts, stops, stops - starts)
    directions = unit(offsets)
    corners = mirror_images(_CORNERS[len(offsets)])
    closeness = corners @ directions.T
    nearest = closeness > closeness.max(axis=1, keepdims=True) - 1e-9
    cells = [_around(d, corners[own]) for d, own in zip(directions, nearest.T)]
    longest = max(map(len, cells))
    # Repeating a vertex adds an edge of no length.
    return Polygons(np.array([np.pad(c, ((0, longest - len(c)), (0, 0)), "edge") for c in cells]))


def mirror_images(vector: Array) -> Array:
    """The different images (M, dimension) of a vector under all symmetries of the cube."""
    orders = itertools.permutations(vector)
    signs = itertools.product((1.0, -1.0), repeat=vector.size)
    images = {tuple(np.multiply(*pair)) for pair in itertools.product(orders, signs)}
    return np.array(sorted(images))


def _around(direction: Array, vertices: Array) -> Array:
    """Vertices (V, 3) counter-clockwise around a direction, seen from outside."""
    first, second = perpendicular(direction)
    return vertices[np.argsort(np.arctan2(vertices @ second, vertices @ first))]


def _circular(basis: AngularBasis) -> CircularHarmonics:
    assert isinstance(basis, CircularHarmonics)
    return basis


def _spherical(basis: AngularBasis) -> SphericalHarmonics:
    assert isinstance(basis, SphericalHarmonics)
    return basis
