"""Pixels and outlines of lobes: arrays in, colours out, without Qt."""

from __future__ import annotations

import numpy as np
import pytest

from flatland.field import Field
from flatland.grid import Grid
from flatland.harmonics import CircularHarmonics, SphericalHarmonics
from gui.models.plane import Plane
from gui.render.colours import DARK, LIGHT, hues_on, light_hues, pack
from gui.render.outlines import lobe_outlines
from gui.render.picture import Layer, Scale, cut_of, heat_colours, paint
from gui.render.scaling import FULL, radius_factors, shown_sizes
from gui.render.tables import peaks

RED = "#ff0000"
WHOLE = (slice(0, 1), slice(0, 1))


def one_cell(coefficients, bands=3):
    basis = CircularHarmonics(bands)
    values = np.zeros((basis.size, 1, 1))
    values[: len(coefficients), 0, 0] = coefficients
    return Field(Grid((1, 1)), basis, values)


def drawn(field, top, pixels=61, **options):
    layer = Layer(cut_of(field, Plane()), RED, **options)
    return paint([layer], Scale(top), WHOLE, pixels, LIGHT, borders=False)


def covered(image, colour=RED):
    """Share of the colour at every pixel, on white paper."""
    green = (image >> 8 & 255).astype(float)
    paper, ink = 255.0, float(pack(colour) >> 8 & 255)
    return (paper - green) / (paper - ink)


def test_the_same_in_all_directions_is_a_disc_of_the_right_size():
    field = one_cell([2.0])
    top = 2.0 / np.sqrt(2 * np.pi)
    for pixels in (24, 61, 90):
        area = covered(drawn(field, top, pixels)).sum()
        assert area == pytest.approx(np.pi * (FULL * pixels) ** 2, rel=0.01)
    half = covered(drawn(field, 2 * top)).sum()
    assert half == pytest.approx(np.pi * (FULL * 61 / 2) ** 2, rel=0.02)


def test_pixels_and_outlines_agree():
    rng = np.random.default_rng(3)
    field = one_cell(np.concatenate([[2.0], 0.25 * rng.normal(size=4)]))
    top = float(peaks(field.basis, (0, 1), field.values)[0, 0])
    area = covered(drawn(field, top, 101)).sum()
    layer = Layer(cut_of(field, Plane()), RED)
    ((_, outline, negative),) = lobe_outlines(layer, Scale(top), WHOLE)
    assert len(negative) == 0
    x, y = outline.T
    polygon = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert area == pytest.approx(polygon * 101**2, rel=0.01)


def test_light_to_the_right_is_drawn_to_the_right_and_up_is_up():
    basis = CircularHarmonics(4)
    for direction, half in (((1.0, 0.0), np.s_[:, 31:]), ((0.0, 1.0), np.s_[:30])):
        field = one_cell(basis.lambertian(np.array(direction)), 4)
        share = covered(drawn(field, 0.5))
        assert share[half].sum() > 0.9 * share.sum()


def test_negative_light_has_its_own_colour():
    field = one_cell([0.0, 1.0, 0.0])  # cos: positive to the right, negative to the left
    image = drawn(field, 1.0)
    violet, red = pack(LIGHT.negative), pack(RED)
    assert np.count_nonzero(image[:, :30] == violet) > 50
    assert np.count_nonzero(image[:, :30] == red) == 0
    assert np.count_nonzero(image[:, 31:] == red) > 50
    assert np.count_nonzero(image[:, 31:] == violet) == 0


def test_a_line_has_its_width():
    field = one_cell([2.0])
    top = 2.0 / np.sqrt(2 * np.pi)
    for width in (1.0, 2.0, 4.0):
        area = covered(drawn(field, top, 101, width=width)).sum()
        assert area == pytest.approx(2 * np.pi * FULL * 101 * width, rel=0.03)


def test_dark_cells_stay_paper():
    image = drawn(one_cell([0.0]), 1.0)
    assert np.all(image == pack(LIGHT.paper))


@pytest.mark.parametrize("basis", [CircularHarmonics(5), SphericalHarmonics(3)])
def test_peaks_are_those_of_the_sampled_intensity(basis):
    rng = np.random.default_rng(4)
    values = rng.normal(size=(basis.size, 40, 30))
    plane = Plane((0, 1), 2 if basis.dimension == 3 else None)
    angles = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    samples = basis.evaluate(plane.directions(angles, basis.dimension))
    exact = np.abs(np.tensordot(samples, values, 1)).max(axis=0)
    found = peaks(basis, plane.axes, values)
    assert np.all(found <= exact * (1 + 1e-5))
    assert np.all(found >= 0.966 * exact)


def test_scales():
    sizes = np.array([0.0, 1e-6, 1e-2, 1.0, 10.0])
    np.testing.assert_allclose(shown_sizes(sizes, 1.0, "linear", 4.0), sizes)
    shown = shown_sizes(sizes, 1.0, "logarithmic", 4.0)
    np.testing.assert_allclose(shown, [0.0, 0.0, 0.5, 1.0, 1.25])
    factors = radius_factors(sizes, 1.0, "linear", 4.0, True)
    np.testing.assert_allclose(factors * sizes, [0.0, FULL, FULL, FULL, FULL])
    assert np.all(shown_sizes(sizes, 0.0, "linear", 4.0) == 0)


def test_colours_tell_hue_and_the_map_tells_flux():
    flux = np.array([[[4.0]], [[1.0]], [[0.0]]])
    hues = light_hues(flux)
    assert hues[0, 0, 0] == 1.0
    assert hues[0, 0, 2] == 0.0
    for dark in (True, False):
        packed = int(hues_on(hues, dark)[0, 0])
        assert packed >> 16 & 255 > packed >> 8 & 255 >= packed & 255
    bright = cut_of(one_cell([2.0]), Plane())
    low = cut_of(one_cell([0.02]), Plane())
    dark = cut_of(one_cell([-1.0]), Plane())
    scale = Scale(1.0)
    values = [int(heat_colours(each, scale, WHOLE, DARK)[0, 0]) for each in (bright, low, dark)]
    assert sum(values[0].to_bytes(4, "big")[1:]) > sum(values[1].to_bytes(4, "big")[1:])
    assert values[2] == pack(DARK.negative)


def test_what_is_larger_than_its_cell_stays_in_it():
    basis = CircularHarmonics(1)
    values = np.zeros((1, 2, 1))
    values[0, 0, 0] = 100.0
    layer = Layer(cut_of(Field(Grid((2, 1)), basis, values), Plane()), RED)
    image = paint([layer], Scale(1.0), (slice(0, 2), slice(0, 1)), 16, LIGHT, borders=False)
    assert np.all(image[:, :16] == pack(RED))
    assert np.all(image[:, 16:] == pack(LIGHT.paper))
