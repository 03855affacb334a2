"""What the edges of spherical polygons add up to, for kernels.

`SphericalHarmonics.polygon_integral` by Stokes' theorem, written for one polygon at a time. A flow
(3 m² + 1,) holds Σ_edges N_i ∫ y ds for the three axes i and the m² harmonics of m bands, N the
edge's normal towards the inside, and the solid angle; `maps` turns it into integrals. Flows of
several polygons add up, and edges that two of them share cancel.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propagators.analytic.compiling import inner

Vector = NDArray[np.float64]


class FlowTables(NamedTuple):
    """Constants of a flow with m bands.

    legendre: (2, m, m) factors of the recurrence in l at [l, order]; diagonal: (m,) its starts.
    nodes: (2, K) cosines and sines of K = 2m - 1 angles round the circle. waves: (K, m - 1).
    """

    legendre: Vector
    diagonal: Vector
    nodes: Vector
    waves: Vector

    @property
    def size(self) -> int:
        """Length of a flow."""
        return 3 * len(self.diagonal) ** 2 + 1


def flow_tables(bands: int) -> FlowTables:
    """Tables for flows of m = `bands` bands, which integrate m + 1 bands over polygons."""
    degree, order = np.arange(bands)[:, None], np.arange(bands)[None]
    below = (degree - 1) ** 2
    inside = order < degree
    square = np.where(inside, degree**2 - order**2, 1)
    first = np.sqrt(np.maximum(4 * degree**2 - 1, 0) / square)
    second = np.sqrt(np.maximum(below - order**2, 0) / np.abs(4 * below - 1))
    m = np.arange(1, bands)
    steps = np.concatenate([[1.0], -np.sqrt((2 * m + 1) / (2 * m))])
    diagonal = np.cumprod(steps) / np.sqrt(4 * np.pi)
    diagonal[1:] *= np.sqrt(2)
    count = 2 * bands - 1
    angles = 2 * np.pi / count * np.arange(count)
    nodes = np.stack([np.cos(angles), np.sin(angles)])
    legendre = np.where(inside, np.stack([first, second]), 0.0)
    return FlowTables(legendre, diagonal, nodes, np.cos(np.outer(angles, m)))


@inner
def evaluate(x: float, y: float, z: float, tables: FlowTables, values: Vector) -> None:
    """Spherical harmonics (m²,) of a unit vector, as `SphericalHarmonics.evaluate`."""
    bands = tables.diagonal.size
    real, imaginary = 1.0, 0.0
    for m in range(bands):
        older, newer = 0.0, tables.diagonal[m]
        for degree in range(m, bands):
            if degree > m:
                following = z * newer - tables.legendre[1, degree, m] * older
                older, newer = newer, tables.legendre[0, degree, m] * following
            middle = degree * (degree + 1)
            values[middle - m] = newer * imaginary
            values[middle + m] = newer * real
        real, imaginary = real * x - imaginary * y, real * y + imaginary * x


@inner
def add_polygon(
    corners: Vector, count: int, tables: FlowTables, values: Vector, flow: Vector
) -> None:
    """flow += that of a convex polygon; corners (count, 3), directions of length 1 on return.

    Counter-clockwise seen from outside the sphere. values: scratch (m²,).
    """
    for i in range(count):
        x, y, z = corners[i, 0], corners[i, 1], corners[i, 2]
        size = 1.0 / math.sqrt(x * x + y * y + z * z)
        corners[i, 0], corners[i, 1], corners[i, 2] = x * size, y * size, z * size
    for i in range(count):
        _add_edge(corners[i], corners[i + 1 if i + 1 < count else 0], tables, values, flow)
    for i in range(1, count - 1):
        flow[flow.size - 1] += solid_angle(corners[0], corners[i], corners[i + 1])


@inner
def solid_angle(a: Vector, b: Vector, c: Vector) -> float:
    """Of the triangle of three unit vectors (van Oosterom & Strackee 1983, eq. 8)."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    volume = a[0] * (uy * vz - uz * vy) + a[1] * (uz * vx - ux * vz) + a[2] * (ux * vy - uy * vx)
    ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    bc = b[0] * c[0] + b[1] * c[1] + b[2] * c[2]
    ca = c[0] * a[0] + c[1] * a[1] + c[2] * a[2]
    return 2.0 * math.atan2(volume, 1.0 + ab + bc + ca)


@inner
def _add_edge(a: Vector, b: Vector, tables: FlowTables, values: Vector, flow: Vector) -> None:
    """flow += N ∫ y ds over the arc from a to b: trigonometric polynomials, exactly.

    The weights are those of `arc_weights` in flatland.harmonics.spherical_polygons.
    """
    dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    nx, ny, nz = a[1] * dz - a[2] * dy, a[2] * dx - a[0] * dz, a[0] * dy - a[1] * dx
    sine = math.sqrt(nx * nx + ny * ny + nz * nz)
    mx, my, mz = a[0] + b[0], a[1] + b[1], a[2] + b[2]
    length = math.sqrt(mx * mx + my * my + mz * mz)
    if sine < 1e-300 or length < 1e-9:
        return
    nx, ny, nz = nx / sine, ny / sine, nz / sine
    mx, my, mz = mx / length, my / length, mz / length
    tx, ty, tz = ny * mz - nz * my, nz * mx - nx * mz, nx * my - ny * mx
    half = 0.5 * math.atan2(sine, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
    cosine, sine = math.cos(half), math.sin(half)
    count, size = tables.nodes.shape[1], values.size
    for node in range(count):
        weight, real, imaginary = 2.0 * half, 1.0, 0.0
        for m in range(tables.waves.shape[1]):
            real, imaginary = real * cosine - imaginary * sine, real * sine + imaginary * cosine
            weight += 4.0 * tables.waves[node, m] * imaginary / (m + 1)
        weight /= count
        c, s = tables.nodes[0, node], tables.nodes[1, node]
        evaluate(c * mx + s * tx, c * my + s * ty, c * mz + s * tz, tables, values)
        for k in range(size):
            term = weight * values[k]
            flow[k] += nx * term
            flow[size + k] += ny * term
            flow[2 * size + k] += nz * term
