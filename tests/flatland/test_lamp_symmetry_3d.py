"""A scene of lamps and walls, turned by a symmetry of the cube, injects the turned field."""

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from sphere import cube_symmetries, representation

from flatland.grid import Grid
from flatland.harmonics import SphericalHarmonics
from flatland.injectors import DirectionalLight, EnvironmentLight, PointLight
from flatland.sources import Facet

SHAPE = np.array((7, 5, 6))
SPACING = 0.5
BASIS = SphericalHarmonics(3)
#: Rounding of positions, over solid angles and areas of a thousandth and more.
TOLERANCE = 1e-11

TURNS = list(cube_symmetries())
MATRICES = [representation(BASIS, turn) for turn in TURNS]

#: Positions in cells: on borders, on halves, and anywhere.
across = st.one_of(
    st.integers(2, 18).map(lambda quarter: quarter / 4),
    st.integers(0, 10**4).map(lambda part: 0.5 + 4 * part / 10**4),
)
points = st.tuples(across, across, across)
part = st.integers(-1000, 1000).map(lambda n: n / 100)
directions = st.tuples(part, part, part).filter(any)
quick = settings(
    deadline=None,
    derandomize=True,
    max_examples=25,
    suppress_health_check=[HealthCheck.filter_too_much],
)


def wide(corners):
    a, b, c = np.array(corners)
    return np.linalg.norm(np.cross(b - a, c - a)) > 0.25


walls = st.lists(st.tuples(points, points, points).filter(wide), min_size=1, max_size=5)


def turned_point(turn, point):
    """A point of the grid [cells], turned with it."""
    return turn @ (np.array(point) - SHAPE / 2) + np.abs(turn) @ SHAPE / 2


def turned_field(values, turn, matrix):
    """S'(x', ω') = S(x, ω): cells and directions turned alike."""
    order = np.argmax(np.abs(turn), axis=1)
    moved = values.transpose(0, *(1 + order))
    flips = [axis for axis in range(3) if turn[axis].sum() < 0]
    return np.tensordot(matrix, np.flip(moved, [1 + axis for axis in flips]), 1)


def field_of(lamp, corners, shape):
    grid = Grid(tuple(int(n) for n in shape), SPACING)
    # The same for all: of walls that lie on one another the first listed is lit.
    facets = [Facet(SPACING * np.array(c, float), np.array(0.5)) for c in corners]
    values = np.zeros((BASIS.size, *grid.shape))
    for spectrum, (cells, coefficients) in lamp.emissions(grid, BASIS, facets):
        values[(slice(None), *cells)] += spectrum[0] * coefficients.T
    return values


def lamp_at(turn, position=None, direction=None):
    if position is not None:
        place = SPACING * turned_point(turn, position)
        return PointLight(position=tuple(place), flux=1.0, texels=16)
    if direction is not None:
        heading = tuple((turn @ np.array(direction)).tolist())
        return DirectionalLight(direction=heading, irradiance=1.0, texels=16)
    return EnvironmentLight(radiance=1.0)


def assert_turns(number, corners, **light):
    turn, identity = TURNS[number], np.eye(3)
    expected = field_of(lamp_at(identity, **light), corners, SHAPE)
    moved = [[turned_point(turn, point) for point in triangle] for triangle in corners]
    found = field_of(lamp_at(turn, **light), moved, np.abs(turn) @ SHAPE)
    image = turned_field(expected, turn, MATRICES[number])
    np.testing.assert_allclose(found, image, rtol=0, atol=TOLERANCE)


def height(point, corners):
    """Distance of a point from the plane of a triangle [cells]."""
    a, b, c = np.array(corners)
    normal = np.cross(b - a, c - a)
    return abs((np.array(point) - a) @ normal) / np.linalg.norm(normal)


@quick
@given(st.integers(0, 47), points, walls)
def test_turned_point_light_gives_the_turned_field(number, position, corners):
    # A lamp in the plane of a wall sees it from its edge, or is refused.
    assume(min(height(position, triangle) for triangle in corners) > 1e-3)
    assert_turns(number, corners, position=position)


@quick
@given(st.integers(0, 47), directions, walls)
def test_turned_sun_gives_the_turned_field(number, direction, corners):
    assert_turns(number, corners, direction=direction)


@pytest.mark.parametrize("number", range(48))
def test_all_symmetries_of_one_scene(number):
    corners = [
        ((1, 1, 1), (5, 1.5, 1), (2, 4, 1.5)),
        ((0, 0, 0.5), (7, 0, 0.5), (7, 5, 0.5)),
        ((4, 1, 2), (5.2, 3, 4.4), (3.7, 3.9, 2.2)),
    ]
    assert_turns(number, corners, position=(3.3, 2.0, 3.9))
    assert_turns(number, corners, direction=(0.3, -0.2, -1.0))
    assert_turns(number, [])
