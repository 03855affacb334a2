"""LPV face by face: angles, directions, lobes, and the gain of every normalization."""

import numpy as np
import pytest
from scipy.integrate import quad
from stepping import Stepper

import propagators
from flatland.harmonics import CircularHarmonics

#: Rounding of one step, and what `quad` reaches on analytic functions.
ROUNDING = 1e-12
FRONT, SIDE = 2 * np.arctan(1 / 3), np.pi / 4 - np.arctan(1 / 3)
OFFSETS = [(1, 0), (0, 1), (-1, 0), (0, -1)]


def scheme(bands, **options):
    return propagators.create("lpv", **options).stencil(CircularHarmonics(bands))


def faces_of(offset):
    """Normals of the three faces of a neighbour that a cell's centre sees."""
    along = np.array(offset, float)
    across = np.array([-along[1], along[0]])
    return [along, across, -across]


def arc_of(offset, normal):
    """Angles, start < stop, that a face subtends at the source's centre."""
    centre = np.array(offset) + 0.5 * normal
    half = 0.5 * np.array([-normal[1], normal[0]])
    first, second = (np.arctan2(p[1], p[0]) for p in (centre - half, centre + half))
    width = (second - first + np.pi) % (2 * np.pi) - np.pi
    return (first, first + width) if width > 0 else (first + width, first)


def neighbour_of(stencil, coefficients, offset):
    """Coefficients that one cell of light sends to a neighbour in one step."""
    values = np.zeros((stencil.basis.size, 5, 5))
    values[:, 2, 2] = coefficients
    return Stepper(stencil, (5, 5)).step(values)[:, 2 + offset[0], 2 + offset[1]]


def test_faces_take_their_angle_of_isotropic_light():
    stencil = scheme(3)
    angles = stencil.reception[:, :, 0] * np.sqrt(2 * np.pi)
    np.testing.assert_allclose(angles, [[FRONT, SIDE, SIDE]] * 4, rtol=ROUNDING)
    np.testing.assert_allclose(angles.sum(axis=1), np.pi / 2, rtol=ROUNDING)


@pytest.mark.parametrize(
    ("sample", "degrees"),
    [("face-centre", np.degrees(np.arctan(1 / 2))), ("cone-centre", 31.717474411461)],
)
def test_direction_in_which_a_side_face_is_sampled(sample, degrees):
    reception = scheme(2, flux="central", sample=sample).reception[0]
    angles = np.degrees(np.arctan2(reception[:, 2], reception[:, 1]))
    np.testing.assert_allclose(angles, [0.0, degrees, -degrees], atol=1e-10)


@pytest.mark.parametrize("bands", [1, 2, 5])
@pytest.mark.parametrize("offset", OFFSETS)
def test_neighbour_stores_a_lobe_for_the_flux_on_each_face(bands, offset, rng):
    """Transfer: the flux is the integral of the intensity over the face's angle."""
    stencil = scheme(bands)
    basis = stencil.basis
    values = rng.normal(size=basis.size)
    expected = np.zeros(basis.size)
    for normal in faces_of(offset):
        flux = quad(lambda angle: basis.evaluate_angles(angle) @ values, *arc_of(offset, normal))[0]
        expected += basis.lambertian(normal, flux)
    np.testing.assert_allclose(neighbour_of(stencil, values, offset), expected, atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 5])
@pytest.mark.parametrize("sample", ["face-centre", "cone-centre"])
@pytest.mark.parametrize("offset", OFFSETS)
def test_central_flux_is_one_sample_a_face(bands, sample, offset, rng):
    stencil = scheme(bands, flux="central", sample=sample)
    basis = stencil.basis
    values = rng.normal(size=basis.size)
    expected = np.zeros(basis.size)
    for normal in faces_of(offset):
        start, stop = arc_of(offset, normal)
        centre = np.array(offset) + 0.5 * normal
        angle = np.arctan2(centre[1], centre[0]) if sample == "face-centre" else (start + stop) / 2
        flux = (stop - start) * basis.evaluate_angles(angle) @ values
        expected += basis.lambertian(normal, flux)
    np.testing.assert_allclose(neighbour_of(stencil, values, offset), expected, atol=ROUNDING)


@pytest.mark.parametrize("sample", ["face-centre", "cone-centre"])
def test_central_flux_conserves_up_to_four_bands(sample):
    """Samples in twelve directions of a square alias harmonics from m = 4 on."""
    for bands in range(1, 9):
        gain = scheme(bands, flux="central", sample=sample).flux_gain
        lost = np.abs(gain - np.eye(gain.size)[0]).max()
        assert (lost < 1e-12) == (bands <= 4)


@pytest.mark.parametrize("flux", ["transfer", "central"])
@pytest.mark.parametrize(
    ("options", "gain"),
    [
        ({"normalization": "conserving"}, 1.0),
        ({"normalization": "published"}, 1 / (2 * np.pi)),
        ({"normalization": "nvidia"}, 0.95),
        ({"normalization": "nvidia", "amplifier": "hierarchy"}, 0.75),
        ({"propagation_factor": 1.3}, 1.3),
        ({"normalization": "nvidia", "propagation_factor": 2.0}, 1.9),
    ],
    ids=str,
)
def test_gain_of_a_step(flux, options, gain):
    """A lobe in the middle of a grid, and all the light there is one step later."""
    stencil = scheme(2, flux=flux, **options)
    values = np.zeros((3, 9, 9))
    values[:, 4, 4] = stencil.basis.lambertian([0.6, 0.8])
    after = Stepper(stencil, (9, 9)).step(values)
    assert after[0].sum() / values[0].sum() == pytest.approx(gain, rel=ROUNDING)


@pytest.mark.parametrize("name", ["lpv", "lpv-2009", "dom4", "dom8"])
@pytest.mark.parametrize("factor", ["0.5", 0.0])
def test_propagation_factor_multiplies_the_whole_step(name, factor, rng):
    basis = CircularHarmonics(3)
    plain = propagators.create(name).stencil(basis).transfer
    damped = propagators.create(name, propagation_factor=factor).stencil(basis).transfer
    np.testing.assert_allclose(damped, float(factor) * plain, rtol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 5])
@pytest.mark.parametrize("offset", OFFSETS)
def test_lpv_2009_makes_one_lobe_of_one_sample(bands, offset, rng):
    """The intensity towards the neighbour, times its angle π/2, as one lobe along the step."""
    stencil = propagators.create("lpv-2009").stencil(CircularHarmonics(bands))
    basis = stencil.basis
    values = rng.normal(size=basis.size)
    direction = np.array(offset, float)
    flux = np.pi / 2 * basis.evaluate(direction) @ values
    expected = basis.lambertian(direction, flux)
    np.testing.assert_allclose(neighbour_of(stencil, values, offset), expected, atol=ROUNDING)


@pytest.mark.parametrize("bands", range(1, 7))
def test_lpv_2009_conserves_up_to_four_bands(bands):
    gain = propagators.create("lpv-2009").stencil(CircularHarmonics(bands)).flux_gain
    lost = np.abs(gain - np.eye(gain.size)[0]).max()
    assert (lost < 1e-12) == (bands <= 4)


@pytest.mark.parametrize(
    ("flux", "share"),
    [
        ("transfer", (np.sqrt(2) - 1) / 4),
        ("central", (FRONT + 2 * SIDE * 2 / np.sqrt(5)) / 4 - 1 / 4),
    ],
)
def test_clamp_creates_a_tenth_in_the_first_step_of_a_two_band_lobe(flux, share):
    """Two bands of a lobe, 1/(2π) + cos θ/4, send a negative flux to the cell behind.

    All three faces of that cell are negative, so that the clamp takes back all of it: 0.1036 of
    the light with exact fluxes, 0.1182 with samples.
    """
    stencil = scheme(2, flux=flux, clamp=True)
    values = np.zeros((3, 5, 5))
    values[:, 2, 2] = stencil.basis.lambertian([1.0, 0.0])
    _, _, sums = Stepper(stencil, (5, 5)).steps(values)
    assert sums.sent[0] / values[0].sum() - 1 == pytest.approx(share, abs=ROUNDING)


@pytest.mark.parametrize("bands", [2, 3, 5])
def test_clamp_never_destroys_light_of_a_conserving_scheme(bands, rng):
    stencil = scheme(bands, clamp=True)
    values = rng.normal(size=(stencil.basis.size, 6, 7))
    _, _, sums = Stepper(stencil, (6, 7)).steps(values, 5)
    before = np.concatenate([[values[0].sum()], sums.components[:-1, 0]])
    assert np.all(sums.sent > before * (1 - ROUNDING))
    assert sums.sent[0] > before[0] + 1  # random light is negative in many directions


def test_clamp_changes_nothing_where_no_intensity_is_negative():
    """One band is positive everywhere."""
    values = np.zeros((1, 6, 7))
    values[0, 3, 3] = 1.0
    plain, clamped = (
        Stepper(scheme(1, clamp=clamp), (6, 7)).steps(values, 5)[0] for clamp in (False, True)
    )
    np.testing.assert_allclose(clamped, plain, rtol=ROUNDING)
