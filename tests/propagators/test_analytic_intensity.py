"""Analytic reference: exact in angle (solve) and exact in space (intensity) meet."""

import numpy as np
import pytest
from analytic_scenes import make_scene, random_scene

from flatland.harmonics import CircularHarmonics
from propagators.analytic import Analytic

BANDS = 8


def projected(scene, count, offset=0.37):
    """Coefficients by the trapezoidal rule over the intensity."""
    angles = (np.arange(count) + offset) * (2 * np.pi / count)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    basis = CircularHarmonics(BANDS).evaluate(directions)
    intensity = Analytic().intensity(scene, directions)
    return np.tensordot(basis.T, intensity, 1) * (2 * np.pi / count)


def relative(values, reference):
    return np.linalg.norm(values - reference) / np.linalg.norm(reference)


def test_the_sum_over_directions_converges_to_the_coefficients():
    scene = make_scene()
    exact = Analytic().solve(scene, BANDS).values
    counts = np.array([512, 2048, 8192])
    errors = [relative(projected(scene, count), exact) for count in counts]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    # The intensity is continuous in angle, with kinks: second order.
    assert order > 1.7, errors
    assert errors[-1] < 2e-6, errors


@pytest.mark.parametrize(
    ("name", "count", "expected"),
    [("one light", 128, 0.0071), ("one light", 512, 5.5e-4), ("clutter", 256, 0.0045)],
)
def test_ray_effects_are_as_large_as_an_independent_beam_code_found(name, count, expected):
    scene = make_scene((32, 32), [((6, 1), (11, 1), 5)], ()) if name == "one light" else clutter()
    exact = Analytic().solve(scene, 2).values
    # Two digits were recorded (relative L2, 2 bands, midpoint rule).
    assert relative(projected(scene, count, 0.5)[:3], exact) == pytest.approx(expected, rel=0.02)


def clutter():
    rng = np.random.default_rng(7)
    middles, angles = rng.uniform(2, 62, (200, 2)), rng.uniform(0, np.pi, 200)
    halves = rng.uniform(0.5, 2, (200, 1)) / 2 * np.stack([np.cos(angles), np.sin(angles)], -1)
    lights = [((8.3, 4.1), (24.7, 6.2), 3), ((58.2, 52.1), (57.5, 38.4), 2)]
    return make_scene((64, 64), lights, list(zip(middles - halves, middles + halves)))


@pytest.mark.parametrize("step", [0.5, 1.0])
@pytest.mark.parametrize("seed", range(6))
def test_both_agree_where_everything_lines_up(seed, step):
    scene = random_scene(seed, step=step)
    exact = Analytic().solve(scene, BANDS).values
    assert np.abs(projected(scene, 2048) - exact).max() < 2e-4 * np.abs(exact).max()


def test_directions_along_the_axes_are_finite():
    scene = random_scene(3, step=1.0)
    axes = [[1, 0], [0, 1], [-1, 0], [0, -1]]
    values = Analytic().intensity(scene, axes)
    assert values.shape == (4, 8, 8)
    assert np.all(values >= 0)
    nearby = Analytic().intensity(scene, [[np.cos(1e-9), np.sin(1e-9)]])
    np.testing.assert_allclose(values[:1], nearby, rtol=0, atol=1e-6)


def test_colours_come_first():
    scene = make_scene(lights=[((1, 1), (3, 1), [1.0, 2.0])])
    values = Analytic().intensity(scene, [[0.6, 0.8]])
    assert values.shape == (2, 1, 8, 8)
    np.testing.assert_allclose(values[1], 2 * values[0])
