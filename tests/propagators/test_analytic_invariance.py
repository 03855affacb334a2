"""Analytic reference: descriptions of the same scene have the same answer."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, WALLS, make_scene

from propagators.analytic import Analytic

BANDS = 6
ROUNDING = 1e-12


@pytest.fixture(scope="module")
def values():
    return Analytic().solve(make_scene(), BANDS).values


def assert_same(scene, values):
    np.testing.assert_allclose(Analytic().solve(scene, BANDS).values, values, rtol=0, atol=ROUNDING)


def between(a, b, share):
    return tuple((1 - share) * np.array(a) + share * np.array(b))


def test_walls_cut_in_two(values):
    halves = [(a, between(a, b, 0.3)) for a, b in WALLS] + [
        (between(a, b, 0.3), b) for a, b in WALLS
    ]
    assert_same(make_scene(walls=halves), values)


def test_lights_cut_in_two(values):
    halves = [(a, between(a, b, 0.4), 0.4 * flux) for a, b, flux in LIGHTS] + [
        (between(a, b, 0.4), b, 0.6 * flux) for a, b, flux in LIGHTS
    ]
    assert_same(make_scene(lights=halves), values)


def test_walls_from_end_to_start(values):
    assert_same(make_scene(walls=[(b, a) for a, b in WALLS]), values)


def test_crossing_walls_cut_at_their_crossing(values):
    (a, b), (c, d), *others = WALLS
    matrix = np.array([np.subtract(b, a), np.subtract(c, d)]).T
    meeting = between(a, b, np.linalg.solve(matrix, np.subtract(c, a))[0])
    parts = [(a, meeting), (meeting, b), (c, meeting), (meeting, d)]
    assert_same(make_scene(walls=[*parts, *others]), values)


def test_walls_twice_and_in_another_order(values):
    assert_same(make_scene(walls=[*WALLS[::-1], *WALLS]), values)


def test_a_wall_behind_the_only_light_changes_nothing():
    lights = LIGHTS[:1]
    alone = Analytic().solve(make_scene(lights=lights, walls=()), BANDS).values
    assert_same(make_scene(lights=lights, walls=[((1.4, 0.4), (3.4, 0.9))]), alone)


def test_a_mirrored_scene_has_a_mirrored_answer(values):
    def flip(point):
        return 8 - point[0], point[1]

    # A mirror swaps left and right: the light's ends change places.
    scene = make_scene(
        lights=[(flip(b), flip(a), flux) for a, b, flux in LIGHTS],
        walls=[(flip(a), flip(b)) for a, b in WALLS],
    )
    m = (np.arange(2 * BANDS - 1) + 1) // 2
    sine = (np.arange(2 * BANDS - 1) % 2 == 0) & (m > 0)
    # θ -> π - θ: cos mθ -> (-1)^m cos mθ, sin mθ -> -(-1)^m sin mθ.
    sign = np.where(sine, -1.0, 1.0) * (-1.0) ** m
    assert_same(scene, sign[:, None, None] * values[:, ::-1])


def test_a_scene_turned_by_a_right_angle_has_a_turned_answer(values):
    def turn(point):
        return 8 - point[1], point[0]

    scene = make_scene(
        lights=[(turn(a), turn(b), flux) for a, b, flux in LIGHTS],
        walls=[(turn(a), turn(b)) for a, b in WALLS],
    )
    powers = 1j ** np.arange(1, BANDS)
    harmonics = (values[1::2] + 1j * values[2::2]) * powers[:, None, None]
    turned = values.copy()
    turned[1::2], turned[2::2] = harmonics.real, harmonics.imag
    assert_same(scene, np.moveaxis(turned[:, :, ::-1], 1, 2))


def test_units_do_not_matter(values):
    assert_same(make_scene(spacing=0.1), values)
