"""Single scattering along view rays: closed forms, order of accuracy, phase functions."""

import numpy as np
import pytest
from scipy.integrate import quad

from flatland import Field, Grid, InputError
from flatland.harmonics import basis_for
from flatland.media import single_scattering
from flatland.radiance import cross_section
from flatland.sources import Segment

RADIANCE = 3.0
GRIDS = {2: Grid((8, 7), 0.5, (1.0, -2.0)), 3: Grid((6, 5, 7), 0.5, (1.0, -2.0, 0.5))}
DIMENSIONS = pytest.mark.parametrize("dimension", [2, 3])


def uniform(dimension, bands, colours=()):
    """The field of a constant radiance, of one or several colours."""
    grid, basis = GRIDS[dimension], basis_for(dimension, bands)
    cell = RADIANCE * grid.spacing ** (dimension - 1) * cross_section(basis)
    values = np.multiply.outer(cell, np.ones(grid.shape))
    return Field(grid, basis, np.multiply.outer(colours, values) if colours else values)


def random_rays(dimension, count=25):
    random, grid = np.random.default_rng(2), GRIDS[dimension]
    ways = random.normal(size=(count, dimension))
    points = random.uniform(grid.origin, grid.upper, (count, dimension))
    return points, ways / np.linalg.norm(ways, axis=1, keepdims=True)


@pytest.mark.parametrize("step", [0.3, 1.0, 100.0])
@pytest.mark.parametrize("anisotropy", [0.0, 0.8, -0.4])
@pytest.mark.parametrize("bands", [1, 3, 6])
@DIMENSIONS
def test_uniform_light_is_exact_at_any_step(dimension, bands, anisotropy, step):
    points, ways = random_rays(dimension)
    field = uniform(dimension, bands)
    seen = single_scattering(field, points, ways, 0.7, 0.2, anisotropy, step=step)
    expected = RADIANCE * 0.7 / 0.9 * (1 - np.exp(-0.9 * seen.lengths))
    np.testing.assert_allclose(seen.radiance, expected, rtol=1e-11)
    np.testing.assert_allclose(seen.transmittance, np.exp(-0.9 * seen.lengths), rtol=1e-14)
    assert seen.lengths.min() > 0


@DIMENSIONS
def test_thin_and_empty_media(dimension):
    points, ways = random_rays(dimension)
    thin = single_scattering(uniform(dimension, 2), points, ways, 1e-12)
    np.testing.assert_allclose(thin.radiance, 1e-12 * RADIANCE * thin.lengths, rtol=1e-9)
    empty = single_scattering(uniform(dimension, 2), points, ways, 0.0)
    np.testing.assert_array_equal(empty.radiance, 0.0)
    np.testing.assert_array_equal(empty.transmittance, 1.0)
    black = single_scattering(uniform(dimension, 2), points, ways, 0.0, 0.5)
    np.testing.assert_array_equal(black.radiance, 0.0)
    np.testing.assert_allclose(black.transmittance, np.exp(-0.5 * black.lengths))


@DIMENSIONS
def test_dense_medium_glows_like_its_surroundings(dimension):
    # Albedo 1 and no end to the fog: what comes out is the radiance around.
    points, ways = random_rays(dimension)
    fog = single_scattering(uniform(dimension, 2), points, ways, 1e3)
    deep = fog.lengths > 0.05
    assert deep.any()
    np.testing.assert_allclose(fog.radiance[deep], RADIANCE, rtol=1e-9)


def test_colours_are_independent():
    points, ways = random_rays(3)
    coloured = single_scattering(uniform(3, 2, (1.0, 0.5, 0.0)), points, ways, 0.4)
    grey = single_scattering(uniform(3, 2), points, ways, 0.4)
    assert coloured.radiance.shape == (3, len(points))
    np.testing.assert_allclose(coloured.radiance, np.outer([1.0, 0.5, 0.0], grey.radiance))


def linear(dimension):
    """An isotropic radiance that rises along x, 1 + x in cells from the first centre."""
    grid, basis = GRIDS[dimension], basis_for(dimension, 2)
    cell = grid.spacing ** (dimension - 1) * cross_section(basis)
    rise = 1 + np.arange(grid.shape[0])
    values = np.multiply.outer(cell, np.ones(grid.shape))
    return Field(grid, basis, values * rise.reshape(1, -1, *[1] * (dimension - 1)))


@DIMENSIONS
def test_steps_are_of_the_second_order(dimension):
    field = linear(dimension)
    grid, sigma = field.grid, 1.3
    origin = grid.cell_center((0,) * dimension)
    along = np.eye(dimension)[0]
    # Up to a wall in the last cell's middle, so that the source is linear all along.
    end = (grid.shape[0] - 1) * grid.spacing
    exact = quad(lambda t: sigma * np.exp(-sigma * t) * (1 + t / grid.spacing), 0, end)[0]
    stop = _wall_across(grid, origin[0] + end)
    steps, errors = np.array([1.0, 0.5, 0.25, 0.125]), []
    for step in steps:
        found = single_scattering(field, [origin], along, sigma, walls=[stop], step=step)
        assert found.lengths[0] == pytest.approx(end)
        errors.append(abs(float(found.radiance[0]) / exact - 1))
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 1.9 < order < 2.1, f"order {order:.2f}, errors {errors}"
    assert errors[0] < 0.03, errors


def _wall_across(grid, x):
    """A wall at right angles to x, all over the grid."""
    from flatland.sources import Facet

    low, high = np.array(grid.origin), np.array(grid.upper)
    if grid.dimension == 2:
        return Segment(np.array([x, low[1]]), np.array([x, high[1]]), np.zeros(1))
    corners = [(x, y, z) for y, z in [(low[1], low[2]), (high[1], low[2]), (high[1], high[2])]]
    return Facet(np.array([*corners, (x, low[1], high[2])]), np.zeros(1))


def henyey_greenstein(dimension, g, cosine):
    """The phase function in closed form; in 2D the Poisson kernel."""
    if dimension == 2:
        return (1 - g**2) / (1 + g**2 - 2 * g * cosine) / (2 * np.pi)
    return (1 - g**2) / (1 + g**2 - 2 * g * cosine) ** 1.5 / (4 * np.pi)


@pytest.mark.parametrize("g", [0.0, 0.6, -0.3])
@DIMENSIONS
def test_phase_function_is_that_of_henyey_and_greenstein(dimension, g):
    """Bands of the field times powers of g against an integral over the closed form."""
    grid, basis = GRIDS[dimension], basis_for(dimension, 4)
    cell = np.random.default_rng(5).normal(size=basis.size)
    field = Field(grid, basis, np.multiply.outer(cell, np.ones(grid.shape)))
    _, ways = random_rays(dimension, 9)
    middle = np.tile(np.array(grid.origin) + 0.5 * np.array(grid.extent), (9, 1))
    seen = single_scattering(field, middle, -ways, 1e-9, anisotropy=g)
    # Below five bands a cell's cross-section is the same from all sides.
    radiance = cell / {2: 4 / np.pi, 3: 1.5}[dimension] / grid.spacing ** (dimension - 1)
    directions, weights = basis.quadrature(120)
    phase = henyey_greenstein(dimension, g, ways @ directions.T)
    expected = phase @ (weights * (basis.evaluate(directions) @ radiance))
    np.testing.assert_allclose(seen.radiance / (1e-9 * seen.lengths), expected, atol=1e-8)


@DIMENSIONS
def test_a_beam_is_scattered_like_the_phase_function(dimension):
    """Many bands: a beam along an axis lights the medium; its shape is that of p."""
    grid, basis = GRIDS[dimension], basis_for(dimension, {2: 24, 3: 12}[dimension])
    cell = basis.evaluate(np.eye(dimension)[0])
    field = Field(grid, basis, np.multiply.outer(cell, np.ones(grid.shape)))
    ways = np.zeros((9, dimension))
    angles = np.linspace(0, np.pi, 9)
    ways[:, 0], ways[:, 1] = np.cos(angles), np.sin(angles)
    middle = np.tile(np.array(grid.origin) + 0.5 * np.array(grid.extent), (9, 1))
    seen = single_scattering(field, middle, -ways, 1e-9, anisotropy=0.4)
    found = seen.radiance / seen.lengths
    expected = henyey_greenstein(dimension, 0.4, np.cos(angles))
    np.testing.assert_allclose(found / found.mean(), expected / expected.mean(), rtol=0.03)


@pytest.mark.parametrize("g", [0.5, -0.7])
def test_forward_scattering_is_seen_against_the_light(g):
    grid, basis = GRIDS[2], basis_for(2, 2)
    cell = basis.lambertian(np.array([1.0, 0.0]))
    field = Field(grid, basis, np.multiply.outer(cell, np.ones(grid.shape)))
    middle = np.array(grid.origin) + 0.5 * np.array(grid.extent)
    ways = np.array([[-1.0, 0.0], [1.0, 0.0]])
    against, along = single_scattering(field, [middle] * 2, ways, 0.1, anisotropy=g).radiance
    assert (against > along) == (g > 0)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"scattering": -1.0}, ["scattering", "at least 0"]),
        ({"absorption": np.inf}, ["absorption", "finite"]),
        ({"anisotropy": 1.0}, ["anisotropy", "between -1 and 1"]),
        ({"step": -1.0}, ["step", "greater than 0"]),
        ({"directions": [1.0, 1.0]}, ["directions", "length 1"]),
        ({"origins": [[0.0, 0.0]]}, ["points", "outside"]),
    ],
)
def test_bad_media_are_refused(keys, words):
    valid = {"origins": [[2.0, 0.0]], "directions": [1.0, 0.0], "scattering": 0.1}
    with pytest.raises(InputError) as caught:
        single_scattering(uniform(2, 2), **{**valid, **keys})
    for word in words:
        assert word in str(caught.value)
