"""Exact blocking in 3D: symmetric in links, scenes and descriptions."""

import numpy as np
import pytest
from links3d import GRID, L_SHAPE, ROUNDING, across_x, along, laid, random_triangles, transmittance
from space import AXIAL, CUBE, NEIGHBOURS, moved

from flatland.grid import Grid


def mixed_walls(seed):
    """In general position, on grid planes, through centres, along diagonals, not convex."""
    lattice = np.random.default_rng(seed).integers(0, 9, (4, 3, 3)) / 2
    special = [
        across_x(3, (1, 4), (1, 3)),
        across_x(2.5, (1.5, 3), (1, 2.5)),
        [(1, 3, 0.5), (3, 1, 0.5), (4, 2, 2.5), (2, 4, 2.5)],
        laid(L_SHAPE, seed),
    ]
    return [np.array(wall) for wall in (*random_triangles(seed, 6), *special, *lattice)]


@pytest.mark.parametrize("seed", range(3))
def test_both_ways_through_a_link_are_alike_to_the_last_bit(seed):
    tau = transmittance(*mixed_walls(seed))
    for open_share, step in zip(tau, NEIGHBOURS):
        back = tau[along(*-step)]
        np.testing.assert_array_equal(moved(open_share, -step), moved(back, step))


def test_turned_and_mirrored_scenes_have_turned_and_mirrored_shares():
    walls = mixed_walls(1)
    tau, middle = transmittance(*walls), np.array(GRID.shape) / 2
    for matrix in CUBE:
        shape = np.abs(matrix @ GRID.shape)
        turned = transmittance(
            *((wall - middle) @ matrix.T + shape / 2 for wall in walls),
            grid=Grid(tuple(shape.tolist())),
            offsets=NEIGHBOURS @ matrix.T,
        )
        cells = (np.argwhere(np.ones(GRID.shape)) + 0.5 - middle) @ matrix.T + shape / 2
        there = np.floor(cells).astype(int)
        expected = tau.reshape(len(tau), -1)
        np.testing.assert_allclose(turned[(slice(None), *there.T)], expected, atol=ROUNDING)


@pytest.mark.parametrize("seed", range(3))
def test_order_and_sense_of_walls_change_nothing(seed):
    walls = mixed_walls(seed)
    other = [np.roll(wall[::-1], seed, axis=0) for wall in walls[::-1]]
    np.testing.assert_allclose(transmittance(*other), transmittance(*walls), atol=ROUNDING)


@pytest.mark.parametrize("seed", range(3))
def test_splitting_walls_changes_nothing(seed):
    """Three triangles round a point of each, on a centre ray for one of them."""
    generator, walls = np.random.default_rng(seed), random_triangles(seed, 8)
    walls.append(np.array(across_x(2.8, (1, 2), (2, 3.2)))[:3])
    inner = [generator.dirichlet([1, 1, 1]) @ wall for wall in walls]
    inner[-1] = np.array([2.8, 1.5, 2.5])
    pieces = [
        np.array([wall[i], wall[i - 2], point])
        for wall, point in zip(walls, inner)
        for i in range(3)
    ]
    np.testing.assert_allclose(transmittance(*pieces), transmittance(*walls), atol=ROUNDING)


def test_spacing_and_origin_only_say_where_cells_are():
    grid = Grid(GRID.shape, spacing=0.37, origin=(-4.1, 90.3, 2.0))
    walls = random_triangles(5, 8)
    placed = [grid.to_world(wall) for wall in walls]
    np.testing.assert_allclose(transmittance(*placed, grid=grid), transmittance(*walls), atol=1e-11)


def test_every_offset_is_on_its_own():
    walls = random_triangles(6, 8)
    some = transmittance(*walls, offsets=NEIGHBOURS[[5, 2]])
    np.testing.assert_array_equal(some, transmittance(*walls)[[5, 2]])
    axial = transmittance(*walls, offsets=AXIAL)
    places = [along(*step) for step in AXIAL]
    np.testing.assert_array_equal(axial, transmittance(*walls)[places])
