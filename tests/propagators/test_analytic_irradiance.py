"""Analytic reference: irradiance of walls and of points with normals."""

import numpy as np
import pytest
from analytic_scenes import WALLS, make_scene

from flatland.errors import InputError
from propagators.analytic import Analytic

ROUNDING = 1e-12
CELL = {"kind": "cell", "cell": [3, 3], "flux": 2.0}
LOBE = {**CELL, "direction": [0.6, 0.8]}
EVERYTHING = make_scene(albedo=0.7, points=[LOBE], beams=[((0.6, -0.8), 1.5)], spacing=0.5)


def at(scene, point, normal, **options):
    return Analytic(**options).irradiance_at(scene, [point], [normal])[0]


def test_above_the_middle_of_a_light():
    # Radiance Φ / 2l, from -45° to 45°: E = L 2 sin 45°.
    scene = make_scene(lights=[((1, 1), (3, 1), 4.0)], walls=(), spacing=0.5)
    assert at(scene, (1.0, 1.0), (0, -1)) == pytest.approx(2 * 2 * np.sqrt(0.5))
    assert at(scene, (1.0, 1.0), (0, 1)) == pytest.approx(0, abs=ROUNDING)
    # Seen sideways only half of it counts: E = L (1 - sin 45°).
    assert at(scene, (1.0, 1.0), (1, 0)) == pytest.approx(2 * (1 - np.sqrt(0.5)))


@pytest.mark.parametrize("spacing", [1.0, 0.5])
def test_a_point_light_falls_off_with_distance(spacing):
    scene = make_scene(lights=(), walls=(), points=[CELL], spacing=spacing)
    found = at(scene, np.array([6.5, 7.5]) * spacing, (0, -1))
    assert found == pytest.approx(2 / (2 * np.pi * 5 * spacing) * 4 / 5)


def test_parallel_light_goes_with_the_cosine():
    scene = make_scene(lights=(), walls=[((1, 5), (3, 5))], beams=[((0, -1), 1.5)])
    assert at(scene, (5, 2), (0.6, 0.8)) == pytest.approx(1.5 * 0.8)
    assert at(scene, (5, 2), (0.6, -0.8)) == 0
    assert at(scene, (2, 2), (0, 1)) == 0
    assert at(scene, (2, 5), (0, 1)) == pytest.approx(1.5)  # on the wall itself
    assert at(scene, (2, 5), (0, -1)) == 0


def test_means_over_pieces_are_means_of_points():
    """Gauss points along each piece: the kinks of shadows of area lights leave the rest."""
    light = Analytic().irradiance(EVERYTHING)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    extent = light.stops - light.starts
    points = light.starts + (0.5 + 0.5 * nodes)[:, None, None] * extent
    normals = np.stack([-extent[:, 1], extent[:, 0]], -1) / np.hypot(*extent.T)[:, None]
    values = (
        Analytic()
        .irradiance_at(EVERYTHING, points.reshape(-1, 2), np.tile(normals, (24, 1)))
        .reshape(24, -1)
    )
    # Kinks, and the jumps where a bounce's element is seen to begin, take a few of the digits.
    np.testing.assert_allclose(weights @ values / 2, light.irradiance, rtol=0, atol=2e-3)


def test_absorbed_flux_is_the_rest_of_the_irradiance():
    light = Analytic().irradiance(EVERYTHING)
    received = np.hypot(*(light.stops - light.starts).T) * light.irradiance
    by_segment = np.bincount(light.segments, received)
    np.testing.assert_allclose(Analytic().absorbed(EVERYTHING), 0.3 * by_segment, rtol=1e-12)


def test_pieces_cover_both_sides_of_every_wall():
    light = Analytic(element=0.4).irradiance(EVERYTHING)
    lengths = np.hypot(*(light.stops - light.starts).T)
    assert lengths.max() <= 0.4 * 0.5 + ROUNDING
    expected = [2 * 0.5 * np.hypot(*np.subtract(b, a)) for a, b in WALLS]
    np.testing.assert_allclose(np.bincount(light.segments, lengths), expected)


def test_colours_come_first():
    scene = make_scene(lights=[((1, 1), (3, 1), [4.0, 2.0])], albedo=0.5)
    values = Analytic().irradiance_at(scene, [(2, 2), (3, 3)], [(0, -1), (1, 0)])
    assert values.shape == (2, 2)
    np.testing.assert_allclose(values[0], 2 * values[1])
    assert Analytic().irradiance(scene).irradiance.shape[0] == 2


@pytest.mark.parametrize(
    ("points", "normals", "name"),
    [
        ([(1, 2)], [(1, 1)], "normals"),
        ([(1, 2), (3, 4)], [(1, 0)], "normals"),
        ([(1, np.nan)], [(1, 0)], "points"),
        ((1, 2), (1, 0), "points"),
    ],
)
def test_points_and_normals_are_checked(points, normals, name):
    with pytest.raises(InputError, match=name):
        Analytic().irradiance_at(EVERYTHING, points, normals)
