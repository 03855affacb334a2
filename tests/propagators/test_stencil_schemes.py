"""What every scheme of the registry must do, and which ones conserve flux."""

import itertools

import numpy as np
import pytest
from schemes import every_scheme, is_linear
from scipy.integrate import lebedev_rule
from stepping import Stepper, plain_step

import propagators
from flatland.errors import InputError
from flatland.harmonics import CircularHarmonics, SphericalHarmonics, basis_for

#: Rounding of one step of numbers near 1, for schemes whose matrices hold numbers up to about 3.
ROUNDING = 1e-12
BANDS = {2: 5, 3: 3}
SIDE = {2: 5, 3: 3}

CONSERVING = [
    ("lpv", {}),
    ("dom4", {}),
    ("dom4", {"emission": "delta"}),
    ("dom8", {}),
    ("dom8", {"emission": "delta"}),
]
conserving = pytest.mark.parametrize(
    ("name", "options"), CONSERVING, ids=[f"{name} {options}" for name, options in CONSERVING]
)


def prepared(propagator, dimension, rng):
    """A square grid's sweep and random light for it."""
    basis, shape = basis_for(dimension, BANDS[dimension]), (SIDE[dimension],) * dimension
    stepper = Stepper(propagator.stencil(basis), shape)
    return stepper, rng.normal(size=(basis.size, *shape))


def directions_and_weights(dimension):
    """Directions and weights that integrate all products of the bases used here."""
    if dimension == 3:
        points, weights = lebedev_rule(15)
        return points.T, weights
    angles = np.arange(32) * (np.pi / 16)
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1), np.full(32, np.pi / 16)


def symmetries(dimension):
    """All matrices that map the square or the cube to itself."""
    for order in itertools.permutations(range(dimension)):
        for signs in itertools.product((1, -1), repeat=dimension):
            yield np.diag(signs) @ np.eye(dimension)[list(order)]


def turned(values, basis, turn):
    """(gS)(x, ω) = S(g⁻¹x, g⁻¹ω) on a grid with equal sides."""
    dimension, side = basis.dimension, values.shape[1]
    directions, weights = directions_and_weights(dimension)
    mixing = (basis.evaluate(directions) * weights[:, None]).T @ basis.evaluate(directions @ turn)
    cells = np.indices(values.shape[1:]).reshape(dimension, -1)
    middle = (side - 1) / 2
    sources = np.rint(turn.T @ (cells - middle) + middle).astype(int)
    return (mixing @ values[(slice(None), *sources)]).reshape(values.shape)


@every_scheme()
def test_a_turned_or_mirrored_field_steps_to_the_turned_or_mirrored_field(
    propagator, dimension, rng
):
    stepper, values = prepared(propagator, dimension, rng)
    basis = stepper.sweep.stencil.basis
    after = stepper.step(values)
    for turn in symmetries(dimension):
        found = stepper.step(turned(values, basis, turn))
        expected = turned(after, basis, turn)
        np.testing.assert_allclose(found, expected, atol=ROUNDING, err_msg=str(turn))


@every_scheme()
def test_zero_stays_zero(propagator, dimension, rng):
    stepper, values = prepared(propagator, dimension, rng)
    assert not stepper.step(0 * values).any()


@every_scheme(is_linear)
def test_light_superposes(propagator, dimension, rng):
    stepper, first = prepared(propagator, dimension, rng)
    second = rng.normal(size=first.shape)
    together = stepper.step(2.0 * first - 3.0 * second)
    apart = 2.0 * stepper.step(first) - 3.0 * stepper.step(second)
    np.testing.assert_allclose(together, apart, atol=10 * ROUNDING)


@every_scheme(lambda propagator: not is_linear(propagator))
def test_clamped_light_scales_but_does_not_superpose(propagator, dimension, rng):
    stepper, values = prepared(propagator, dimension, rng)
    np.testing.assert_allclose(stepper.step(3 * values), 3 * stepper.step(values), atol=ROUNDING)
    assert np.abs(stepper.step(-values) + stepper.step(values)).max() > 1e-3


@every_scheme()
def test_light_goes_to_neighbours_only(propagator, dimension, rng):
    stepper, values = prepared(propagator, dimension, rng)
    middle = (slice(None), *[SIDE[dimension] // 2] * dimension)
    values[...], values[middle] = 0.0, rng.normal(size=len(values))
    reached = np.argwhere(stepper.step(values).any(axis=0)) - SIDE[dimension] // 2
    offsets = {tuple(offset) for offset in stepper.sweep.stencil.offsets}
    assert {tuple(place) for place in reached} <= offsets


@every_scheme(lambda propagator: 3 not in propagator.dimensions)
def test_flat_schemes_refuse_spherical_bases(propagator, dimension):
    with pytest.raises(InputError, match=r"dimension = 3: .*; accepted: 2"):
        propagator.stencil(SphericalHarmonics(2))


@conserving
@pytest.mark.parametrize("bands", [1, 2, 3, 4, 5, 6, 7, 8, 32])
def test_conserving_schemes_send_all_their_flux(name, options, bands):
    stencil = propagators.create(name, **options).stencil(CircularHarmonics(bands))
    np.testing.assert_allclose(stencil.flux_gain, np.eye(2 * bands - 1)[0], rtol=0, atol=1e-12)


@conserving
@pytest.mark.parametrize("bands", range(1, 9))
def test_conserving_schemes_lose_what_leaves_the_grid_and_no_more(name, options, bands, rng):
    stencil = propagators.create(name, **options).stencil(CircularHarmonics(bands))
    values = rng.normal(size=(stencil.basis.size, 4, 5))
    after, _, sums = Stepper(stencil, (4, 5)).steps(values)
    scale = np.abs(values[0]).sum()
    assert after[0].sum() + sums.left[0] == pytest.approx(values[0].sum(), abs=1e-12 * scale)
    assert sums.left[0] == pytest.approx(plain_step(stencil, values).left, abs=1e-12 * scale)


@pytest.mark.parametrize("name", ["dom4", "dom8"])
@pytest.mark.parametrize("bands", [1, 3, 5, 8, 16])
def test_bins_never_gain_in_the_l2_norm(name, bands, rng):
    """Projections onto disjoint bins: ‖A S‖ ≤ ‖S‖ for every field."""
    stencil = propagators.create(name).stencil(CircularHarmonics(bands))
    values = rng.normal(size=(stencil.basis.size, 5, 6))
    after = plain_step(stencil, values).arrived
    assert np.linalg.norm(after) <= np.linalg.norm(values) * (1 + ROUNDING)


@pytest.mark.parametrize("name", ["lpv", "lpv-2009", "dom4"])
def test_with_one_band_a_quarter_goes_to_each_axial_neighbour(name):
    stencil = propagators.create(name).stencil(CircularHarmonics(1))
    np.testing.assert_allclose(stencil.transfer, np.full((4, 1, 1), 0.25), rtol=ROUNDING)


@pytest.mark.parametrize(("name", "bands"), [("dom4", 4), ("dom8", 8)])
def test_one_sample_a_bin_conserves_until_harmonics_alias(name, bands):
    """The sum of cos mθ over K even directions vanishes for m < K and is K at m = K."""
    scheme = propagators.create(name, flux="central")
    for count in (bands, bands + 1):
        gain = scheme.stencil(CircularHarmonics(count)).flux_gain
        lost = np.abs(gain - np.eye(gain.size)[0]).max()
        assert (lost < 1e-12) == (count <= bands)


@pytest.mark.parametrize("name", ["dom4", "dom8"])
@pytest.mark.parametrize("emission", ["bin", "delta"])
def test_a_neighbour_gets_the_flux_of_its_bin(name, emission, rng):
    basis = CircularHarmonics(4)
    stencil = propagators.create(name, emission=emission).stencil(basis)
    values = rng.normal(size=basis.size)
    half = np.pi / len(stencil.offsets)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    for offset, transfer in zip(stencil.offsets, stencil.transfer):
        arc = np.arctan2(offset[1], offset[0]) + half * nodes
        flux = half * weights @ (basis.evaluate_angles(arc) @ values)
        assert (transfer @ values)[0] * basis.flux_weight == pytest.approx(flux, abs=1e-12)


@pytest.mark.parametrize("name", ["dom4", "dom8"])
@pytest.mark.parametrize("flux", ["transfer", "central"])
def test_bin_emission_is_the_intensity_in_the_bin(name, flux, rng):
    """The intensity itself with exact flux, that of the bin's middle all over it with one sample.

    Projected by Gauss nodes over the bin, since a jump converges slowly over the circle.
    """
    basis = CircularHarmonics(4)
    stencil = propagators.create(name, flux=flux, emission="bin").stencil(basis)
    values = rng.normal(size=basis.size)
    half = np.pi / len(stencil.offsets)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    for offset, transfer in zip(stencil.offsets, stencil.transfer):
        middle = np.arctan2(offset[1], offset[0])
        harmonics = basis.evaluate_angles(middle + half * nodes)
        intensity = harmonics @ values
        if flux == "central":
            intensity = np.full(20, basis.evaluate_angles(middle) @ values)
        expected = half * (weights * intensity) @ harmonics
        np.testing.assert_allclose(transfer @ values, expected, atol=ROUNDING)


@pytest.mark.parametrize("name", ["dom4", "dom8"])
def test_delta_emission_is_a_peak_along_the_step(name, rng):
    """What a neighbour stores is y(d) times a flux: it integrates any f to f(d)."""
    basis = CircularHarmonics(4)
    stencil = propagators.create(name, emission="delta").stencil(basis)
    values, probe = rng.normal(size=(2, basis.size))
    for offset, transfer in zip(stencil.offsets, stencil.transfer):
        stored = transfer @ values
        flux = stored[0] * basis.flux_weight
        along = basis.evaluate(offset / np.linalg.norm(offset)) @ probe
        assert probe @ stored == pytest.approx(along * flux, abs=1e-12)
