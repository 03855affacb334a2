"""Grids: where cells are, and which grids are refused."""

import numpy as np
import pytest

from flatland.errors import InputError
from flatland.grid import Grid

#: Rounding of positions of a few metres.
ROUNDING = 1e-14

GRIDS = [Grid((4, 7), 0.25, (-3.0, 2.5)), Grid((3, 2, 5), 1.5, (1.0, -1.0, 0.5)), Grid((1, 1))]
every_grid = pytest.mark.parametrize("grid", GRIDS, ids=str)


@every_grid
def test_world_and_cell_positions_are_inverse(grid, rng):
    points = rng.uniform(-5, 5, (20, grid.dimension))
    np.testing.assert_allclose(grid.to_world(grid.to_cells(points)), points, atol=ROUNDING)


@every_grid
def test_corners_of_the_grid_are_the_corners_of_its_first_and_last_cell(grid):
    np.testing.assert_allclose(grid.to_world(np.zeros(grid.dimension)), grid.origin)
    np.testing.assert_allclose(grid.to_world(np.array(grid.shape)), grid.upper)
    np.testing.assert_allclose(np.add(grid.origin, grid.extent), grid.upper)


@every_grid
def test_centre_of_a_cell_lies_half_a_cell_from_its_corner(grid):
    cell = np.array(grid.shape) - 1
    corner = grid.to_world(cell)
    np.testing.assert_allclose(grid.cell_center(cell) - corner, grid.spacing / 2)


def test_border_belongs_to_the_grid_and_what_lies_behind_does_not():
    grid = Grid((4, 2), 0.5, (1.0, 1.0))
    points = [(1.0, 1.0), (3.0, 2.0), (2.9, 1.5), (3.001, 1.5), (2.0, 0.999)]
    assert grid.contains(points).tolist() == [True, True, True, False, False]


@pytest.mark.parametrize(("shape", "expected"), [((8, 6), (4, 3)), ((7, 1), (4, 1))])
def test_coarser_grid_covers_the_finer_one(shape, expected):
    grid = Grid(shape, 0.5, (1.0, 2.0))
    coarse = grid.coarsen()
    assert coarse.shape == expected
    assert coarse.origin == grid.origin
    assert all(a >= b for a, b in zip(coarse.upper, grid.upper))


def test_cells_are_counted():
    assert Grid((3, 4, 5)).cell_count == 60


@pytest.mark.parametrize(
    "shape", [(3,), (3, 4, 5, 6), (0, 3), (3, -1), (2.5, 3), (True, 3), ("3", 3)], ids=repr
)
def test_bad_shape_is_refused(shape):
    with pytest.raises(InputError, match=r"^shape = .*: must be 2 or 3 whole numbers") as caught:
        Grid(shape)
    assert repr(shape) in str(caught.value)


@pytest.mark.parametrize("spacing", [0.0, -1.0, np.nan, np.inf])
def test_bad_spacing_is_refused(spacing):
    with pytest.raises(InputError, match=rf"spacing = {spacing}: must be finite and greater"):
        Grid((2, 2), spacing)


@pytest.mark.parametrize("origin", [(1.0,), (1.0, 2.0, 3.0), (0.0, np.nan)])
def test_bad_origin_is_refused(origin):
    with pytest.raises(InputError, match=r"origin = .*: must be 2 finite numbers"):
        Grid((2, 2), 1.0, origin)
