"""Integrals of spherical harmonics over spherical polygons, in closed form."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from flatland.harmonics.base import AngularBasis, Array
from flatland.harmonics.polygon_geometry import (
    Edges,
    above_horizon,
    edges_of,
    polygon_vertices,
    solid_angle,
)


class PolygonIntegrals(AngularBasis):
    """What the spherical harmonics can integrate over polygons whose edges are great circles.

    Vertices (..., V, 3) are directions of any length, counter-clockwise seen from outside the
    sphere (seen from its centre they run clockwise); the other way round changes the sign. A
    polygon must fit into a hemisphere. Repeated vertices add nothing, so that polygons of several
    sizes go into one array by repeating their last vertex.
    """

    def polygon_integral(self, vertices: ArrayLike) -> Array:
        """∫ y dω over polygons (..., V, 3), shape (..., size).

        On the sphere Δy = −l(l+1) y, so that Stokes' theorem leaves the edges (the idea of Wang &
        Ramamoorthi 2018, without their zonal expansion):
        ∫ y_lm dω = Σ_edges ∫ N·∇y_lm ds / (l(l+1)), N the edge's normal towards the inside.
        The gradient of a solid harmonic is made of harmonics of degree l − 1, whose integral
        along an arc is exact (`arc_weights`). The solid angle gives l = 0. Accurate to some 1e-15
        for 20 bands; of a tiny polygon that is 1e-16 over its edge's length, relatively, which
        rounding its vertices costs too.
        """
        unit = polygon_vertices(vertices)
        edges = edges_of(unit)
        result = np.zeros((*unit.shape[:-2], self.size))
        result[..., 0] = solid_angle(unit, edges) / self.flux_weight
        if self.bands > 1:
            lower = _edge_integral(type(self)(self.bands - 1), edges)
            flow = np.swapaxes(edges.normals, -1, -2) @ lower
            result += np.tensordot(flow, gradient_table(self), axes=([-2, -1], [0, 2]))
        return result

    def polygon_gram(self, vertices: ArrayLike) -> Array:
        """∫ y yᵀ dω over polygons (..., V, 3), shape (..., size, size).

        Restricts an intensity to the polygon and projects it again. Products of two harmonics
        reach degree 2 bands − 2 and see no more of the polygon than its indicator function
        projected to 2 bands − 1 bands, which is `polygon_integral`; products with that are
        integrated over the whole sphere, exactly. Accurate to some 1e-14 for 10 bands.
        """
        wide = type(self)(2 * self.bands - 1)
        own, weighted = _gram_nodes(self)
        window = wide.polygon_integral(vertices) @ weighted
        gram = (own.T * window[..., None, :]) @ own
        return 0.5 * (gram + np.swapaxes(gram, -1, -2))

    def polygon_cosine_integral(self, vertices: ArrayLike, normals: ArrayLike) -> Array:
        """∫ max(0, n·ω) y dω over polygons (..., V, 3) for normals (..., 3), shape (..., size).

        What a surface with unit normal n gets through the polygon from an intensity. The polygon
        is cut at the horizon; n·ω y_lm is made of harmonics of degrees l − 1 and l + 1.
        """
        unit = self._unit(normals, "normals")
        wide = type(self)(self.bands + 1)
        integral = wide.polygon_integral(above_horizon(vertices, unit))
        along = np.tensordot(integral, direction_products(self, wide), axes=(-1, 2))
        return np.asarray(np.sum(along * unit[..., :, None], axis=-2))


def arc_weights(half_angles: Array, degree: int) -> Array:
    """Weights (..., K) that integrate trigonometric polynomials over −h … h [rad], exactly.

    For values at the K = 2 degree + 1 angles 2πj/K all round the circle, which determine such a
    polynomial of that degree: w_j = (2h + 4 Σ_m cos(2πjm/K) sin(mh)/m) / K.
    """
    count, m = 2 * degree + 1, np.arange(1, degree + 1)
    waves = np.cos(2 * np.pi / count * np.outer(m, np.arange(count)))
    sines = np.sin(half_angles[..., None] * m) / m
    return np.asarray((2 * half_angles[..., None] + 4 * sines @ waves) / count)


def _edge_integral(basis: AngularBasis, edges: Edges) -> Array:
    """∫ y ds along every edge, (..., V, size)."""
    degree = basis.bands - 1
    weights = arc_weights(edges.half_angles, degree)
    angles = 2 * np.pi / weights.shape[-1] * np.arange(weights.shape[-1])[:, None]
    points = (
        np.cos(angles) * edges.middles[..., None, :] + np.sin(angles) * edges.tangents[..., None, :]
    )
    return np.asarray((weights[..., None, :] @ basis.evaluate(points))[..., 0, :])


@lru_cache(maxsize=64)
def direction_products(basis: AngularBasis, wide: AngularBasis) -> Array:
    """∫ ω_i y y'ᵀ dω over the sphere, (3, size, size of the other basis)."""
    directions, weights = basis.quadrature(basis.bands + wide.bands)
    left, right = basis.evaluate(directions), wide.evaluate(directions)
    products = (directions.T * weights)[:, :, None] * left
    return np.asarray(np.swapaxes(products, 1, 2) @ right)


@lru_cache(maxsize=64)
def gradient_table(basis: AngularBasis) -> Array:
    """∇y / (l(l+1)) at r = 1 in harmonics one degree lower, (3, size, size of one band less).

    The lower part of ω_i y_l is the i-th derivative of the solid harmonic over 2l + 1.
    """
    lower = type(basis)(basis.bands - 1)
    one_less = basis.degrees[:, None] - 1 == lower.degrees
    degree = np.maximum(basis.degrees, 1)[:, None]
    factor = (2 * degree + 1) / (degree * (degree + 1))
    return np.where(one_less, factor * direction_products(basis, lower), 0.0)


@lru_cache(maxsize=64)
def _gram_nodes(basis: AngularBasis) -> tuple[Array, Array]:
    """Basis (K, size) at nodes for products of four, and weights times 2 bands − 1 bands there."""
    wide = type(basis)(2 * basis.bands - 1)
    directions, weights = basis.quadrature(4 * (basis.bands - 1))
    return basis.evaluate(directions), wide.evaluate(directions).T * weights
