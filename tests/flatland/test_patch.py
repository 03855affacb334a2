"""Light in a box of cells, dark elsewhere."""

import numpy as np
import pytest

from flatland.kernels.box import is_empty
from flatland.patch import Patch


def field(shape, *cells):
    values = np.zeros((2, *shape))
    for i, cell in enumerate(cells):
        values[(i % 2, *cell)] = 1.0 + i
    return values


@pytest.mark.parametrize(
    ("shape", "cells", "box"),
    [
        ((5, 7), [(1, 2), (3, 4)], ((1, 4), (2, 5))),
        ((5, 7), [(0, 0), (4, 6)], ((0, 5), (0, 7))),
        ((4, 5, 6), [(1, 2, 3)], ((1, 2), (2, 3), (3, 4))),
    ],
)
def test_around_the_light_and_back(shape, cells, box):
    values = field(shape, *cells)
    patch = Patch.around(values)
    assert patch.box == box
    np.testing.assert_array_equal(patch.on(shape), values)
    everywhere = Patch.everywhere(values)
    assert everywhere.trimmed().box == box
    np.testing.assert_array_equal(everywhere.trimmed().on(shape), values)
    np.testing.assert_array_equal((patch * 0.5).on(shape), 0.5 * values)


def test_a_box_inside_a_box():
    values = field((6, 6), (2, 3), (3, 3))
    loose = Patch(values[:, 1:5, 2:6], ((1, 5), (2, 6)))
    assert loose.trimmed().box == ((2, 4), (3, 4))
    np.testing.assert_array_equal(loose.trimmed().on((6, 6)), values)


def test_no_light_is_an_empty_box():
    for patch in (Patch.around(field((3, 4))), Patch.everywhere(field((3, 4))).trimmed()):
        assert is_empty(patch.box)
        assert is_empty(patch.trimmed().box)
        assert not patch.on((3, 4)).any()
