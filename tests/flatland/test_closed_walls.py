"""Exact blocking: a closed opaque wall lets exactly nothing through."""

import numpy as np
import pytest
from links import ALL, AXIAL, closed, transmittance
from space import connected

from flatland.grid import Grid


def is_inside(points, ends):
    """Even-odd rule: whether a ray to +x from each point (N, 2) crosses the outline oddly."""
    x, y = points[:, :1], points[:, 1:]
    x0, y0, x1, y1 = ends.T
    rises = (y0 > y) != (y1 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        hit = x0 + (y - y0) * (x1 - x0) / (y1 - y0)
    return (rises & (x < hit)).sum(axis=1) % 2 == 1


def is_on(points, ends):
    """Whether points lie on the outline."""
    start, wall = ends[:, :2], ends[:, 2:] - ends[:, :2]
    gap = points[:, None] - start
    part = np.clip((gap * wall).sum(-1) / np.maximum((wall * wall).sum(-1), 1e-300), 0, 1)
    return (np.linalg.norm(gap - part[..., None] * wall, axis=-1) < 1e-6).any(axis=1)


def star(generator):
    """A polygon without crossings, anywhere between slim and round."""
    angle = np.sort(generator.random(generator.integers(3, 9))) * 2 * np.pi
    radius = generator.uniform(2, 9, len(angle))
    return 10 + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def lattice(generator):
    """Corners on centres, cell corners and middles of faces; the outline crosses itself."""
    return generator.integers(2, 38, (generator.integers(3, 8), 2)) / 2


def diagonal(generator):
    """Corners on a coarse lattice: many walls along diagonals and through centres."""
    return generator.integers(0, 5, (generator.integers(3, 8), 2)) * 4 + 2.5


@pytest.mark.parametrize("offsets", [AXIAL, ALL], ids=["4", "8"])
@pytest.mark.parametrize("shape", [star, lattice, diagonal])
def test_no_light_gets_through_a_closed_wall(shape, offsets):
    generator, grid = np.random.default_rng(11), Grid((20, 20))
    centers = np.argwhere(np.ones(grid.shape)) + 0.5
    for _ in range(60):
        ends = closed(shape(generator))
        region = connected(transmittance(*ends, grid=grid, offsets=offsets), offsets)
        inside, on = is_inside(centers, ends), is_on(centers, ends)
        assert not np.intersect1d(region[inside & ~on], region[~inside & ~on]).size


def test_without_walls_between_them_cells_stay_connected():
    """The wall is tight because it is there: both sides of it are whole."""
    grid = Grid((20, 20))
    ends = closed(10 + 7.3 * np.array([(1, 0.2), (-0.2, 1), (-1, -0.2), (0.2, -1)]))
    assert len(np.unique(connected(transmittance(*ends, grid=grid, offsets=AXIAL), AXIAL))) == 2
