"""How much of the light from outside gets past walls into the border's cells, in 3D."""

import numpy as np
import pytest
from space import box_faces, facets, rotation

from flatland.grid import Grid
from flatland.injectors.border import border_sides
from flatland.sources import Segment

GRID = Grid((6, 5, 4), spacing=0.5, origin=(1.0, -2.0, 0.3))


def sides(*polygons, grid=GRID):
    """From polygons in cell units."""
    return border_sides(grid, facets(*(grid.to_world(np.array(p, float)) for p in polygons)))


def across_x(x, y, z):
    return [(x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])]


def share_of(side, cell):
    return side.open_shares[np.all(cell == side.cells.T, axis=1)].item()


def test_without_walls_all_sides_are_open():
    found = border_sides(GRID)
    assert [(side.axis, side.upper) for side in found] == [
        (axis, upper) for axis in range(3) for upper in (False, True)
    ]
    for side in found:
        assert np.all(side.open_shares == 1)
        assert side.cells.shape[1] == GRID.cell_count // GRID.shape[side.axis]


@pytest.mark.parametrize("x", [-0.5, -0.2, 0.0, 0.3, 0.5])
def test_walls_up_to_the_middle_of_the_outer_cells_count(x):
    """Half of the link to the cell outside lies in the grid; walls further in cut other links."""
    left, right, *others = sides(across_x(x, (1, 1.25), (2, 3)))
    assert share_of(left, (0, 1, 2)) == pytest.approx(0.75, abs=1e-12)
    assert np.sum(left.open_shares < 1) == 1
    assert all(np.all(side.open_shares == 1) for side in (right, *others))


@pytest.mark.parametrize("x", [-0.6, 0.6])
def test_walls_that_no_link_to_the_outside_meets_do_not(x):
    assert all(np.all(side.open_shares == 1) for side in sides(across_x(x, (0, 5), (0, 4))))


def test_a_wall_along_a_side_shuts_it():
    _, right, *others = sides(across_x(6, (-1, 6), (-1, 5)))
    assert np.all(right.open_shares == 0)
    assert all(np.all(side.open_shares == 1) for side in others)


def test_a_closed_box_round_the_grid_shuts_every_side():
    around = box_faces(np.array(GRID.shape) / 2, np.array(GRID.shape) + 0.4)
    assert all(np.all(side.open_shares == 0) for side in sides(*around))


def test_a_slanted_wall_shades_what_it_covers():
    """Its shares add up to what is left of its projection onto each side, but for centre rays."""
    turn = rotation(np.random.default_rng(5))[:2]
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    # Small, between the centres of the outer layer's cells.
    tiny = 0.1 * square @ turn + (0.2, 1.2, 2.2)
    left, *_ = sides(tiny)
    shadow = 0.04 * abs(np.cross(turn[0], turn[1])[0])
    assert np.sum(1 - left.open_shares) == pytest.approx(shadow, rel=1e-9)


def test_tall_walls_shade_as_in_2d():
    flat, deep = Grid((6, 5)), Grid((6, 5, 3))
    ends = np.random.default_rng(2).uniform(-0.5, 6.5, (6, 4))
    expected = border_sides(flat, [Segment(e[:2], e[2:], np.zeros(1)) for e in ends])
    tall = [[(*e[:2], 0), (*e[2:], 0), (*e[2:], 3), (*e[:2], 3)] for e in ends]
    found = sides(*tall, grid=deep)
    for one, other in zip(expected, found):
        layers = other.open_shares.reshape(len(one.open_shares), 3)
        np.testing.assert_allclose(layers, one.open_shares[:, None] + np.zeros(3), atol=1e-12)
    assert any(np.any(side.open_shares < 1) for side in expected)
