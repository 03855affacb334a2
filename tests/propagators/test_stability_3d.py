"""Spectral radii in three dimensions: the table, and waves that brute force tries."""

import itertools

import numpy as np
import pytest

import propagators
from flatland.harmonics import SphericalHarmonics

#: Half a unit of the table's last digit.
FOUR_DIGITS = 5e-5
CONE = {"flux": "central", "sample": "cone-centre"}
#: Radius for 1 … 6 bands. As in 2D, samples lose light from 5 bands on, and peaks that are stored
#: along the step gain where a bin's flux is sharper than its peak allows: from 3 bands with 6
#: neighbours and from 5 with 26. One sample of 26 unequal bins gains from 3.
TABLE = [
    ("lpv", {}, [1, 1, 1, 1, 1, 1]),
    ("lpv", {"flux": "central"}, [1, 1, 1, 1, 0.9228, 0.9228]),
    ("lpv", CONE, [1, 1, 1, 1, 0.9656, 0.9656]),
    ("lpv-2009", {}, [1, 1, 1, 1, 0.78125, 0.78125]),
    ("dom6", {}, [1, 1, 1, 1, 1, 1]),
    ("dom6", {"emission": "delta"}, [1, 1, 1.3783, 1.4166, 1.4472, 1.4472]),
    ("dom6", {"flux": "central"}, [1, 1, 1.3783, 1.4166, 1.4472, 1.4472]),
    ("dom6", {"flux": "central", "emission": "delta"}, [1, 1, 2.5, 3.3333, 6.25, 7]),
    ("dom26", {}, [1, 1, 1, 1, 1, 1]),
    ("dom26", {"emission": "delta"}, [1, 1, 1, 1, 1.3230, 1.3230]),
    ("dom26", {"flux": "central"}, [1, 1, 1, 1, 1.3230, 1.3230]),
    (
        "dom26",
        {"flux": "central", "emission": "delta"},
        [1, 1, 1.0240, 1.0950, 2.2470, 2.3435],
    ),
]
CASES = [
    (name, options, bands, radius)
    for name, options, radii in TABLE
    for bands, radius in enumerate(radii, start=1)
]


def scheme(name, bands, **options):
    return propagators.create(name, **options).stencil(SphericalHarmonics(bands))


def brute_force(stencil, count):
    """Largest |eigenvalue| of the whole symbol on a grid over the whole zone."""
    axis = np.linspace(-np.pi, np.pi, count, endpoint=False)
    waves = np.array(list(itertools.product(axis[: count // 2 + 1], axis, axis)))
    return np.abs(np.linalg.eigvals(stencil.symbol(waves))).max()


@pytest.mark.parametrize(("name", "options", "bands", "radius"), CASES)
def test_known_radii(name, options, bands, radius):
    found = scheme(name, bands, **options).spectral_radius()
    assert found == pytest.approx(radius, abs=FOUR_DIGITS)


@pytest.mark.parametrize(("name", "options", "radii"), TABLE)
def test_no_wave_grows_faster_than_the_radius(name, options, radii):
    """And some wave of the grid, with steps of 0.39, grows nearly as fast."""
    stencil = scheme(name, 3, **options)
    sampled, radius = brute_force(stencil, 16), stencil.spectral_radius()
    assert sampled - 1e-9 <= radius <= sampled * 1.01


@pytest.mark.slow
@pytest.mark.parametrize(("name", "options", "radii"), TABLE)
@pytest.mark.parametrize("bands", [2, 4, 5, 6])
def test_no_wave_of_a_fine_grid_grows_faster(name, options, radii, bands):
    """Steps of 0.13, 0.26 where eigenvalues are dear."""
    stencil = scheme(name, bands, **options)
    sampled = brute_force(stencil, 48 if bands == 2 else 24)
    radius = stencil.spectral_radius()
    assert sampled - 1e-9 <= radius <= sampled * 1.005


@pytest.mark.parametrize("bands", range(1, 7))
@pytest.mark.parametrize("name", ["lpv", "lpv-2009", "dom6", "dom26"])
def test_defaults_are_stable(name, bands):
    assert scheme(name, bands).spectral_radius() <= 1 + 1e-9
