"""Analytic reference in 3D: intensity by direction, exact in space."""

import numpy as np
import pytest
import shapely
from volumes import LIGHTS, box, cornell, moved, point, rectangle, unit, volume

from flatland.harmonics import SphericalHarmonics
from propagators.analytic import Analytic

WALLS = [
    np.array([(2.0, 2.0, 2.2), (5.1, 2.7, 3.4), (2.6, 4.9, 1.6)]),
    *(vertices for vertices, _ in box((1.3, 3.2, 1.1), (3.2, 4.4, 2.7))),
]
ROUNDING = 1e-12


def directions(count):
    """Even over the sphere (Fibonacci lattice)."""
    k = np.arange(count) + 0.5
    z, azimuth = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=-1)


def test_intensity_integrates_to_the_coefficients():
    scene, ways = volume((6, 6, 6), LIGHTS, WALLS), directions(3000)
    intensity = Analytic().intensity(scene, ways)
    series = np.tensordot(SphericalHarmonics(3).evaluate(ways), intensity, (0, 0))
    exact = Analytic().solve(scene, 3).values
    # 3000 directions resolve shadows to about a hundredth of a cell's intensity.
    assert np.linalg.norm(4 * np.pi / 3000 * series - exact) < 5e-3 * np.linalg.norm(exact)


def test_intensity_of_a_light_over_a_face_is_its_projected_area():
    light = rectangle((1.25, 1.5, 1), (0.5, 0, 0), (0, 0.25, 0))
    flux = np.pi * 0.125
    scene = volume((3, 3, 3), [(light, flux)])
    up = Analytic().intensity(scene, [(0, 0, 1)])[0]
    expected = np.zeros((3, 3, 3))
    expected[1, 1, 1:] = 0.125
    np.testing.assert_allclose(up, expected, atol=ROUNDING)
    # Down there is none, and at 45 degrees half of it is over the next column after a cell.
    assert not Analytic().intensity(scene, [(0, 0, -1), (1, 0, 0)]).any()
    slanted = Analytic().intensity(scene, [unit((1, 0, 1))])[0]
    across = 0.125 * np.sqrt(0.5)
    assert slanted[1, 1, 1] == pytest.approx(across)
    assert slanted[2, 1, 1] == pytest.approx(across)
    assert slanted[2, 1, 2] == pytest.approx(across / 2 + across / 2)


def test_shadows_are_differences_of_projected_polygons():
    """One direction, every face, against polygons cut by shapely."""
    way, wall = (
        unit((0.3, -0.4, 1.0)),
        np.array([(1, 1, 2.4), (3.5, 1.2, 2.1), (2.2, 3.6, 2.9)], float),
    )
    light = np.array([(1, 2, 0.6), (4, 1.5, 1.2), (4.4, 4, 1.7), (2, 5, 1.1)], float)
    light[3] = light[0] + (light[2] - light[1])  # a parallelogram is planar
    ground = way / way[2]

    def shade(vertices, height):
        vertices = np.asarray(vertices)
        return shapely.Polygon((vertices + (height - vertices[:, 2:]) * ground)[:, :2])

    area = np.linalg.norm(np.cross(light[1] - light[0], light[3] - light[0]))
    scene = volume((5, 5, 5), [(light, np.pi * area)], [wall])
    found = Analytic().intensity(scene, [way])[0]
    # Flux through the tops of layers 3 and 4, all above light and wall.
    for layer in (3, 4):
        height = layer + 1
        seen = shapely.difference(shade(light, height), shade(wall, height))
        for i, j in np.ndindex(5, 5):
            top = shapely.intersection(seen, shapely.box(i, j, i + 1, j + 1)).area * way[2]
            beside = sum(
                side_area(shade, light, wall, way, axis, plane, other, layer)
                for axis, plane, other in ((0, i + 1, j), (1, j, i))
            )
            assert found[i, j, layer] == pytest.approx(top + beside, abs=1e-9)


def side_area(shade, light, wall, way, axis, plane, other, layer):
    """Flux through a side face above everything: what crosses it leaves a slanted strip below."""
    low, high = layer * 1.0, layer + 1.0
    corners = np.zeros((4, 3))
    corners[:, axis] = plane
    corners[:, 1 - axis] = [other, other + 1, other + 1, other]
    corners[:, 2] = [low, low, high, high]
    strip = shade(corners, 0.0)
    seen = shapely.difference(shade(light, 0.0), shade(wall, 0.0))
    return shapely.intersection(seen, strip).area * way[2]


def test_a_point_counts_in_the_cells_that_its_ray_crosses():
    lamp = point((0.5, 0.5, 0.5), 4 * np.pi)
    scene = volume((3, 3, 3), walls=[rectangle((2.2, 0, 0), (0, 3, 0), (0, 0, 3))], points=[lamp])
    found = Analytic().intensity(scene, [unit((1, 0.5, 0)), (0, 0, 1)])
    assert sorted(map(tuple, np.argwhere(found[0] > 0))) == [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    np.testing.assert_allclose(found[0][found[0] > 0], 1)
    assert sorted(map(tuple, np.argwhere(found[1] > 0))) == [(0, 0, 0), (0, 0, 1), (0, 0, 2)]


def test_parallel_light_is_left_out():
    assert not Analytic().intensity(volume(beams=[((0, 0, 1), 1.0)]), [(0, 0, 1)]).any()


def test_bounced_intensity_integrates_to_the_coefficients():
    scene, ways = cornell(6), directions(500)
    reference = Analytic(tolerance=2e-3)
    bounced = reference.intensity(scene, ways) - Analytic(bounces=False).intensity(scene, ways)
    assert bounced.min() > -ROUNDING
    series = 4 * np.pi / 500 * np.tensordot(bounced, SphericalHarmonics(2).evaluate(ways), (1, 0))
    exact = reference.solve(scene, 2).values - Analytic(bounces=False).solve(scene, 2).values
    difference = np.moveaxis(series, -1, 1) - exact
    assert np.linalg.norm(difference) < 2e-2 * np.linalg.norm(exact)


def test_intensity_of_colours_is_answered_apart():
    (first, _), (second, _) = LIGHTS
    scene = volume((6, 6, 6), [(first, [3.0, 0.0]), (second, [2.0, 1.0])], WALLS)
    found = Analytic().intensity(scene, np.eye(3))
    assert found.shape == (2, 3, 6, 6, 6)
    grey = Analytic().intensity(volume((6, 6, 6), LIGHTS, WALLS), np.eye(3))
    np.testing.assert_allclose(found[0], grey, atol=ROUNDING)


def test_moving_a_scene_by_whole_cells_moves_the_intensity():
    ways = directions(7)
    lights = [(moved(vertices, 1), flux) for vertices, flux in LIGHTS[1:]]
    near, far = (
        Analytic().intensity(volume((8, 6, 6), each), ways) for each in (LIGHTS[1:], lights)
    )
    np.testing.assert_allclose(far[:, 1:], near[:, :-1], atol=ROUNDING)
