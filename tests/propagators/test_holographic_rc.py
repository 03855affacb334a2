"""Holographic radiance cascades: a lattice that converges to the reference."""

import numpy as np
import pytest
from alike import mirrored, mirrored_scene, turned, turned_scene
from analytic_scenes import make_scene
from tabulated import clutter, error, exact
from test_analytic_known import BOX

from flatland import load_scene
from flatland.harmonics import CircularHarmonics
from propagators.holographic import HolographicCascades
from propagators.holographic.propagator import _cone_weights

every_rule = pytest.mark.parametrize("rays", ["extended", "cast"])


def holographic(**options):
    return HolographicCascades(**options)


def just_in_front():
    """Scene 1 with its light just off the lattice, as the code of the table had it."""
    return make_scene((32, 32), [((6, 1 + 1e-7), (11, 1 + 1e-7), 5)], ())


@pytest.mark.parametrize(
    ("scene", "options", "tabulated"),
    [
        (just_in_front, {"lattice": 2}, (0.095, 0.123, 0.145)),
        (just_in_front, {"lattice": 4}, (0.049, 0.063, 0.074)),
        (just_in_front, {"lattice": 4, "rays": "cast"}, (0.046, 0.053, 0.058)),
        (clutter, {"lattice": 2}, (0.114, 0.150, 0.187)),
        (clutter, {"lattice": 4}, (0.063, 0.082, 0.104)),
        (clutter, {"lattice": 4, "rays": "cast"}, (0.040, 0.051, 0.065)),
    ],
)
def test_errors_are_those_tabulated(scene, options, tabulated):
    made = scene()
    values, reference = holographic(**options).solve(made, 8).values, exact(made, 8)
    for bands, expected in zip((2, 4, 8), tabulated):
        size = 2 * bands - 1
        found = error(values[:size], reference[:size])
        assert found == pytest.approx(expected, rel=0.04), bands


@every_rule
def test_first_order_in_the_lattice(rays):
    scene = make_scene()
    reference, steps = exact(scene, 2), np.array([2, 4, 8, 16])
    errors = [
        error(holographic(lattice=int(g), rays=rays).solve(scene, 2).values, reference)
        for g in steps
    ]
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 0.8 < order < 1.5, (order, errors)
    assert errors[-1] < 0.03, errors


@every_rule
def test_inside_a_box_of_uniform_radiance_it_is_exact(rays):
    scene = make_scene(lights=BOX, walls=())
    found, reference = holographic(rays=rays).solve(scene, 8).values, exact(scene, 8)
    difference = np.abs(found - reference)
    assert difference[:, 1:-1, 1:-1].max() < 1e-13
    # A lattice point on a wall knows no light that starts there: half a step is lost.
    assert 0.1 < difference.max() < 0.5


@every_rule
def test_turned_and_mirrored_scenes_have_turned_and_mirrored_answers(rays):
    values = holographic(rays=rays).solve(make_scene(), 4).values
    for scene, expected in (
        (mirrored_scene(), mirrored(values)),
        (turned_scene(), turned(values)),
    ):
        found = holographic(rays=rays).solve(scene, 4).values
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_grids_need_not_be_square():
    """A long grid, and the same turned by a right angle."""
    light, wall = ((1.3, 2.1), (4.1, 2.2)), ((3.2, 4.4), (7.7, 3.1))

    def turn(point):
        return 6 - point[1], point[0]

    values = holographic().solve(make_scene((10, 6), [(*light, 1.0)], [wall]), 3).values
    scene = make_scene((6, 10), [(*map(turn, light), 1.0)], [tuple(map(turn, wall))])
    found = holographic().solve(scene, 3).values
    np.testing.assert_allclose(found, turned(values), rtol=0, atol=1e-12)
    assert error(found, exact(scene, 3)) < 0.25


def test_cones_cover_the_circle():
    basis = CircularHarmonics(6)
    for level in (1, 2, 5):
        total = sum(
            _cone_weights(basis, frame, level).sum(axis=0).reshape(3, -1).sum(axis=0)
            for frame in range(4)
        )
        expected = np.zeros(basis.size)
        # ∫ (|cos| + |sin|) y: numerics §1.
        expected[0], expected[7] = 8 / np.sqrt(2 * np.pi), -8 / (15 * np.sqrt(np.pi))
        np.testing.assert_allclose(total, expected, rtol=0, atol=1e-13)


def test_walls_send_back_what_beams_bring_them():
    scene = make_scene(albedo=0.7)
    found = error(holographic(lattice=8).solve(scene, 2).values, exact(scene, 2))
    assert found < 0.07
    assert error(exact(make_scene(), 2), exact(scene, 2)) > 4 * found


def test_light_gets_past_the_ends_of_walls():
    scene = load_scene("shelf")
    reference = exact(scene, 1)[0]
    values = holographic().solve(scene, 1).values[0]
    dark = reference <= 1e-12 * reference.max()
    assert 0.003 < values[dark].sum() / values.sum() < 0.03
