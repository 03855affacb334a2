"""Links between the cells of a 2D grid, and walls across them."""

import numpy as np

from flatland.blocking import exact_transmittance
from flatland.grid import Grid
from flatland.sources import Segment

AXIAL = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
ALL = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
GRID = Grid((6, 5))


def walls(*ends):
    """Segments from (x0, y0, x1, y1)."""
    return [Segment(np.array(e[:2], float), np.array(e[2:], float), np.zeros(1)) for e in ends]


def transmittance(*ends, grid=GRID, offsets=ALL):
    tau = exact_transmittance(grid, walls(*ends), offsets)
    return np.ones((len(offsets), *grid.shape)) if tau is None else tau


def random_walls(seed, count, shape=GRID.shape, most=3.0):
    """Walls in general position, also across the grid's border."""
    generator = np.random.default_rng(seed)
    middle = generator.random((count, 2)) * shape
    half = generator.normal(size=(count, 2)) * most / 4
    return np.concatenate([middle - half, middle + half], axis=1)


def closed(vertices):
    """Walls (S, 4) around a polygon (S, 2)."""
    return np.concatenate([vertices, np.roll(vertices, -1, axis=0)], axis=1)
