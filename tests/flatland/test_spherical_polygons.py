"""Integrals over spherical polygons: against quadrature on flat triangles, and known ones."""

import itertools

import numpy as np
import pytest
from sphere import FRONT_FACE, POLYGONS, SIDE_FACE, cube_faces, over_polygon, representation

from flatland.errors import InputError
from flatland.harmonics import SphericalHarmonics
from flatland.harmonics.spherical_polygons import arc_weights

#: Rounding of sums of a few hundred products; what the closed forms promise for 20 bands.
ROUNDING = 2e-14
#: Kirsch 2010, 2.2: faces of a neighbouring cell, seen from a cell's centre.
FRONT = 4 * np.arctan(np.sqrt(11) / 33)
SIDE = -np.pi / 3 + 2 * np.arctan(3 * np.sqrt(11) / 11)
every_polygon = pytest.mark.parametrize("name", POLYGONS)


def solid_angle(vertices):
    basis = SphericalHarmonics(1)
    return basis.polygon_integral(vertices)[..., 0] * basis.flux_weight


def by_quadrature(basis, vertices, count=60):
    directions, weights = over_polygon(vertices, count)
    return weights @ basis.evaluate(directions)


def random_turn(rng):
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return turn * np.linalg.det(turn)


def test_faces_of_a_neighbour_have_the_solid_angles_of_kirsch():
    found = solid_angle(np.array([FRONT_FACE, SIDE_FACE]))
    np.testing.assert_allclose(found, [FRONT, SIDE], rtol=1e-15)
    np.testing.assert_allclose(found, [0.4006696846, 0.4234313544], atol=5e-11)


def test_solid_angle_of_triangles_is_that_of_their_angles(rng):
    """Girard: the sum of a spherical triangle's angles, minus π."""
    for triangle in rng.normal(size=(30, 3, 3)):
        if np.linalg.det(triangle) < 0.05:
            continue
        angles = 0.0
        for a, b, c in (np.roll(triangle, -k, axis=0) for k in range(3)):
            first, second = np.cross(a, b), np.cross(a, c)
            angles += np.arccos(first @ second / np.linalg.norm(first) / np.linalg.norm(second))
        assert solid_angle(triangle) == pytest.approx(angles - np.pi, abs=1e-13)


@every_polygon
@pytest.mark.parametrize("bands", [1, 2, 3, 6, 10, 20])
def test_integral_is_that_of_quadrature(name, bands):
    basis = SphericalHarmonics(bands)
    # The wide polygon's flat pieces are seen at a slant of 10°: more points do not help it.
    tolerance = 1e-10 if name == "wide" else ROUNDING
    expected = by_quadrature(basis, POLYGONS[name])
    found = basis.polygon_integral(POLYGONS[name])
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance)


def test_integral_of_random_triangles_is_that_of_quadrature(rng):
    basis, compared = SphericalHarmonics(10), 0
    for triangle in rng.normal(size=(40, 3, 3)):
        vertices = triangle / np.linalg.norm(triangle, axis=-1, keepdims=True)
        clockwise = np.linalg.det(vertices) < 0
        if clockwise or np.linalg.norm(vertices.mean(axis=0)) < 0.7:
            continue  # a large triangle would need more points
        found = basis.polygon_integral(vertices)
        np.testing.assert_allclose(found, by_quadrature(basis, vertices), rtol=0, atol=ROUNDING)
        compared += 1
    assert compared >= 5


@every_polygon
@pytest.mark.parametrize("bands", [1, 2, 5, 10])
def test_gram_is_the_integral_of_products(name, bands):
    basis = SphericalHarmonics(bands)
    directions, weights = over_polygon(POLYGONS[name], 60)
    values = basis.evaluate(directions)
    found = basis.polygon_gram(POLYGONS[name])
    tolerance = 1e-10 if name == "wide" else ROUNDING
    np.testing.assert_allclose(found, (values.T * weights) @ values, rtol=0, atol=tolerance)
    np.testing.assert_array_equal(found, found.T)
    np.testing.assert_allclose(
        found[:, 0] * basis.flux_weight, basis.polygon_integral(POLYGONS[name]), atol=ROUNDING
    )


@pytest.mark.parametrize("bands", [1, 2, 6, 10])
def test_cube_faces_add_up_to_the_sphere(bands):
    basis, faces = SphericalHarmonics(bands), cube_faces()
    constant = np.eye(basis.size)[0] * basis.flux_weight
    total = basis.polygon_integral(faces).sum(axis=0)
    np.testing.assert_allclose(total, constant, rtol=0, atol=ROUNDING)
    total = basis.polygon_gram(faces).sum(axis=0)
    np.testing.assert_allclose(total, np.eye(basis.size), rtol=0, atol=ROUNDING)


@every_polygon
def test_parts_of_a_polygon_add_up(name):
    """Cut along a diagonal, and into triangles around a point inside."""
    basis, whole = SphericalHarmonics(10), POLYGONS[name]
    inside = np.array([0.2, 0.3, 0.5]) @ whole[:3]
    parts = np.array([[inside, a, b] for a, b in zip(whole, np.roll(whole, -1, axis=0))])
    expected = basis.polygon_integral(whole)
    np.testing.assert_allclose(
        basis.polygon_integral(parts).sum(axis=0), expected, rtol=0, atol=ROUNDING
    )
    if len(whole) > 3:
        rest = np.delete(whole, 1, axis=0)
        found = basis.polygon_integral(whole[:3]) + basis.polygon_integral(rest)
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@every_polygon
def test_turned_polygon_has_the_turned_integral(name, rng):
    basis, turn = SphericalHarmonics(10), random_turn(rng)
    mixing = representation(basis, turn)
    found = basis.polygon_integral(POLYGONS[name] @ turn.T)
    expected = mixing @ basis.polygon_integral(POLYGONS[name])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    found = basis.polygon_gram(POLYGONS[name] @ turn.T)
    expected = mixing @ basis.polygon_gram(POLYGONS[name]) @ mixing.T
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@every_polygon
def test_polygon_walked_backwards_has_the_negative_integral(name):
    basis, vertices = SphericalHarmonics(6), POLYGONS[name]
    expected = basis.polygon_integral(vertices)
    assert expected[0] > 0
    np.testing.assert_allclose(basis.polygon_integral(vertices[::-1]), -expected, atol=ROUNDING)


@every_polygon
def test_first_vertex_and_lengths_do_not_matter(name, rng):
    basis, vertices = SphericalHarmonics(6), POLYGONS[name]
    expected = basis.polygon_integral(vertices)
    other = np.roll(vertices, 1, axis=0) * 10 ** rng.uniform(-200, 200, (len(vertices), 1))
    np.testing.assert_allclose(basis.polygon_integral(other), expected, rtol=0, atol=ROUNDING)


@every_polygon
def test_repeated_vertices_and_vertices_on_edges_add_nothing(name):
    basis, vertices = SphericalHarmonics(10), POLYGONS[name]
    middles = vertices + 0.3 * (np.roll(vertices, -1, axis=0) - vertices)
    more = np.stack([vertices, vertices, middles], axis=1).reshape(-1, 3)
    expected = basis.polygon_integral(vertices)
    np.testing.assert_allclose(basis.polygon_integral(more), expected, rtol=0, atol=ROUNDING)
    # A vertex that rounding moves by 1e-16 makes an edge of any direction.
    nearly = np.repeat(vertices, 2, axis=0)
    nearly[::2] += 1e-16
    np.testing.assert_allclose(basis.polygon_integral(nearly), expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(
    "vertices",
    [np.ones((3, 3)), np.eye(3)[[0, 1, 1]], np.eye(3)[[0, 1, 0, 1]], np.eye(3)[[0, 1, 2, 1]]],
    ids=["point", "arc", "arc twice", "two arcs"],
)
def test_polygons_without_area_have_no_integral(vertices):
    basis = SphericalHarmonics(6)
    np.testing.assert_allclose(basis.polygon_integral(vertices), 0.0, atol=ROUNDING)
    np.testing.assert_allclose(basis.polygon_gram(vertices), 0.0, atol=ROUNDING)


@pytest.mark.parametrize("size", [1e-2, 1e-4, 1e-7])
def test_tiny_polygon_is_its_solid_angle_times_the_value_there(size):
    """To a relative 1e-15 over its size, which rounding its vertices costs as well."""
    basis, middle = SphericalHarmonics(6), np.array([0.48, -0.6, 0.64])
    across = np.array([0.8, 0.0, -0.6])
    corners = size * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) / 2
    vertices = middle + corners @ [across, np.cross(middle, across)]
    expected = by_quadrature(basis, vertices, 6)
    assert expected[0] * basis.flux_weight == pytest.approx(size**2, rel=1e-4)
    found = basis.polygon_integral(vertices)
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-15 * size)


@pytest.mark.parametrize("corners", [3, 4, 7])
@pytest.mark.parametrize("above", [1e-3, 1e-9, 0.0])
def test_polygon_that_nearly_is_a_hemisphere(corners, above, rng):
    """All of a half sphere, whose integrals are 2π ∫₀¹ y_l0 dz, but for a thin seam."""
    basis, turn = SphericalHarmonics(10), random_turn(rng)
    around = np.arange(corners) * 2 * np.pi / corners
    around[1:] += 0.3 * np.sin(around[1:])
    vertices = np.stack([np.cos(around), np.sin(around), np.full(corners, above)], axis=-1)
    nodes, weights = np.polynomial.legendre.leggauss(basis.bands)
    z = (nodes + 1) / 2
    meridian = np.stack([np.sqrt(1 - z**2), 0 * z, z], axis=-1)
    hemisphere = np.where(basis.orders == 0, np.pi * weights @ basis.evaluate(meridian), 0.0)
    found = basis.polygon_integral(vertices @ turn.T)
    # An arc's middle may lie 3 times as high as its ends, and |y| is below 2.
    seam = 2 * np.pi * 3 * above * 2
    expected = representation(basis, turn) @ hemisphere
    np.testing.assert_allclose(found, expected, rtol=0, atol=seam + 1e-12)


def test_polygons_come_in_batches(rng):
    """Any leading axes, one normal per polygon or one for all."""
    basis = SphericalHarmonics(4)
    batch = np.array([[FRONT_FACE, SIDE_FACE], [SIDE_FACE, FRONT_FACE]])
    normals = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    integral, gram = basis.polygon_integral(batch), basis.polygon_gram(batch)
    cosine = basis.polygon_cosine_integral(batch, normals)
    assert (integral.shape, gram.shape) == ((2, 2, 16), (2, 2, 16, 16))
    for i, j in itertools.product(range(2), repeat=2):
        single = batch[i, j]
        np.testing.assert_allclose(integral[i, j], basis.polygon_integral(single), atol=1e-15)
        np.testing.assert_allclose(gram[i, j], basis.polygon_gram(single), atol=1e-15)
        expected = basis.polygon_cosine_integral(single, normals[j])
        np.testing.assert_allclose(cosine[i, j], expected, atol=1e-15)


@pytest.mark.parametrize("degree", [0, 1, 5, 20])
@pytest.mark.parametrize("half", [0.0, 1e-8, 0.7, np.pi / 2])
def test_arc_weights_integrate_waves_up_to_their_degree(degree, half):
    weights = arc_weights(np.array(half), degree)
    angles = 2 * np.pi * np.arange(2 * degree + 1) / (2 * degree + 1)
    for m in range(degree + 1):
        expected = 2 * half if m == 0 else 2 * np.sin(m * half) / m
        assert weights @ np.cos(m * angles) == pytest.approx(expected, abs=1e-13 * half)
        assert weights @ np.sin(m * angles) == pytest.approx(0.0, abs=1e-13 * half)


@pytest.mark.parametrize(
    ("vertices", "rule"),
    [
        (np.eye(3)[:2], "at least 3 vertices"),
        (np.eye(4)[:, :2], r"\(\.\.\., V, 3\)"),
        (np.ones(3), "polygons of shape"),
        (np.diag([1.0, 1.0, 0.0]), "finite and not zero"),
        (np.diag([1.0, 1.0, np.nan]), "finite and not zero"),
        (np.diag([1.0, 1.0, np.inf]), "finite and not zero"),
        (np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0)]), "opposite neighbours"),
    ],
    ids=["two vertices", "flat", "vector", "zero", "nan", "infinite", "opposite"],
)
def test_what_is_no_polygon_is_refused(vertices, rule):
    with pytest.raises(InputError, match=rf"(?s)^vertices = .*{rule}"):
        SphericalHarmonics(2).polygon_integral(vertices)
