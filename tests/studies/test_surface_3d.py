"""Light on facets: where it is sampled, and how a field of known radiance fares."""

from __future__ import annotations

import numpy as np
import pytest

from flatland import Field, InputError, Scene, SphericalHarmonics, load_scene
from flatland.harmonics import basis_for
from studies.surface import surface_errors, surface_irradiance_error, surface_samples

RADIANCE = 3.0
GRID = {"shape": [6, 5, 4], "spacing": 0.5, "origin": [1.0, 0.0, -1.0]}
#: Upright and slanted; the half of it beyond z = 1 is out of the grid.
SLANTED = [[1.5, 0.5, -1.0], [3.5, 2.0, -1.0], [3.5, 2.0, 3.0], [1.5, 0.5, 3.0]]
FLOOR = [[1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [4.0, 0.0, 1.0], [4.0, 0.0, -1.0]]


class Uniform:
    """Light of the same radiance from everywhere, whatever stands in its way."""

    def irradiance_at(self, scene, points, normals):
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=1e-12)
        assert scene.grid.contains(points).all()
        falling = np.full(len(points), np.pi * RADIANCE)
        return falling * np.ones((scene.colours, 1)) if scene.colours else falling


@pytest.fixture(autouse=True)
def made_up(monkeypatch):
    monkeypatch.setattr("studies.surface.create", lambda name, **options: Uniform())


def scene_of(*occluders):
    return Scene.from_dict({"grid": GRID, "occluder": list(occluders)})


def quad(vertices, **keys):
    return {"kind": "quad", "vertices": vertices, **keys}


def uniform_field(scene, bands):
    """What leaves a cell in light of one radiance: L h² Σ|ω_i| (numerics §1)."""
    basis = SphericalHarmonics(bands)
    directions, weights = basis.quadrature(80)
    light = RADIANCE * scene.grid.spacing**2 * np.abs(directions).sum(axis=1)
    values = (weights * light) @ basis.evaluate(directions)
    return Field(scene.grid, basis, values[:, None, None, None] * np.ones(scene.grid.shape))


def test_samples_cover_both_sides_of_what_is_in_the_grid():
    samples = surface_samples(scene_of(quad(SLANTED)))
    length, depth = 2.5, 2.0
    assert samples.sizes.sum() == pytest.approx(2 * length * depth)
    np.testing.assert_allclose(samples.normals.T @ samples.sizes, 0, atol=1e-12)
    assert samples.sizes.max() <= 0.25 * np.hypot(0.25, 0.25 * 0.75) + 1e-12
    offset = (samples.points - SLANTED[0]) @ [-1.5, 2.0, 0.0]
    np.testing.assert_allclose(offset, 0, atol=1e-12)


def test_a_wall_on_the_border_is_sampled_inside_alone():
    samples = surface_samples(scene_of(quad(FLOOR)))
    assert samples.sizes.sum() == pytest.approx(6.0)
    np.testing.assert_allclose(samples.normals, np.tile([0, 1, 0], (96, 1)), atol=1e-12)
    np.testing.assert_allclose(samples.sizes, 0.25**2)


@pytest.mark.parametrize("vertices", [FLOOR, SLANTED])
def test_uniform_light_is_right_by_the_cosine_up_to_its_bands(vertices):
    scene = scene_of(quad(vertices))
    found = surface_irradiance_error(uniform_field(scene, 6), surface_samples(scene), "cosine")
    assert found.ratio == pytest.approx(1, abs=2e-3)
    assert found.error < 2e-3


def test_black_fields_are_wrong_by_one():
    scene = load_scene("cornell-3d")
    basis = basis_for(3, 2)
    black = Field(scene.grid, basis, np.zeros((3, 4, 16, 16, 16)))
    rows = surface_errors(black, surface_samples(scene))
    assert [row.error for row in rows] == [1.0] * 8


def test_scenes_without_occluders_have_no_surfaces():
    with pytest.raises(InputError, match="no occluders"):
        surface_samples(load_scene("fig5-one-light-3d"))
