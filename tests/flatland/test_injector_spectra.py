"""All lights of a scene in one field, and its factoring by colour."""

import numpy as np
import pytest

from flatland.errors import InputError
from flatland.harmonics import CircularHarmonics, SphericalHarmonics
from flatland.injection import factor_spectra, independent_spectra, inject
from flatland.scene import Scene, load_scene

BASIS = CircularHarmonics(3)


def scene_of(*fluxes):
    """One lit cell per flux, two neighbours sharing the first cell."""
    lights = [
        {"kind": "cell", "cell": [max(0, i - 1), 1], "direction": [1, i], "flux": flux}
        for i, flux in enumerate(fluxes)
    ]
    return Scene.from_dict({"grid": {"shape": [6, 4]}, "light": lights})


SPECTRA = {
    "grey": ([1.0, 2.0], 1),
    "no light": ([], 1),
    "black": ([0.0], 1),
    "black in colour": ([[0, 0, 0]], 1),
    "one colour": ([[1, 2, 3]], 1),
    "proportional": ([[1, 2, 3], [2, 4, 6]], 1),
    "grey in a coloured scene": ([[1, 1, 1], 2.0], 1),
    "two colours": ([[1, 2, 3], [3, 2, 1]], 2),
    "two colours, three lights": ([[1, 0, 1], [0, 1, 1], [1, 1, 2]], 2),
    "red and the rest": ([[1, 0, 0], [0, 2, 4]], 2),
    "a faint channel": ([[1, 1e-30, 1], [1, 0, 1]], 2),
    "a black channel": ([[1, 0, 2], [2, 0, 4]], 1),
    "three colours": ([[1, 0, 0], [0, 1, 0], [0, 0, 1]], 3),
    "more colours than lights": ([[1, 2, 3, 4, 5], [1, 0, 1, 0, 1]], 2),
}
every_spectrum = pytest.mark.parametrize(("fluxes", "count"), SPECTRA.values(), ids=SPECTRA)


@every_spectrum
def test_mixed_patterns_are_the_field(fluxes, count):
    scene = scene_of(*fluxes)
    patterns, mixing = independent_spectra(scene, BASIS)
    values = inject(scene, BASIS).values
    mixed = np.tensordot(mixing, patterns, axes=1)
    for channel, expected in zip(mixed, values if scene.colours else [values]):
        np.testing.assert_allclose(channel, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@every_spectrum
def test_there_are_as_few_patterns_as_independent_spectra(fluxes, count):
    patterns, mixing = independent_spectra(scene_of(*fluxes), BASIS)
    assert (len(patterns), mixing.shape[1]) == (count, count)


def test_patterns_are_colour_channels_and_so_never_negative_light():
    chosen, mixing = factor_spectra(np.array([[1.0, 2.0, 3.0], [3.0, 2.0, 1.0]]))
    np.testing.assert_array_equal(mixing[chosen], np.eye(2))


def test_field_carries_the_flux_of_all_lights():
    scene = scene_of([1, 2, 3], 1.0, [0, 5, 0])
    np.testing.assert_allclose(inject(scene, BASIS).total_flux(), [2, 8, 4], rtol=1e-12)


def test_lights_in_the_same_cell_add_up():
    both = inject(scene_of(1.0, 1.0), BASIS).values
    single = [inject(Scene.from_dict({"grid": {"shape": [6, 4]}, "light": [light]}), BASIS).values
              for light in scene_of(1.0, 1.0).to_dict()["light"]]  # fmt: skip
    np.testing.assert_allclose(both, sum(single), rtol=1e-15)


def test_coloured_albedo_makes_the_field_coloured():
    wall = {"kind": "segment", "start": [1, 1], "end": [2, 2], "albedo": [0.1, 0.2]}
    scene = Scene.from_dict({"grid": {"shape": [6, 4]}, "occluder": [wall]})
    assert inject(scene, BASIS).values.shape == (2, BASIS.size, 6, 4)


def test_basis_of_another_dimension_is_refused():
    with pytest.raises(InputError, match="basis"):
        inject(load_scene("shelf"), SphericalHarmonics(2))


def test_field_that_does_not_fit_into_memory_is_refused():
    with pytest.raises(InputError, match=r"GiB of memory"):
        inject(load_scene("shelf"), CircularHarmonics(2**31))
