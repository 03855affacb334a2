"""Facets cut by cells: areas, places, symmetry."""

import numpy as np
import pytest

from flatland.facets import cut_by_cells, facet_table
from flatland.grid import Grid
from flatland.sources import Facet

BLACK = np.zeros(1)
#: An L, not convex, in a slanted plane through (3, 3, 3).
L_SHAPE = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], float)
#: Area 5 of the L.
FRAME = np.array([[2.0, 1.0, -1.0], [0.3, 1.0, 1.6]])


def slanted(points):
    first = FRAME[0] / np.linalg.norm(FRAME[0])
    second = FRAME[1] - (FRAME[1] @ first) * first
    second /= np.linalg.norm(second)
    return points[:, :1] * first + points[:, 1:] * second + 2.0


def pieces_of(*polygons, shape=(8, 8, 8), spacing=1.0, move=0.0, turned=False):
    grid = Grid(shape, spacing)
    table = facet_table(grid, [Facet(np.array(p, float), BLACK) for p in polygons])
    return cut_by_cells((table.turned() if turned else table).moved(move), shape)


def test_no_facets_have_no_pieces():
    assert len(pieces_of().areas) == 0


def test_area_of_a_facet_in_the_grid_is_kept():
    for spacing in (1.0, 0.5):
        areas = pieces_of(slanted(L_SHAPE), shape=(16,) * 3, spacing=spacing).areas
        assert areas.sum() == pytest.approx(5.0 / spacing**2, rel=1e-13)


def test_every_piece_lies_in_its_cell():
    """Shares of the area by cell agree with points scattered over the facet."""
    generator = np.random.default_rng(7)
    points = generator.uniform(0, 3, (400_000, 2))
    inside = points[(points[:, 0] < 1) | (points[:, 1] < 1)]
    cells = np.floor(slanted(inside)).astype(int)
    expected = np.zeros((8, 8, 8))
    np.add.at(expected, tuple(cells.T), 5.0 / len(cells))
    found = np.zeros_like(expected)
    pieces = pieces_of(slanted(L_SHAPE))
    np.add.at(found, tuple(pieces.cells.T), pieces.areas)
    np.testing.assert_allclose(found, expected, atol=5 * np.sqrt(5.0 / len(cells)) / 2)


def test_facet_on_a_border_belongs_to_the_cell_in_front():
    square = [[1, 1, 4], [3, 1, 4], [3, 3, 4], [1, 3, 4]]
    assert set(pieces_of(square).cells[:, 2]) == {4}
    assert set(pieces_of(square, turned=True).cells[:, 2]) == {3}
    assert set(pieces_of(square[::-1]).cells[:, 2]) == {3}
    assert pieces_of(square).areas.tolist() == [1.0] * 4


def test_facet_moved_half_a_cell_onto_a_border_belongs_to_the_cell_in_front():
    square = [[1, 1, 3.5], [3, 1, 3.5], [3, 3, 3.5], [1, 3, 3.5]]
    assert set(pieces_of(square, move=0.5).cells[:, 2]) == {4}
    assert set(pieces_of(square, move=0.5, turned=True).cells[:, 2]) == {2}


def test_what_sticks_out_of_the_grid_is_left_out():
    far = [[-1e6, 2.5, -1e6], [1e6, 2.5, -1e6], [1e6, 2.5, 1e6], [-1e6, 2.5, 1e6]]
    pieces = pieces_of(far, shape=(3, 4, 5))
    assert pieces.areas.sum() == pytest.approx(15.0, rel=1e-9)
    assert set(pieces.cells[:, 1]) == {2}
    assert len(pieces_of([[0, 0, 9], [1, 0, 9], [0, 1, 9]]).areas) == 0


def test_mirrored_facets_have_mirrored_pieces():
    own = slanted(L_SHAPE)
    plain, mirrored = pieces_of(own), pieces_of((8 - own)[::-1])
    order = np.lexsort(plain.cells.T)
    other = np.lexsort((7 - mirrored.cells).T)
    np.testing.assert_array_equal(plain.cells[order], 7 - mirrored.cells[other])
    np.testing.assert_allclose(plain.areas[order], mirrored.areas[other], rtol=1e-11, atol=1e-13)


def test_facet_without_area_has_no_pieces():
    assert len(pieces_of([[1, 1, 1], [2, 2, 2], [3, 3, 3]]).areas) == 0


def test_middles_are_centroids():
    """Together they are the whole's; each piece's is the mean of points scattered over it."""
    pieces = pieces_of(slanted(L_SHAPE))
    middle = (4.5 + 1.0) / 5, (1.5 + 4.0) / 5  # of the L, as 3 x 1 and 1 x 2
    whole = slanted(np.array([middle]))[0]
    np.testing.assert_allclose(pieces.areas @ pieces.middles / 5, whole, rtol=1e-13)
    inside = (pieces.middles >= pieces.cells) & (pieces.middles <= pieces.cells + 1)
    assert inside.all()
    generator = np.random.default_rng(9)
    points = generator.uniform(0, 3, (400_000, 2))
    points = slanted(points[(points[:, 0] < 1) | (points[:, 1] < 1)])
    largest = int(np.argmax(pieces.areas))
    own = points[np.all(np.floor(points) == pieces.cells[largest], axis=1)]
    np.testing.assert_allclose(pieces.middles[largest], own.mean(axis=0), atol=4 / len(own) ** 0.5)


def test_a_tiny_facet_keeps_its_piece():
    side = 1e-9
    tiny = [[2.5, 2.5, 2.5], [2.5 + side, 2.5, 2.5], [2.5, 2.5 + side, 2.5]]
    pieces = pieces_of(tiny)
    assert pieces.cells.tolist() == [[2, 2, 2]]
    assert pieces.areas[0] == pytest.approx(side**2 / 2, rel=1e-6)
