"""Where the grids of a cascade lie."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flatland.cascades import cascade_grids, most_cascade_levels
from flatland.errors import InputError
from flatland.grid import Grid

SCENE = Grid((96, 64), 0.5, (3.0, -7.0))


def starts(grids, scene):
    """Lower corners in cells of the scene, (levels, dimension), whole numbers."""
    cells = scene.to_cells([grid.origin for grid in grids])
    np.testing.assert_allclose(cells, np.round(cells), atol=1e-9)
    return np.round(cells).astype(int)


@st.composite
def nested(draw):
    dimension = draw(st.sampled_from([2, 3]))
    shape = tuple(draw(st.integers(1, 150)) for _ in range(dimension))
    cells = draw(st.sampled_from([4, 6, 8, 16, 32]))
    scene = Grid(shape, draw(st.sampled_from([1.0, 0.3])), (1.5,) * dimension)
    levels = draw(st.integers(1, most_cascade_levels(scene, cells)))
    share = np.array([draw(st.floats(0, 1)) for _ in range(dimension)])
    focus = scene.to_world(share * shape)
    return scene, cells, focus, cascade_grids(scene, levels, cells, focus)


@given(nested())
def test_grids_are_nested_snapped_and_doubling(drawn):
    scene, cells, focus, grids = drawn
    corners = starts(grids, scene)
    sizes = cells * 2 ** np.arange(len(grids))[:, None]
    for level, grid in enumerate(grids):
        assert grid.shape == (cells,) * scene.dimension
        assert grid.spacing == scene.spacing * 2**level
        # On whole cells of the next coarser level, wherever the focus is.
        assert not np.any(corners[level] % 2 ** (level + 1))
    assert np.all(corners[1:] <= corners[:-1])
    assert np.all((corners + sizes)[1:] >= (corners + sizes)[:-1])
    assert np.all(grids[0].contains(focus) | (corners[0] >= 0).all())


@given(nested())
def test_grids_stay_in_the_scene_or_round_it(drawn):
    """As far as nesting lets them: never further out than a cell of the next coarser grid."""
    scene, cells, _, grids = drawn
    corners = starts(grids, scene)
    for level, start in enumerate(corners):
        size, snap = cells * 2**level, 2 ** (level + 1)
        for low, length in zip(start, scene.shape):
            if size <= length:
                assert -snap < low
                assert low + size < length + snap
            else:
                assert low <= 0
                assert low + size > length - snap


def test_a_focus_on_the_border_moves_no_grid_out_of_the_scene():
    (grid,) = cascade_grids(Grid((4, 4)), 1, 4, (4.0, 4.0))
    assert grid == Grid((4, 4))


def test_the_focus_is_in_the_middle_where_there_is_room():
    grids = cascade_grids(SCENE, 3, 16, (27.0, 9.0))
    centre = SCENE.to_cells((27.0, 9.0))
    for level, grid in enumerate(grids[:2]):
        middle = SCENE.to_cells(np.add(grid.origin, grid.upper) / 2)
        assert np.abs(middle - centre).max() <= 2**level


def test_small_moves_of_the_focus_change_nothing():
    """Coherence: grids move by whole cells of the next coarser one."""
    reference = cascade_grids(SCENE, 3, 16, (27.0, 9.0))
    for shift in (-0.2, 0.1, 0.2):
        assert cascade_grids(SCENE, 3, 16, (27.0 + shift, 9.0)) == reference
    moved = cascade_grids(SCENE, 3, 16, (28.0, 9.0))
    assert moved[0].origin[0] - reference[0].origin[0] == 2 * SCENE.spacing


def test_the_coarsest_of_all_covers_the_scene():
    assert most_cascade_levels(SCENE, 16) == 4
    assert most_cascade_levels(SCENE, 96) == 1
    grid = cascade_grids(SCENE, 4, 16, (5.0, 0.0))[-1]
    assert np.all(np.less_equal(grid.origin, SCENE.origin))
    assert np.all(np.greater_equal(grid.upper, SCENE.upper))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0, 16, (4.0, 0.0)), "levels = 0: must be a whole number, 1 to 4: 128 cells"),
        ((5, 16, (4.0, 0.0)), "levels = 5: must be a whole number, 1 to 4: 128 cells"),
        ((True, 16, (4.0, 0.0)), "levels = True: must be a whole number"),
        ((2, 15, (4.0, 0.0)), "cells = 15: must be an even number, at least 4"),
        ((2, 2, (4.0, 0.0)), "cells = 2: must be an even number, at least 4"),
        ((2, 16.0, (4.0, 0.0)), "cells = 16.0: must be an even number"),
        ((2, 16, (4.0,)), "focus = (4.0,): must be 2 finite numbers"),
        ((2, 16, (4.0, np.nan)), "must be 2 finite numbers"),
        ((2, 16, (0.0, 0.0)), "focus = (0.0, 0.0): must lie in the scene's grid"),
    ],
)
def test_cascades_that_cannot_be_are_refused(arguments, message):
    with pytest.raises(InputError) as caught:
        cascade_grids(SCENE, *arguments)
    assert message in str(caught.value)
