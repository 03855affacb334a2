"""Stepping light of any size, precision and colour."""

import numpy as np
import pytest
from scenes import FLUX, LIGHTS, LPV, SHAPE, after, coloured, lobe_scene, scene_of

import propagators
from flatland.errors import InputError
from flatland.simulation import Simulation

#: Rounding of some dozen steps in float64, relative to the largest coefficient.
ROUNDING = 1e-12
#: The same in float32.
SINGLE = 1e-5


@pytest.mark.parametrize("clamp", [False, True])
def test_single_precision_is_near_double(clamp):
    propagator = propagators.create("lpv", clamp=clamp)
    double = after(scene_of(), 60, propagator, bands=3)
    single = after(scene_of(), 60, propagator, bands=3, precision="float32")
    assert single.accumulated.values.dtype == np.float32
    scale = np.abs(double.accumulated.values).max()
    np.testing.assert_allclose(
        single.accumulated.values, double.accumulated.values, rtol=0, atol=SINGLE * scale
    )
    for name, entry in double.ledger.as_dict().items():
        assert single.ledger.as_dict()[name] == pytest.approx(entry, abs=SINGLE * FLUX)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("flux", [1e30, 1e-30])
def test_size_of_the_light_does_not_matter(flux, precision):
    """The light is kept near 1 by a power of two, so that float32 holds both."""
    unit = after(lobe_scene((9, 9)), 30, precision=precision)
    scaled = after(lobe_scene((9, 9), flux=flux), 30, precision=precision)
    expected = flux * unit.accumulated.values.astype(float)
    tolerance = {"float64": 1e-14, "float32": 1e-6}[precision]
    scale = np.abs(expected).max()
    found = scaled.accumulated.values.astype(float)
    np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=tolerance)
    assert scaled.ledger.left == pytest.approx(flux * unit.ledger.left, rel=tolerance)


def test_double_precision_takes_any_light_a_scene_may_hold():
    scaled = after(lobe_scene((9, 9), flux=1e100), 30)
    unit = after(lobe_scene((9, 9)), 30)
    assert scaled.ledger.left == pytest.approx(1e100 * unit.ledger.left, rel=ROUNDING)


@pytest.mark.parametrize("flux", [1e40, 1e-40])
def test_light_that_single_precision_cannot_hold_is_refused(flux):
    with pytest.raises(InputError, match="precision = 'float32': cannot hold .*float64"):
        Simulation(lobe_scene((9, 9), flux=flux), LPV, precision="float32")


def test_proportional_spectra_are_one_run_times_the_spectrum():
    spectrum = np.array([1.0, 0.25, 3.0])
    scene = scene_of(coloured(list(spectrum), list(2 * spectrum)))
    mono = scene_of(coloured(1.0, 2.0))
    simulation, single = after(scene, 20, bands=3), after(mono, 20, bands=3)
    expected = np.multiply.outer(spectrum, single.accumulated.values)
    np.testing.assert_allclose(
        simulation.accumulated.values, expected, rtol=0, atol=1e-14 * np.abs(expected).max()
    )
    assert len(simulation._states) == 1


@pytest.mark.parametrize("spectra", [([1.0, 2.0, 0.5], [0.0, 1.0, 4.0]), ([0, 1, 0], [0, 0, 1])])
def test_independent_spectra_superpose_light_by_light(spectra):
    simulation = after(scene_of(coloured(*spectra)), 20, bands=3)
    expected = 0.0
    for light, spectrum in zip(LIGHTS, spectra):
        alone = after(scene_of([dict(light, flux=1.0)]), 20, bands=3).accumulated.values
        expected = expected + np.multiply.outer(np.array(spectrum, float), alone)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(
        simulation.accumulated.values, expected, rtol=0, atol=ROUNDING * scale
    )
    assert len(simulation._states) == 2


def test_books_are_kept_per_colour():
    spectra = [1.0, 2.0, 0.5], [0.0, 1.0, 4.0]
    ledger = after(scene_of(coloured(*spectra)), 20).ledger
    for colour, fluxes in enumerate(zip(*spectra)):
        mono = after(scene_of(coloured(*fluxes)), 20).ledger
        for name, entry in mono.as_dict().items():
            assert ledger.as_dict()[name][colour] == pytest.approx(entry, abs=ROUNDING)


def test_clamped_colours_are_stepped_one_by_one():
    """Back to back, two lobes fill each other's negative side: less is clamped than of each."""
    propagator = propagators.create("lpv", clamp=True)
    spectra = [1.0, 2.0, 0.5], [3.0, 1.0, 0.0]
    lobes = [{"kind": "cell", "cell": [4, 3], "direction": [x, 0.0]} for x in (1.0, -1.0)]

    def lit(fluxes):
        lights = [dict(lobe, flux=flux) for lobe, flux in zip(lobes, fluxes)]
        return after(scene_of(lights), 10, propagator).accumulated.values

    found = lit(spectra)
    for colour, fluxes in enumerate(zip(*spectra)):
        np.testing.assert_allclose(found[colour], lit(fluxes), atol=ROUNDING)
    mix = 0.3 * found[1] - 0.1 * found[0]  # what the third colour would be if light superposed
    assert np.abs(mix - found[2]).max() > 0.01


def test_grey_scene_has_no_colour_axis():
    assert after(scene_of(), 2).target.values.shape == (3, *SHAPE)
    assert after(scene_of(coloured([1.0], [2.0])), 2).target.values.shape == (1, 3, *SHAPE)
