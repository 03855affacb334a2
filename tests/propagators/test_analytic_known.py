"""Analytic reference: answers known in closed form."""

import numpy as np
import pytest
from analytic_scenes import LIGHTS, make_scene

from flatland.errors import InputError
from propagators.analytic import Analytic
from propagators.analytic.targets import collect_light

BOX = [((0, 8), (0, 0), 16), ((8, 0), (8, 8), 16), ((0, 0), (8, 0), 16), ((8, 8), (0, 8), 16)]


def test_in_a_box_of_unit_radiance_every_cell_sends_out_its_projected_width():
    values = Analytic().solve(make_scene(lights=BOX, walls=()), 8).values
    # |cos| + |sin| = (4/pi) (1 - 2/15 cos 4θ - …): numerics §1.
    expected = np.zeros((15, 8, 8))
    expected[0], expected[7] = 8 / np.sqrt(2 * np.pi), -8 / (15 * np.sqrt(np.pi))
    np.testing.assert_allclose(values, expected, rtol=0, atol=1e-12)


def test_light_that_arrives_at_a_wall_on_faces_leaves_the_cell_it_comes_from():
    scene = make_scene(lights=BOX, walls=[((4, 0), (4, 8))])
    # Each side of the wall sees nothing but unit radiance: 2 per length.
    assert Analytic().absorbed(scene)[0] == pytest.approx(2 * 8 * 2, abs=1e-12)
    to_the_right = Analytic().intensity(scene, [[1, 0]])[0]
    np.testing.assert_allclose(to_the_right[:4], 1, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(to_the_right[4:], 0)
    values = Analytic().solve(scene, 4).values[0]
    np.testing.assert_allclose(values, values[::-1], rtol=0, atol=1e-12)


def test_one_direction_of_a_light_on_a_grid_line():
    scene = make_scene((32, 32), [((6, 1), (11, 1), 5)], ())
    intensity = Analytic().intensity(scene, [[np.sqrt(0.5), np.sqrt(0.5)]])[0]
    half = np.sqrt(0.5) / 2
    row = [0, half, 2 * half, 2 * half, 2 * half, 2 * half, half, 0]
    np.testing.assert_allclose(intensity[5:13, 1], row, rtol=0, atol=1e-9)
    np.testing.assert_allclose(intensity[6:14, 2], row, rtol=0, atol=1e-9)
    assert np.all(intensity[:, 0] == 0)


@pytest.mark.parametrize(("size", "distance"), [(1, 0.1), (1, 1), (1, 60), (1e-3, 1), (1e-6, 50)])
@pytest.mark.parametrize("bands", [1, 4, 64])
def test_strings_agree_with_quadrature_of_the_form_factor_kernel(size, distance, bands):
    turn = 0.3
    along = np.array([np.cos(turn), np.sin(turn)])
    near = np.array([0.2, distance])
    emitter = np.concatenate([near + size * along, near])[None]
    target = np.array([[[0.0, 0.0, 1.0, 0.0]]])
    moments = collect_light(target, emitter, np.ones((1, 1)), np.empty((0, 4)), bands)[0, 0]
    expected = quadrature(emitter[0], bands)
    np.testing.assert_allclose(moments, expected, rtol=0, atol=1e-11 * expected[0])


def quadrature(emitter, bands, count=400):
    """∫∫ cos cos' / ρ e^{imθ} over the emitter and the target from (0, 0) to (1, 0)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes, weights = 0.5 + 0.5 * nodes, 0.5 * weights
    extent = emitter[2:] - emitter[:2]
    start = emitter[:2] + nodes[:, None] * extent
    way = np.stack([nodes, 0 * nodes], -1)[None] - start[:, None]
    length = np.hypot(way[..., 0], way[..., 1])
    sent = (extent[0] * way[..., 1] - extent[1] * way[..., 0]) / length
    kernel = weights[:, None] * weights * sent * (-way[..., 1] / length) / length
    powers = ((way[..., 0] + 1j * way[..., 1]) / length) ** np.arange(bands)[:, None, None]
    harmonics = (kernel * powers).sum(axis=(1, 2))
    pairs = np.stack([harmonics.real, harmonics.imag], axis=-1)[1:]
    return np.concatenate([harmonics[:1].real, pairs.ravel()])


def test_more_bands_leave_the_lower_ones_as_they_are():
    few, many = (Analytic().solve(make_scene(), bands).values for bands in (3, 64))
    np.testing.assert_allclose(many[:5], few, rtol=0, atol=1e-13)
    assert np.all(np.isfinite(many))


def test_each_colour_is_the_scene_in_its_own_spectrum():
    lights = [(*LIGHTS[0][:2], [1.0, 0.0, 2.0]), (*LIGHTS[1][:2], [0.0, 3.0, 1.0])]
    coloured = Analytic().solve(make_scene(lights=lights), 3).values
    assert coloured.shape == (3, 5, 8, 8)
    for k, one in enumerate(coloured):
        grey = make_scene(lights=[(a, b, flux[k]) for a, b, flux in lights])
        np.testing.assert_allclose(one, Analytic().solve(grey, 3).values, rtol=0, atol=1e-13)


def test_no_light_is_no_field():
    assert not np.any(Analytic().solve(make_scene(lights=()), 3).values)
    assert Analytic().arcs(make_scene(lights=()), (1, 1)) == []


@pytest.mark.parametrize("directions", [[[1, 1]], [1, 0, 0], [[np.nan, 0]]])
def test_directions_must_be_unit_vectors(directions):
    with pytest.raises(InputError, match="directions"):
        Analytic().intensity(make_scene(), directions)
