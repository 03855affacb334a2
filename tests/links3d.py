"""Links between the cells of a 3D grid, and walls across them."""

import numpy as np
from space import NEIGHBOURS, facets

from flatland.blocking import exact_transmittance
from flatland.grid import Grid

GRID = Grid((6, 5, 4))
#: An L, not convex, and its parts.
L_SHAPE = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], float)
L_PARTS = [L_SHAPE[[0, 1, 2, 3]], L_SHAPE[[0, 3, 4, 5]]]
#: Decimal digits lost by coordinates of a few cells in sums of products.
ROUNDING = 1e-12


def transmittance(*polygons, grid=GRID, offsets=NEIGHBOURS):
    tau = exact_transmittance(grid, facets(*polygons), offsets)
    return np.ones((len(offsets), *grid.shape)) if tau is None else tau


def along(*step):
    """The place of a neighbour in NEIGHBOURS."""
    return int(np.flatnonzero((step == NEIGHBOURS).all(axis=1))[0])


def across_x(x, y, z):
    """A rectangle at x that spans y and z."""
    return [(x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])]


def laid(points, seed):
    """Points (V, 2) in a random plane through the middle of the grid."""
    axes = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0][:2]
    return (points - 1.2) @ axes + (3, 2.5, 2)


def random_triangles(seed, count, size=1.0):
    """Also across the grid's border."""
    generator = np.random.default_rng(seed)
    middles = generator.random((count, 1, 3)) * GRID.shape
    return list(middles + size * generator.normal(size=(count, 3, 3)))
