"""Planar polygons: which are accepted, whatever their place, size and slant."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flatland.occluders import QuadOccluder
from flatland.planar import PLANAR, polygon_fault

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
DART = np.array([[0, 0], [4, 0.5], [1.2, 1], [0.5, 4]])
SPIRAL = np.array([[0, 0], [5, 0], [5, 4], [1, 4], [1, 2], [3, 2], [3, 3], [2, 3], [4, 3.5]])
COMB = np.array([[0, 0], [4, 0], [4, 3], [3, 1], [2, 3], [1, 1], [0, 3]])
SLANT = Rotation.from_euler("xyz", [0.4, 1.1, -2.3])


def in_space(flat, size=1.0, place=(0, 0, 0)):
    points = np.concatenate([np.array(flat, float), np.zeros((len(flat), 1))], axis=1)
    return size * SLANT.apply(points) + place


@pytest.mark.parametrize("size", [1e-90, 1e-3, 1.0, 1e90])
@pytest.mark.parametrize("flat", [SQUARE, DART, COMB, SQUARE[::-1], SQUARE[:3]])
def test_good_polygons_of_any_size_are_accepted(flat, size):
    assert polygon_fault(in_space(flat, size)) is None


@pytest.mark.parametrize("place", [1e3, 1e6, 1e9])
def test_good_polygons_far_away_are_accepted(place):
    assert polygon_fault(in_space(SQUARE, place=[place, -place, 2 * place])) is None


@pytest.mark.parametrize(
    ("flat", "rule"),
    [
        (SQUARE[[0, 2, 1, 3]], "cross or touch"),
        (SQUARE[[0, 1, 3, 2]], "cross or touch"),
        (np.array([[0, 0], [4, 0], [4, 3], [2, 0], [0, 3]]), "cross or touch"),
        (SPIRAL, "cross or touch"),
        (np.array([[0, 0], [2, 0], [2, 2], [1, 1], [2, 2], [0, 2]]), "cross or touch"),
        (SQUARE[[0, 1, 1, 2]], "same point as vertex 2 and vertex 3"),
        (SQUARE[[0, 1, 2, 0]], "same point as vertex 4 and vertex 1"),
        (np.array([[0, 0], [1, 0], [3, 0]]), "on one line"),
        (np.array([[0, 0], [1, 0], [3, 1e-10], [2, 1e-10]]), "on one line"),
        (SQUARE * 0, "same point"),
    ],
)
def test_bad_polygons_are_named(flat, rule):
    for size in (1e-50, 1.0, 1e50):
        assert rule in polygon_fault(in_space(flat, size))


def test_a_polygon_may_leave_its_plane_by_a_stated_part_of_its_size():
    """A corner lifted by d puts all four of a square d/4 off the plane between them."""
    for size in (1e-6, 1.0, 1e6):
        corners = in_space(SQUARE, size)
        lift = SLANT.apply([0, 0, 1]) * size * 0.5 * 4 * PLANAR
        first = np.array([[1.0], [0], [0], [0]])
        assert polygon_fault(corners + 0.9 * first * lift) is None
        fault = polygon_fault(corners + 3 * first * lift)
        assert "one plane: vertex" in fault
        assert f"{1.5 * PLANAR * size:.2g} m off" in fault


def test_a_quad_keeps_its_corners_and_is_open():
    corners = in_space(DART, 2.0, (1, 2, 3))
    (wall,) = QuadOccluder(vertices=tuple(map(tuple, corners)), albedo=(0.1, 0.2)).walls(2)
    np.testing.assert_array_equal(wall.vertices, corners)
    np.testing.assert_array_equal(wall.albedo, [0.1, 0.2])
    assert not wall.closed
