"""Exact beams: light that walls send back, in colours, and of points."""

import numpy as np
import pytest
from analytic_scenes import make_scene, room
from tabulated import error, exact
from test_beam import ROUNDING, beam

from flatland import load_scene
from flatland.errors import ConvergenceError
from propagators.analytic import Analytic


def test_bounces_are_those_of_radiosity():
    """Same elements, other exchange: the error is that of the ordinates."""
    scene = make_scene(albedo=0.7)
    reference = exact(scene, 4)
    assert error(exact(make_scene(), 4), reference) > 0.1
    errors = []
    for count in (128, 512):
        answer = beam(count).answer(scene, 4)
        errors.append(error(answer.field.values, reference))
        assert abs(answer.ledger.closure) < ROUNDING
        assert answer.ledger.reflected > 0.5
        books = Analytic().energy(scene)
        assert answer.ledger.left == pytest.approx(books.left, rel=3e-3)
    assert errors[0] < 5e-3
    assert errors[1] < errors[0] / 6, errors


def test_finer_elements_bring_the_bounce_closer():
    scene = load_scene("cornell-2d")
    reference = Analytic(element=0.125).solve(scene, 2).values
    errors = [
        error(beam(512, element=size).solve(scene, 2).values, reference) for size in (2.0, 0.5)
    ]
    assert errors[1] < errors[0] / 2, errors
    assert errors[1] < 2e-3


def test_walls_are_black_without_bounces():
    scene = make_scene(albedo=0.7)
    values = beam(64, bounces=False).solve(scene, 2).values
    np.testing.assert_array_equal(values, beam(64).solve(make_scene(), 2).values)


def test_light_in_a_closed_white_room_never_ends():
    cell = {"kind": "cell", "cell": [2, 3], "flux": 1.0}
    scene = make_scene(lights=(), walls=room(), albedo=1.0, points=[cell])
    with pytest.raises(ConvergenceError, match="albedo must be below 1"):
        beam(64).solve(scene, 1)


def test_colours_are_solved_one_by_one():
    lights = [((1.2, 1.1), (3.9, 1.7), [3.0, 1.0]), ((6.6, 6.8), (6.1, 4.3), [0.0, 2.0])]
    walls = [((2.1, 3.2), (4.7, 4.1)), ((5.2, 0.8), (5.6, 3.3))]
    both = beam(64).answer(make_scene(lights=lights, walls=walls, albedo=[0.5, 0.9]), 3)
    for k, albedo in enumerate((0.5, 0.9)):
        grey = [(a, b, flux[k]) for a, b, flux in lights]
        one = beam(64).answer(make_scene(lights=grey, walls=walls, albedo=albedo), 3)
        np.testing.assert_allclose(both.field.values[k], one.field.values, rtol=0, atol=1e-11)
        assert both.ledger.left[k] == pytest.approx(one.ledger.left, rel=1e-11)


def test_bounces_of_points_and_parallel_light():
    """`atrium` has both; elements end at no shadow edges here, which leaves 1e-3."""
    scene = load_scene("atrium")
    answer = beam().answer(scene, 2)
    assert error(answer.field.values, exact(scene, 2)) < 2e-3
    np.testing.assert_allclose(answer.ledger.closure, 0, atol=1e-11)
    np.testing.assert_allclose(answer.ledger.left, Analytic().energy(scene).left, rtol=2e-3)
