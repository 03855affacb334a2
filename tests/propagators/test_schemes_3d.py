"""The schemes in three dimensions: faces, bins, conservation, symmetry, gains."""

import numpy as np
import pytest
from scipy.spatial import SphericalVoronoi
from sphere import cube_symmetries, over_polygon, representation
from stepping import Stepper, neighbours

import propagators
from flatland.errors import InputError
from flatland.harmonics import CircularHarmonics, SphericalHarmonics

#: Rounding of one step, and what quadrature reaches on the faces.
ROUNDING = 1e-12
AXIAL = neighbours(3, diagonal=False)
FRONT = 4 * np.arctan(np.sqrt(11) / 33)
SIDE = -np.pi / 3 + 2 * np.arctan(3 * np.sqrt(11) / 11)
CONSERVING = [
    ("lpv", {}),
    *((name, {"emission": e}) for name in ("dom6", "dom26") for e in ("bin", "delta")),
]
SCHEMES = [
    *CONSERVING,
    ("lpv", {"flux": "central"}),
    ("lpv", {"flux": "central", "sample": "cone-centre"}),
    ("lpv-2009", {}),
    *(
        (name, {"flux": "central", "emission": e})
        for name in ("dom6", "dom26")
        for e in ("bin", "delta")
    ),
]


def schemes(cases):
    return pytest.mark.parametrize(("name", "options"), cases, ids=[f"{n} {o}" for n, o in cases])


def scheme(name, bands, **options):
    return propagators.create(name, **options).stencil(SphericalHarmonics(bands))


def faces_of(offset):
    """Normals and corners of the five faces of a neighbour that a cell's centre sees."""
    along = np.array(offset, float)
    for normal in neighbours(3, diagonal=False):
        if normal @ along >= 0:
            centre = along + normal / 2
            free = np.flatnonzero(normal == 0)
            corners = np.repeat(centre[None], 4, axis=0)
            corners[:, free] += 0.5 * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
            yield normal.astype(float), corners


def neighbour_of(stencil, coefficients, offset):
    """Coefficients that one cell of light sends to a neighbour in one step."""
    values = np.zeros((stencil.basis.size, 3, 3, 3))
    values[:, 1, 1, 1] = coefficients
    return Stepper(stencil, (3, 3, 3)).step(values)[(slice(None), *(1 + np.array(offset)))]


@schemes(CONSERVING)
@pytest.mark.parametrize("bands", [1, 2, 3, 4, 5, 6, 10])
def test_conserving_schemes_send_all_their_flux(name, options, bands):
    gain = scheme(name, bands, **options).flux_gain
    np.testing.assert_allclose(gain, np.eye(bands**2)[0], rtol=0, atol=ROUNDING)


@schemes([case for case in SCHEMES if case not in CONSERVING])
def test_samples_conserve_up_to_four_bands(name, options):
    """The harmonics of degree 4 hold the first that looks alike along all axes of a cube."""
    for bands in range(1, 7):
        gain = scheme(name, bands, **options).flux_gain
        lost = np.abs(gain - np.eye(bands**2)[0]).max()
        assert (lost < ROUNDING) == (bands <= 4), (bands, lost)


@schemes(SCHEMES)
@pytest.mark.parametrize("bands", [1, 2, 4, 6])
def test_turned_light_is_sent_to_the_turned_neighbour(name, options, bands):
    """For all 48 rotations and reflections of the cube."""
    stencil = scheme(name, bands, **options)
    number = {tuple(offset): d for d, offset in enumerate(stencil.offsets.tolist())}
    for turn in cube_symmetries():
        mixing = representation(stencil.basis, turn)
        images = [number[tuple(image)] for image in (stencil.offsets @ turn.T).tolist()]
        found = stencil.transfer[images]
        np.testing.assert_allclose(found, mixing @ stencil.transfer @ mixing.T, atol=ROUNDING)


@pytest.mark.parametrize("flux", ["transfer", "central"])
def test_faces_take_their_solid_angle_of_isotropic_light(flux):
    stencil = scheme("lpv", 2, flux=flux)
    angles = stencil.reception[:, :, 0] * np.sqrt(4 * np.pi)
    np.testing.assert_allclose(angles, [[FRONT, *[SIDE] * 4]] * 6, rtol=1e-14)
    np.testing.assert_allclose(angles.sum(axis=1), 2 * np.pi / 3, rtol=1e-14)


@pytest.mark.parametrize("bands", [1, 2, 5])
@pytest.mark.parametrize("offset", [(1, 0, 0), (0, 0, -1)])
def test_neighbour_stores_a_lobe_for_the_flux_on_each_face(bands, offset, rng):
    """Transfer: the flux is the integral of the intensity over the face's solid angle."""
    stencil = scheme("lpv", bands)
    basis = stencil.basis
    values, expected = rng.normal(size=basis.size), np.zeros(basis.size)
    for normal, corners in faces_of(offset):
        directions, weights = over_polygon(corners)
        expected += basis.lambertian(normal, weights @ basis.evaluate(directions) @ values)
    np.testing.assert_allclose(neighbour_of(stencil, values, offset), expected, atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 5])
@pytest.mark.parametrize("sample", ["face-centre", "cone-centre"])
def test_central_flux_is_one_sample_a_face(bands, sample, rng):
    """Towards the middle of the square, or along ∫ ω dω, the middle of its visibility cone."""
    stencil = scheme("lpv", bands, flux="central", sample=sample)
    basis = stencil.basis
    values, expected = rng.normal(size=basis.size), np.zeros(basis.size)
    for normal, corners in faces_of((0, 1, 0)):
        directions, weights = over_polygon(corners)
        centre = corners.mean(axis=0) if sample == "face-centre" else weights @ directions
        centre /= np.linalg.norm(centre)
        expected += basis.lambertian(normal, weights.sum() * basis.evaluate(centre) @ values)
    np.testing.assert_allclose(neighbour_of(stencil, values, (0, 1, 0)), expected, atol=ROUNDING)


@pytest.mark.parametrize(
    ("sample", "degrees"), [("face-centre", np.degrees(np.arctan(1 / 2))), ("cone-centre", 32.9573)]
)
def test_direction_in_which_a_side_face_is_sampled(sample, degrees):
    """The paper's words and the samples that everyone takes lie 6.4° apart (5.2° in 2D)."""
    stencil = scheme("lpv", 2, flux="central", sample=sample)
    y, z, x = stencil.reception[0, :, 1:].T * np.array([[-1.0], [1.0], [-1.0]])
    sampled = np.stack([x, y, z], axis=-1)
    along = sampled @ stencil.offsets[0] / np.linalg.norm(sampled, axis=-1)
    tilt = np.degrees(np.arccos(np.minimum(along, 1.0)))
    np.testing.assert_allclose(tilt, [0.0, *[degrees] * 4], atol=1e-4)


@pytest.mark.parametrize(
    ("options", "gain"),
    [
        ({}, 1.0),
        ({"normalization": "published"}, 1 / (4 * np.pi)),
        ({"normalization": "nvidia"}, 0.95),
        ({"normalization": "nvidia", "amplifier": "hierarchy"}, 0.75),
        ({"propagation_factor": 1.3}, 1.3),
    ],
    ids=str,
)
@pytest.mark.parametrize("flux", ["transfer", "central"])
def test_gain_of_a_step(flux, options, gain):
    stencil = scheme("lpv", 3, flux=flux, **options)
    expected = gain * np.eye(stencil.basis.size)[0]
    np.testing.assert_allclose(stencil.flux_gain, expected, atol=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 5])
def test_lpv_2009_makes_one_lobe_of_one_sample(bands, rng):
    """The intensity towards the neighbour, times its solid angle 2π/3, as one lobe."""
    stencil = scheme("lpv-2009", bands)
    values, basis = rng.normal(size=stencil.basis.size), stencil.basis
    for offset in AXIAL:
        direction = offset.astype(float)
        expected = basis.lambertian(direction, 2 * np.pi / 3 * basis.evaluate(direction) @ values)
        np.testing.assert_allclose(neighbour_of(stencil, values, offset), expected, atol=ROUNDING)


@pytest.mark.parametrize("name", ["lpv", "lpv-2009", "dom6"])
def test_with_one_band_a_sixth_goes_to_each_axial_neighbour(name):
    np.testing.assert_allclose(scheme(name, 1).transfer, np.full((6, 1, 1), 1 / 6), rtol=1e-14)


@pytest.mark.parametrize("name", ["dom6", "dom26"])
def test_bins_are_the_voronoi_cells_of_the_neighbours(name):
    """What one band sends along an offset is its bin's share of the sphere."""
    stencil = scheme(name, 1)
    directions = stencil.offsets / np.linalg.norm(stencil.offsets, axis=1, keepdims=True)
    cells = SphericalVoronoi(directions)
    cells.sort_vertices_of_regions()
    shares = stencil.transfer[:, 0, 0]
    np.testing.assert_allclose(shares, cells.calculate_areas() / (4 * np.pi), atol=1e-12)


def test_three_kinds_of_bins_fill_the_sphere():
    stencil = scheme("dom26", 1)
    length = np.abs(stencil.offsets).sum(axis=1)
    angles = [stencil.transfer[length == k, 0, 0] * 4 * np.pi for k in (1, 2, 3)]
    assert [len(kind) for kind in angles] == [6, 12, 8]
    assert max(np.ptp(kind) for kind in angles) < 1e-15
    means = [kind.mean() for kind in angles]
    np.testing.assert_allclose(means, [0.575261946823, 0.464712275442, 0.442281453514], atol=1e-12)
    assert sum(kind.sum() for kind in angles) == pytest.approx(4 * np.pi, rel=1e-15)


@pytest.mark.parametrize("name", ["dom6", "dom26"])
def test_bins_hold_the_directions_nearest_to_their_neighbour(name):
    """Many bands restricted to a bin: little is left in the middles of the other ones."""
    stencil = scheme(name, 14)
    basis, directions = (
        stencil.basis,
        stencil.offsets / np.linalg.norm(stencil.offsets, axis=1, keepdims=True),
    )
    values = basis.evaluate(directions)
    ones = np.sqrt(4 * np.pi) * stencil.transfer[:, :, 0]
    shown = ones @ values.T
    np.testing.assert_allclose(shown, np.eye(len(directions)), atol=0.2)


@pytest.mark.parametrize("name", ["dom6", "dom26"])
@pytest.mark.parametrize("bands", [1, 3, 6])
def test_bins_split_every_intensity(name, bands):
    """Restrictions add up to what was there, and none of them gains in the L2 norm."""
    stencil = scheme(name, bands)
    np.testing.assert_allclose(stencil.transfer.sum(axis=0), np.eye(bands**2), atol=ROUNDING)
    eigenvalues = np.linalg.eigvalsh(stencil.transfer)
    assert eigenvalues.min() > -1e-14
    assert eigenvalues.max() < 1 + 1e-14
    assert stencil.spectral_radius() == pytest.approx(1.0, abs=1e-13)


@pytest.mark.parametrize("name", ["dom6", "dom26"])
def test_delta_emission_is_a_peak_along_the_step(name, rng):
    """It carries the flux of the bin, and integrates any f to f(d)."""
    delta, bins = scheme(name, 4, emission="delta"), scheme(name, 4)
    basis = delta.basis
    values, probe = rng.normal(size=(2, basis.size))
    for offset, peak, part in zip(delta.offsets, delta.transfer, bins.transfer):
        flux = (part @ values)[0] * basis.flux_weight
        assert (peak @ values)[0] * basis.flux_weight == pytest.approx(flux, abs=ROUNDING)
        along = basis.evaluate(offset / np.linalg.norm(offset)) @ probe
        assert probe @ peak @ values == pytest.approx(along * flux, abs=ROUNDING)


@pytest.mark.parametrize("name", ["dom6", "dom26"])
def test_schemes_of_space_refuse_circular_bases(name):
    with pytest.raises(InputError, match=r"dimension = 2: .*; accepted: 3"):
        propagators.create(name).stencil(CircularHarmonics(2))


def test_clamp_creates_a_ninth_in_the_first_step_of_a_two_band_lobe():
    """Two bands of a lobe, 1/(4π) + cos θ/(2π), send a negative flux to the cell behind.

    All five faces of that cell are negative, 1/6 − √2 acos(1/3)/(2π) together, and so is the hind
    face of each of the four cells beside. The clamp takes all of it back.
    """
    stencil = scheme("lpv", 2, clamp=True)
    values = np.zeros((4, 5, 5, 5))
    values[:, 2, 2, 2] = stencil.basis.lambertian([1.0, 0.0, 0.0])
    _, _, sums = Stepper(stencil, (5, 5, 5)).steps(values)
    (hind,) = (c for normal, c in faces_of((0, 1, 0)) if normal[0] < 0)
    directions, weights = over_polygon(hind)
    beside = weights @ (1 / (4 * np.pi) + directions[:, 0] / (2 * np.pi))
    assert beside < 0
    behind = 1 / 6 - np.sqrt(2) * np.arccos(1 / 3) / (2 * np.pi)
    assert sums.sent[0] / values[0].sum() - 1 == pytest.approx(-behind - 4 * beside, rel=1e-12)
    assert -behind - 4 * beside == pytest.approx(0.1153, abs=5e-5)
