"""Angular bases: orthonormal, and every closed form against independent quadrature."""

import itertools

import numpy as np
import pytest
from scipy.integrate import lebedev_rule, quad

from flatland.errors import InputError
from flatland.harmonics import CircularHarmonics, SphericalHarmonics, basis_for

#: Rounding of sums of a few hundred products.
ROUNDING = 1e-13
#: What lebedev_rule's nodes and weights are good for.
LEBEDEV = 1e-12


def circle(count):
    """Uniform angles on the circle: exact for harmonics below `count`."""
    angles = np.arange(count) * (2 * np.pi / count) + 0.1234
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1), np.full(count, 2 * np.pi / count)


def sphere(degree=47):
    points, weights = lebedev_rule(degree)
    return points.T, weights


def gauss(start, stop, count=200):
    """Gauss nodes and weights on an interval."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return start + (nodes + 1) * (stop - start) / 2, weights * (stop - start) / 2


def random_directions(rng, dimension, count):
    vectors = rng.normal(size=(count, dimension))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@pytest.mark.parametrize(("start", "stop", "angle"), [(0.3, 1.9, 0.7), (-2.0, 4.0, 2.5), (1, 1, 0)])
def test_cosine_over_an_arc_is_the_integral_it_claims_to_be(start, stop, angle):
    basis = CircularHarmonics(6)
    nodes, weights = gauss(start, stop)
    expected = (weights * np.cos(nodes - angle)) @ basis.evaluate_angles(nodes)
    found = basis.cosine_arc_integral(start, stop, angle)
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 7, 64])
def test_circular_harmonics_are_orthonormal(bands):
    directions, weights = circle(2 * bands)
    values = CircularHarmonics(bands).evaluate(directions)
    gram = (values * weights[:, None]).T @ values
    np.testing.assert_allclose(gram, np.eye(2 * bands - 1), atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 5, 10])
def test_spherical_harmonics_are_orthonormal(bands):
    directions, weights = sphere()
    values = SphericalHarmonics(bands).evaluate(directions)
    gram = (values * weights[:, None]).T @ values
    np.testing.assert_allclose(gram, np.eye(bands**2), atol=LEBEDEV)


def test_first_spherical_harmonics_are_those_of_kirsch(rng):
    x, y, z = (points := random_directions(rng, 3, 50)).T
    root = np.sqrt(3 / (4 * np.pi))
    expected = [np.full(50, 1 / (2 * np.sqrt(np.pi))), -root * y, root * z, -root * x]
    found = SphericalHarmonics(2).evaluate(points)
    np.testing.assert_allclose(found, np.stack(expected, axis=-1), atol=ROUNDING)


def test_circular_harmonics_are_cosines_and_sines_from_the_x_axis():
    theta = np.linspace(-3, 3, 13)
    points = np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    root = np.sqrt(np.pi)
    expected = [np.full(13, 1 / np.sqrt(2 * np.pi))]
    expected += [f(m * theta) / root for m in (1, 2) for f in (np.cos, np.sin)]
    found = CircularHarmonics(3).evaluate(points)
    np.testing.assert_allclose(found, np.stack(expected, axis=-1), atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 3, 8, 64])
def test_clamped_cosine_on_the_circle_is_its_integral(bands):
    """Over the half circle in front, cut at the lobe's edges, the integrand is smooth."""
    angle = 0.7
    theta, weights = gauss(angle - np.pi / 2, angle + np.pi / 2)
    basis = CircularHarmonics(bands)
    expected = (weights * np.cos(theta - angle)) @ basis.evaluate_angles(theta)
    found = basis.clamped_cosine([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(found, expected, atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 5, 10])
def test_clamped_cosine_on_the_sphere_is_its_integral(bands):
    """The half sphere about n by Gauss nodes in height and uniform ones around."""
    normal = np.array([2.0, -3.0, 6.0]) / 7
    first = np.array([3.0, 2.0, 0.0]) / np.sqrt(13)
    second = np.cross(normal, first)
    height, weights = gauss(0, 1, 20)
    around = np.arange(2 * bands) * np.pi / bands
    radius = np.sqrt(1 - height**2)[:, None, None]
    ring = np.cos(around)[:, None] * first + np.sin(around)[:, None] * second
    points = height[:, None, None] * normal + radius * ring
    values = SphericalHarmonics(bands).evaluate(points).mean(axis=1)
    expected = 2 * np.pi * (weights * height) @ values
    found = SphericalHarmonics(bands).clamped_cosine(normal)
    np.testing.assert_allclose(found, expected, atol=ROUNDING)


def test_two_bands_of_the_clamped_cosine_are_those_of_kirsch():
    """Kirsch 2010, equations 26 to 29: √π/2 and √(π/3) times −y, z, −x."""
    x, y, z = normal = np.array([2.0, -3.0, 6.0]) / 7
    root = np.sqrt(np.pi / 3)
    expected = [np.sqrt(np.pi) / 2, -root * y, root * z, -root * x]
    found = SphericalHarmonics(2).clamped_cosine(normal)
    np.testing.assert_allclose(found, expected, atol=ROUNDING)


@pytest.mark.parametrize(("dimension", "flux"), [(2, 2.0), (3, np.pi)])
def test_flux_of_a_clamped_cosine(dimension, flux, rng):
    basis = basis_for(dimension, 3)
    lobes = basis.clamped_cosine(random_directions(rng, dimension, 5))
    np.testing.assert_allclose(lobes[:, 0] * basis.flux_weight, flux, rtol=ROUNDING)


@pytest.mark.parametrize("dimension", [2, 3])
def test_lambertian_lobe_is_a_clamped_cosine_of_the_flux_asked_for(dimension, rng):
    basis = basis_for(dimension, 4)
    normal = random_directions(rng, dimension, 1)[0]
    lobe = basis.lambertian(normal, 3.5)
    assert lobe[0] * basis.flux_weight == pytest.approx(3.5, rel=ROUNDING)
    cosine = basis.clamped_cosine(normal)
    np.testing.assert_allclose(lobe / lobe[0], cosine / cosine[0], atol=ROUNDING)


@pytest.mark.parametrize("dimension", [2, 3])
def test_isotropic_light_has_the_same_intensity_everywhere(dimension, rng):
    basis = basis_for(dimension, 4)
    directions = random_directions(rng, dimension, 20)
    intensity = basis.evaluate(directions) @ basis.isotropic(5.0)
    np.testing.assert_allclose(intensity, 5.0 / basis.total_angle, rtol=ROUNDING)


@pytest.mark.parametrize(("start", "stop"), [(0.3, 1.1), (-2.0, 4.0), (1.0, 1.0), (2.0, -0.5)])
def test_arc_integral_is_the_integral_over_the_arc(start, stop):
    basis = CircularHarmonics(4)
    expected = [
        quad(lambda theta, k=k: basis.evaluate_angles(theta)[k], start, stop)[0]
        for k in range(basis.size)
    ]
    np.testing.assert_allclose(basis.arc_integral(start, stop), expected, atol=ROUNDING)


def test_arc_integral_of_a_tiny_arc_keeps_all_digits():
    basis, width = CircularHarmonics(64), 1e-9
    found = basis.arc_integral(1.0, 1.0 + width) / ((1.0 + width) - 1.0)
    # The function changes by at most m · width over the arc.
    middle = basis.evaluate_angles(1.0 + width / 2)
    np.testing.assert_allclose(found, middle, atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 3, 20])
@pytest.mark.parametrize(("start", "stop"), [(0.2, 1.9), (-3.0, 3.0)])
def test_arc_gram_is_the_integral_of_products(bands, start, stop):
    basis = CircularHarmonics(bands)
    theta, weights = gauss(start, stop)
    values = basis.evaluate_angles(theta)
    expected = (values * weights[:, None]).T @ values
    np.testing.assert_allclose(basis.arc_gram(start, stop), expected, atol=ROUNDING)


def test_arcs_that_tile_the_circle_add_up_to_everything():
    basis, cuts = CircularHarmonics(9), np.array([0.0, 0.4, 2.0, 3.7, 2 * np.pi])
    total = sum(basis.arc_gram(a, b) for a, b in itertools.pairwise(cuts))
    np.testing.assert_allclose(total, np.eye(basis.size), atol=ROUNDING)


@pytest.mark.parametrize(("dimension", "bands"), [(2, 1), (2, 6), (2, 64), (3, 1), (3, 4), (3, 10)])
def test_projection_of_a_band_limited_function_is_exact(dimension, bands, rng):
    basis = basis_for(dimension, bands)
    coefficients = rng.normal(size=basis.size)
    found = basis.project(lambda directions: basis.evaluate(directions) @ coefficients)
    np.testing.assert_allclose(found, coefficients, atol=ROUNDING)


def test_projection_of_a_constant_is_isotropic():
    found = SphericalHarmonics(3).project(lambda directions: 2.0)
    np.testing.assert_allclose(found, SphericalHarmonics(3).isotropic(8 * np.pi), atol=ROUNDING)


@pytest.mark.parametrize(("dimension", "degree"), [(2, 1), (2, 12), (2, 13), (3, 1), (3, 8)])
def test_quadrature_integrates_harmonics_up_to_its_degree(dimension, degree):
    """All harmonics above band 0 integrate to zero."""
    basis = basis_for(dimension, degree + 1)
    directions, weights = basis.quadrature(degree)
    expected = np.zeros(basis.size)
    expected[0] = basis.flux_weight
    np.testing.assert_allclose(weights @ basis.evaluate(directions), expected, atol=ROUNDING)


@pytest.mark.parametrize(("dimension", "bands"), [(2, 9), (3, 6)])
def test_basis_keeps_its_shape_under_rotation(dimension, bands, rng):
    """Addition theorem: Σ y(ω) y(ω') depends on the angle between ω and ω' alone."""
    basis = basis_for(dimension, bands)
    turn, _ = np.linalg.qr(rng.normal(size=(dimension, dimension)))
    a, b = random_directions(rng, dimension, 2)
    kernel = basis.evaluate(a) @ basis.evaluate(b)
    assert basis.evaluate(turn @ a) @ basis.evaluate(turn @ b) == pytest.approx(kernel, abs=1e-12)


@pytest.mark.parametrize(("dimension", "bands"), [(2, 9), (3, 6)])
def test_turned_lobe_is_the_lobe_of_the_turned_normal(dimension, bands, rng):
    """⟨Rn|Rω⟩ = ⟨n|ω⟩, evaluated at directions."""
    basis = basis_for(dimension, bands)
    turn, _ = np.linalg.qr(rng.normal(size=(dimension, dimension)))
    normal = random_directions(rng, dimension, 1)[0]
    directions = random_directions(rng, dimension, 10)
    expected = basis.evaluate(directions) @ basis.clamped_cosine(normal)
    found = basis.evaluate(directions @ turn.T) @ basis.clamped_cosine(turn @ normal)
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_coefficients_are_listed_band_by_band(dimension):
    basis = basis_for(dimension, 5)
    counts = np.bincount(basis.degrees)
    assert np.all(np.diff(basis.degrees) >= 0)
    assert counts.tolist() == {2: [1, 2, 2, 2, 2], 3: [1, 3, 5, 7, 9]}[dimension]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("bands", [0, -1, 2.5, "3", None, True], ids=repr)
def test_bad_bands_are_refused(dimension, bands):
    with pytest.raises(InputError, match=r"^bands = .*: must be a whole number, at least 1"):
        basis_for(dimension, bands)


def test_bands_of_numpy_integers_are_accepted():
    assert basis_for(2, np.int32(3)) == CircularHarmonics(3)


def test_dimension_without_basis_is_refused():
    with pytest.raises(InputError, match=r"dimension = 4: .*; accepted: 2, 3"):
        basis_for(4, 2)


@pytest.mark.parametrize(
    "vector", [(2.0, 0.0), (0.0, 0.0), (np.nan, 1.0), (1.0, 0.0, 0.0), 1.0], ids=repr
)
@pytest.mark.parametrize("method", ["evaluate", "clamped_cosine"])
def test_what_is_no_unit_vector_is_refused(method, vector):
    argument = {"evaluate": "directions", "clamped_cosine": "normals"}[method]
    with pytest.raises(InputError, match=rf"^{argument} = "):
        getattr(CircularHarmonics(2), method)(vector)


def test_bases_are_equal_if_dimension_and_bands_are():
    assert CircularHarmonics(3) == CircularHarmonics(3)
    assert CircularHarmonics(3) != CircularHarmonics(4)
    assert CircularHarmonics(1) != SphericalHarmonics(1)
    assert len({CircularHarmonics(3), CircularHarmonics(3), SphericalHarmonics(3)}) == 2
