"""What a surface gets through a polygon: integrals under a cosine that the horizon clamps."""

import numpy as np
import pytest
from sphere import FRONT_FACE, POLYGONS, cube_faces, over_polygon

from flatland.harmonics import SphericalHarmonics

#: Rounding of sums of a few hundred products.
ROUNDING = 2e-14


@pytest.mark.parametrize("bands", [1, 2, 3, 6, 10])
def test_cosine_over_the_whole_sphere_is_the_clamped_cosine(bands, rng):
    """Six faces of a cube, cut by horizons that lie anyhow."""
    basis, faces = SphericalHarmonics(bands), cube_faces()
    normals = np.vstack([np.eye(3), [[0.6, 0.0, 0.8]], rng.normal(size=(10, 3))])
    for normal in normals / np.linalg.norm(normals, axis=-1, keepdims=True):
        found = basis.polygon_cosine_integral(faces, normal).sum(axis=0)
        np.testing.assert_allclose(found, basis.clamped_cosine(normal), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 6, 10])
@pytest.mark.parametrize("name", ["front face", "side face", "octant"])
def test_cosine_over_a_polygon_above_the_horizon(name, bands):
    basis, vertices = SphericalHarmonics(bands), POLYGONS[name]
    normal = vertices.mean(axis=0) + 0.2 * vertices[0]
    normal /= np.linalg.norm(normal)
    directions, weights = over_polygon(vertices, 60)
    height = directions @ normal
    assert height.min() > 0
    expected = (weights * height) @ basis.evaluate(directions)
    found = basis.polygon_cosine_integral(vertices, normal)
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


def test_cosine_over_a_polygon_across_the_horizon():
    """Half of the front face, cut in its middle."""
    basis = SphericalHarmonics(8)
    half = 0.5 * np.array([(1, 1, 3), (0, 1, 3), (0, -1, 3), (1, -1, 3)])
    found = basis.polygon_cosine_integral(FRONT_FACE, [1.0, 0.0, 0.0])
    expected = basis.polygon_cosine_integral(half, [1.0, 0.0, 0.0])
    directions, weights = over_polygon(half, 40)
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(
        found, (weights * directions[:, 0]) @ basis.evaluate(directions), rtol=0, atol=ROUNDING
    )


def test_surface_gets_nothing_through_a_polygon_below_its_horizon():
    basis = SphericalHarmonics(5)
    found = basis.polygon_cosine_integral(FRONT_FACE, [[0.0, 0.0, -1.0], [0.0, 0.6, -0.8]])
    np.testing.assert_allclose(found, 0.0, atol=1e-16)
