"""Fields: coefficients in cells, and the fluxes they stand for."""

import numpy as np
import pytest

from flatland.errors import InputError
from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import CircularHarmonics, SphericalHarmonics, basis_for

#: Rounding of sums of about 100 numbers near 1.
ROUNDING = 1e-13

GRIDS = {2: Grid((3, 4)), 3: Grid((3, 2, 4))}
#: ∫ cos² over a half circle and a half sphere, over the lobe's flux 2 and π.
NET_SHARE = {2: np.pi / 4, 3: 2 / 3}


def random_field(rng, dimension, bands, colours=None):
    grid, basis = GRIDS[dimension], basis_for(dimension, bands)
    lead = () if colours is None else (colours,)
    return Field(grid, basis, rng.normal(size=(*lead, basis.size, *grid.shape)))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("flux", [1.0, 7.0])
def test_net_flux_of_a_lobe_points_along_it_and_is_its_cosine_moment(dimension, flux):
    grid, basis = GRIDS[dimension], basis_for(dimension, 2)
    normal = np.array({2: (0.6, -0.8), 3: (0.48, 0.6, -0.64)}[dimension])
    values = np.multiply.outer(basis.lambertian(normal, flux), np.ones(grid.shape))
    net = Field(grid, basis, values).net_flux()
    expected = np.multiply.outer(NET_SHARE[dimension] * flux * normal, np.ones(grid.shape))
    np.testing.assert_allclose(net, expected, rtol=ROUNDING)


@pytest.mark.parametrize("dimension", [2, 3])
def test_net_flux_of_isotropic_light_is_zero(dimension):
    field = Field(GRIDS[dimension], basis_for(dimension, 1), np.ones((1, *GRIDS[dimension].shape)))
    assert np.abs(field.net_flux()).max() < ROUNDING


@pytest.mark.parametrize("dimension", [2, 3])
def test_scalar_flux_is_the_integral_of_intensity(dimension, rng):
    field = random_field(rng, dimension, 3)
    directions, weights = field.basis.quadrature(6)
    integral = np.tensordot(weights, field.evaluate(directions), 1)
    np.testing.assert_allclose(field.scalar_flux(), integral, atol=ROUNDING)


def test_flux_of_colours_is_kept_apart(rng):
    field = random_field(rng, 2, 3, colours=4)
    one = Field(field.grid, field.basis, field.values[2])
    assert field.coloured
    assert field.total_flux().shape == (4,)
    assert field.total_flux()[2] == one.total_flux()
    np.testing.assert_array_equal(field.coefficient(1)[2], one.coefficient(1))
    np.testing.assert_allclose(field.net_flux()[2], one.net_flux(), atol=ROUNDING)


@pytest.mark.parametrize("colours", [None, 3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_more_bands_change_no_intensity(dimension, colours, rng):
    field = random_field(rng, dimension, 3, colours)
    wider = field.with_bands(5)
    directions, _ = field.basis.quadrature(6)
    found = wider.evaluate(directions)
    np.testing.assert_allclose(found, field.evaluate(directions), atol=ROUNDING)


@pytest.mark.parametrize("colours", [None, 3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_fewer_bands_keep_the_lower_ones(dimension, colours, rng):
    field = random_field(rng, dimension, 4, colours)
    narrower = field.with_bands(2)
    assert narrower.basis == basis_for(dimension, 2)
    for k in range(narrower.basis.size):
        np.testing.assert_array_equal(narrower.coefficient(k), field.coefficient(k))


@pytest.mark.parametrize("shape", [(5, 3, 3), (2, 3, 4), (1, 2, 5, 3, 4), (5, 4)])
def test_values_that_do_not_fit_are_refused(shape):
    with pytest.raises(InputError, match=r"the shape of values = .*must be \(5, 3, 4\)"):
        Field(GRIDS[2], CircularHarmonics(3), np.zeros(shape))


def test_basis_of_another_dimension_is_refused():
    with pytest.raises(InputError, match="basis = SphericalHarmonics.*2 dimensions"):
        Field(GRIDS[2], SphericalHarmonics(1), np.zeros((1, 3, 4)))
