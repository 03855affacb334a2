"""Analytic reference in 3D: answers known in closed form."""

import numpy as np
import pytest
from volumes import area_of, moved, point, rectangle, room, unit, volume

from flatland.errors import InputError
from flatland.harmonics import SphericalHarmonics
from propagators.analytic import Analytic

#: Kirsch 2010, 2.1 and 2.2: the neighbour's front and side faces, seen from a cell's centre.
FRONT, SIDE = 4 * np.arctan(np.sqrt(11) / 33), 2 * np.arctan(3 * np.sqrt(11) / 11) - np.pi / 3
ROUNDING = 1e-13
#: Tolerance of the tests that converge, and what the answer may be off by.
FINE = 1e-6


def direct(tolerance=1e-4):
    return Analytic(bounces=False, tolerance=tolerance)


def neighbour_faces():
    """The five faces of the cell above the middle one that light leaves it by."""
    low, high = np.array([1, 1, 2]), np.array([2, 2, 3])
    front = [(1, 1, 3), (2, 1, 3), (2, 2, 3), (1, 2, 3)]
    sides = []
    for axis in (0, 1):
        for bound in (low, high):
            corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
            side = np.empty((4, 3))
            side[:, axis], side[:, 1 - axis] = bound[axis], 1 + corners[:, 0]
            side[:, 2] = 2 + corners[:, 1]
            sides.append(side)
    return [np.array(front, float), *sides]


@pytest.mark.parametrize("place", range(5))
def test_solid_angles_of_a_neighbours_faces_are_kirschs(place):
    shining = volume(
        (3, 3, 3), points=[point((1.5, 1.5, 1.5), 4 * np.pi)], walls=[neighbour_faces()[place]]
    )
    assert Analytic().absorbed(shining)[0] == pytest.approx(SIDE if place else FRONT, abs=ROUNDING)


def test_an_isotropic_point_sends_a_neighbour_a_sixth_of_its_flux():
    field = Analytic().solve(volume((3, 3, 3), points=[point((1.5, 1.5, 1.5), 6.0)]), 3)
    flux = field.scalar_flux()
    assert flux[1, 1, 1] == pytest.approx(6, abs=ROUNDING)
    assert flux[1, 1, 2] == pytest.approx(1, abs=ROUNDING)
    assert np.isclose(FRONT + 4 * SIDE, 2 * np.pi / 3, atol=ROUNDING)


def test_a_uniform_field_gives_the_projected_area_of_a_cell():
    size, spacing = 3, 0.5
    shining = volume(
        (size,) * 3,
        [(wall, np.pi * (size * spacing) ** 2) for wall, _ in room((size,) * 3)],
        spacing=spacing,
    )
    # Radiance 1 everywhere: I(ω) = h² (|ω_x| + |ω_y| + |ω_z|), numerics §1.
    directions = np.array([unit(way) for way in ((1, 2, 3), (-3, 1, -0.2), (0, 0, 1), (-1, 1, 0))])
    intensity = Analytic().intensity(shining, directions)
    expected = spacing**2 * np.abs(directions).sum(axis=1)
    np.testing.assert_allclose(
        intensity, np.broadcast_to(expected[:, None, None, None], intensity.shape), atol=ROUNDING
    )
    basis = SphericalHarmonics(6)
    series = spacing**2 * basis.clamped_cosine(np.concatenate([np.eye(3), -np.eye(3)])).sum(axis=0)
    values = Analytic().solve(shining, 6).values
    np.testing.assert_allclose(
        values, np.broadcast_to(series[:, None, None, None], values.shape), atol=ROUNDING
    )


def parallel_rectangles(a, b, c):
    """View factor of opposed a x b rectangles at distance c (Howell's catalogue, C-11)."""
    x, y = a / c, b / c
    u, v = 1 + x**2, 1 + y**2
    total = np.log(np.sqrt(u * v / (u + y**2))) - x * np.arctan(x) - y * np.arctan(y)
    total += x * np.sqrt(v) * np.arctan(x / np.sqrt(v)) + y * np.sqrt(u) * np.arctan(y / np.sqrt(u))
    return 2 * total / (np.pi * x * y)


def perpendicular_rectangles(common, height, width):
    """View factor of a common x width rectangle to a common x height one that stands on its edge
    (Howell's catalogue, C-14)."""
    h, w = height / common, width / common
    r = np.sqrt(h**2 + w**2)
    a = (1 + w**2) * (1 + h**2) / (1 + w**2 + h**2)
    b = w**2 * (1 + w**2 + h**2) / ((1 + w**2) * (w**2 + h**2))
    c = h**2 * (1 + h**2 + w**2) / ((1 + h**2) * (h**2 + w**2))
    total = w * np.arctan(1 / w) + h * np.arctan(1 / h) - r * np.arctan(1 / r)
    total += 0.25 * (np.log(a) + w**2 * np.log(b) + h**2 * np.log(c))
    return total / (np.pi * w)


@pytest.mark.parametrize(("a", "b", "c"), [(2.0, 3.0, 2.5), (3.1, 0.7, 0.9), (1.0, 1.0, 3.9)])
def test_view_factors_of_parallel_rectangles_are_those_of_the_textbook(a, b, c):
    light = rectangle((0.3, 0.4, 0.05), (a, 0, 0), (0, b, 0))
    scene = volume((4, 4, 4), [(light, 1.0)], [moved(light, z=c)])
    assert direct(FINE).absorbed(scene)[0] == pytest.approx(parallel_rectangles(a, b, c), rel=FINE)


@pytest.mark.parametrize(("common", "height", "width"), [(2, 3, 2.5), (3.3, 0.5, 1.1), (1, 1, 1)])
def test_view_factors_of_perpendicular_rectangles_are_those_of_the_textbook(common, height, width):
    # Where the two meet, the irradiance has a jump in slope without end: refined to the edge.
    light = rectangle((0.5, 0.2, 0.3), (common, 0, 0), (0, width, 0))
    wall = rectangle((0.5, 0.2, 0.3), (common, 0, 0), (0, 0, height))
    scene = volume((4, 4, 4), [(light, 1.0)], [wall])
    expected = perpendicular_rectangles(common, height, width)
    assert direct(FINE).absorbed(scene)[0] == pytest.approx(expected, rel=FINE)


def test_irradiance_on_the_axis_of_a_square_is_the_textbooks():
    # From a unit-radiance square of side 2 at distance 1, by Lambert's formula for a corner.
    light = rectangle((1, 1, 1), (2, 0, 0), (0, 2, 0))
    scene = volume((4, 4, 4), [(light, 4 * np.pi)])
    half = 1 / np.sqrt(2)
    expected = 4 * half * np.arctan(half)
    found = Analytic().irradiance_at(scene, [(2, 2, 2)], [(0, 0, -1)])
    assert found[0] == pytest.approx(expected, abs=ROUNDING)
    behind = Analytic().irradiance_at(scene, [(2, 2, 2), (2, 2, 0.5)], [(0, 0, 1), (0, 0, -1)])
    np.testing.assert_allclose(behind, 0, atol=ROUNDING)


def test_a_lobe_lights_surfaces_as_its_cosine_says():
    scene = volume((4, 4, 4), points=[point((1, 2, 2), 2.0, (0.6, 0.8, 0))])
    found = Analytic().irradiance_at(scene, [(3, 2, 2), (1, 1, 2)], [(-1, 0, 0), (0, 1, 0)])
    np.testing.assert_allclose(found, [2 * 0.6 / np.pi / 4, 0], atol=ROUNDING)


def test_a_lobe_in_a_cell_leaves_it_as_a_clamped_cosine():
    basis, axis = SphericalHarmonics(5), unit((1, -2, 0.5))
    values = (
        Analytic().solve(volume((3, 3, 3), points=[point((1.5, 1.5, 1.5), 2.0, axis)]), 5).values
    )
    np.testing.assert_allclose(values[:, 1, 1, 1], basis.lambertian(axis, 2.0), atol=ROUNDING)


def test_a_series_leaves_its_cell_unchanged_in_its_own_bands(rng):
    series = rng.normal(size=9)
    shining = volume((3, 3, 3), points=[point((1.5, 1.5, 1.5), 2.0, None, series)])
    for bands in (1, 2, 3, 5):
        values = Analytic().solve(shining, bands).values[:, 1, 1, 1]
        kept = min(9, bands**2)
        np.testing.assert_allclose(values[:kept], 2 * series[:kept], atol=ROUNDING)
        np.testing.assert_allclose(values[kept:], 0, atol=ROUNDING)


def test_parallel_light_crosses_each_cell_with_the_area_that_it_shows():
    way = unit((1, -2, 0.5))
    values = Analytic().solve(volume((3, 2, 2), beams=[(way, 3.0)], spacing=0.5), 4).values
    expected = 3.0 * 0.25 * np.abs(way).sum() * SphericalHarmonics(4).evaluate(way)
    np.testing.assert_allclose(
        values, np.broadcast_to(expected[:, None, None, None], values.shape), atol=ROUNDING
    )


def test_the_shadow_of_a_square_in_parallel_light_takes_its_area_out_of_faces():
    # A quarter of a face in size; its shadow moves a quarter cell to the side per cell down.
    wall = rectangle((1.25, 1.25, 2.0), (0.5, 0, 0), (0, 0.5, 0))
    way = np.array([0.25, 0.0, -1.0])
    scene = volume((3, 3, 3), walls=[wall], beams=[(way, np.linalg.norm(way))])
    flux = Analytic().solve(scene, 1).scalar_flux()
    lost = {(1, 1, 1): 0.25, (1, 1, 0): 0.125 + 0.125, (2, 1, 0): 0.125}
    expected = np.full((3, 3, 3), 1.25)
    for cell, share in lost.items():
        expected[cell] -= share
    np.testing.assert_allclose(flux, expected, atol=ROUNDING)


@pytest.fixture(scope="module")
def six_bands():
    light = rectangle((0.4, 0.6, 2.7), (0, 1.9, 0), (1.3, 0.2, 0))
    scene = volume((3, 3, 3), [(light, 1.0)], [rectangle((0.5, 0.9, 1.1), (1, 0, 0), (0, 1, 0.5))])
    return scene, direct(1e-3).solve(scene, 6).values


@pytest.mark.parametrize("bands", [1, 2, 3, 4, 5])
def test_fewer_bands_are_the_first_coefficients_of_more(bands, six_bands):
    scene, many = six_bands
    few = direct(1e-3).solve(scene, bands).values
    # Panels are cut where the errors of the bands asked for are largest: equal to the tolerance.
    assert np.linalg.norm(many[: bands**2] - few) < 1e-3 * np.linalg.norm(few)


def test_nothing_shines_in_the_dark():
    empty = volume((2, 2, 2), walls=[rectangle((0, 0, 1), (1, 0, 0), (0, 1, 0))], albedo=0.5)
    assert not np.any(Analytic().solve(empty, 3).values)
    assert not np.any(Analytic().intensity(empty, [(0, 0, 1)]))
    assert Analytic().energy(empty).emitted == 0
    assert Analytic().bounce_error(empty, 2) == 0


def test_a_light_without_area_is_refused():
    line = np.array([(0, 0, 1), (1, 0, 1), (0.5, 0, 1)], float)
    assert area_of(line) == 0
    with pytest.raises(InputError, match="vertices"):
        Analytic().solve(volume((2, 2, 2), [(line, 1.0)]), 2)


@pytest.mark.parametrize("directions", [[(1, 0)], [(1, 1, 0)], [(np.nan, 0, 0)]])
def test_directions_are_checked(directions):
    with pytest.raises(InputError, match=r"directions.*\(K, 3\)"):
        Analytic().intensity(volume(), directions)


def test_points_normals_and_dimension_are_checked():
    with pytest.raises(InputError, match=r"points.*\(K, 3\)"):
        Analytic().irradiance_at(volume(), [(1, 2)], [(1, 0, 0)])
    with pytest.raises(InputError, match="normals"):
        Analytic().irradiance_at(volume(), [(1, 2, 3)], [(1, 0, 0), (0, 1, 0)])
    with pytest.raises(InputError, match="2D only"):
        Analytic().arcs(volume(), (1, 2, 3))
