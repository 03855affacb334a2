"""Between levels: what a mean over children keeps."""

import numpy as np
import pytest

from flatland.errors import InputError
from flatland.grid import Grid
from flatland.octree import halved, level_grids, most_levels
from flatland.octree.downsampling import spread

SHAPES = [(8, 8), (6, 4), (7, 5), (1, 9), (1, 1), (4, 6, 8), (5, 3, 2), (1, 1, 7)]


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_mean_over_children_keeps_the_sum_per_volume(shape, rng):
    values = rng.normal(size=(3, *shape))
    coarse = halved(values, len(shape))
    axes = tuple(range(1, values.ndim))
    np.testing.assert_allclose(
        coarse.sum(axis=axes) * 2 ** len(shape), values.sum(axis=axes), atol=1e-13
    )
    assert coarse.shape[1:] == tuple(-(-n // 2) for n in shape)


@pytest.mark.parametrize("shape", [(8, 8), (6, 4), (4, 6, 8)], ids=str)
def test_mean_is_that_of_a_reshaped_array(shape, rng):
    values = rng.normal(size=(2, *shape))
    pairs = [part for n in shape for part in (n // 2, 2)]
    expected = values.reshape(2, *pairs).mean(axis=tuple(range(2, 2 + 2 * len(shape), 2)))
    np.testing.assert_allclose(halved(values, len(shape)), expected, atol=1e-15)


@pytest.mark.parametrize("shape", [(8, 16), (7, 5), (5, 6, 7)], ids=str)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_constant_stays_that_constant_in_whole_cells(shape, dtype):
    """Exactly; a cell that misses a child is darker by its share."""
    coarse = halved(np.full((1, *shape), 0.7, dtype), len(shape))[0]
    whole = coarse[tuple(slice(n // 2) for n in shape)]
    np.testing.assert_array_equal(whole, dtype(0.7))
    assert coarse.dtype == dtype
    if shape[0] % 2:
        edge = coarse[(-1, *[0] * (len(shape) - 1))]
        np.testing.assert_allclose(edge, dtype(0.35), rtol=1e-6)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_spreading_repeats_every_cell_in_its_children(shape, rng):
    coarse = rng.normal(size=tuple(-(-n // 2) for n in shape))
    fine = spread(coarse, 1, shape)
    assert fine.shape == shape
    for cell in np.ndindex(shape):
        assert fine[cell] == coarse[tuple(i // 2 for i in cell)]


@pytest.mark.parametrize(
    ("shape", "most"),
    [((1, 1), 1), ((2, 1), 2), ((64, 64), 7), ((48, 32), 7), ((17, 17), 6), ((3, 5, 9), 5)],
)
def test_levels_lead_down_to_one_cell(shape, most):
    assert most_levels(shape) == most
    grids = level_grids(Grid(shape, 0.5, (1.0,) * len(shape)), most)
    assert [grid.cell_count for grid in grids][-1] == 1
    assert all(grid.cell_count > 1 for grid in grids[:-1])
    for level, grid in enumerate(grids):
        assert grid.spacing == 0.5 * 2**level
        assert grid.origin == (1.0,) * len(shape)


@pytest.mark.parametrize("levels", [0, -1, 8, 2.0, True, "3", None], ids=repr)
def test_level_counts_that_cannot_be_are_refused_with_the_range(levels):
    with pytest.raises(InputError, match=r"levels = .*: must be a whole number, 1 to 7: 64 x 33"):
        level_grids(Grid((64, 33)), levels)
