"""Error measures on fields whose errors are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from flatland import CircularHarmonics, Field, Grid, InputError
from studies import metrics


@pytest.fixture
def exact(rng):
    return Field(Grid((4, 3)), CircularHarmonics(3), rng.normal(size=(5, 4, 3)))


def _like(field, values):
    return Field(field.grid, field.basis, values)


@pytest.mark.parametrize("name", [n for n in metrics.MEASURES if n != "best_scale"])
def test_equal_fields_have_no_error(name, exact):
    assert metrics.MEASURES[name].function(exact, exact) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize(
    "name", ["coefficients", "scaled", "scalar_flux", "net_flux", "infinity_mean"]
)
def test_a_black_field_is_all_wrong(name, exact):
    black = _like(exact, np.zeros_like(exact.values))
    assert metrics.MEASURES[name].function(black, exact) == pytest.approx(1.0)


def test_leak_is_the_share_of_the_flux_in_dark_cells(exact):
    values, found = exact.values.copy(), np.zeros_like(exact.values)
    values[:, 1:, :] = 0.0
    found[0] = 1.0
    assert metrics.leak(_like(exact, found), _like(exact, values)) == pytest.approx(0.75)
    assert metrics.leak(_like(exact, found), exact) == 0.0


def test_a_wrong_exposure_is_forgiven_by_the_best_scale_only(exact):
    dim = _like(exact, 0.25 * exact.values)
    assert metrics.relative_l2(dim, exact) == pytest.approx(0.75)
    assert metrics.best_scale(dim, exact) == pytest.approx(4.0)
    assert metrics.scaled_l2(dim, exact) == pytest.approx(0.0, abs=1e-14)


def test_the_best_scale_is_the_best(exact, rng):
    other = _like(exact, exact.values + rng.normal(size=exact.values.shape))
    best = metrics.scaled_l2(other, exact)
    for factor in metrics.best_scale(other, exact) * np.array([0.9, 0.99, 1.01, 1.1]):
        assert metrics.relative_l2(_like(exact, factor * other.values), exact) > best


def test_an_error_in_one_band_shows_in_that_band(exact):
    values = exact.values.copy()
    values[exact.basis.degrees == 1] *= 1.5
    errors = metrics.band_errors(_like(exact, values), exact)
    assert errors == pytest.approx([0.0, 0.5, 0.0])
    assert metrics.net_flux_error(_like(exact, values), exact) == pytest.approx(0.5)
    assert metrics.scalar_flux_error(_like(exact, values), exact) == 0.0


def test_the_infinity_means_are_the_thesis_formula(exact):
    values = exact.values.copy()
    values[2, 1, 1] += 0.7
    cells = 12
    assert metrics.infinity_mean_absolute(_like(exact, values), exact) == pytest.approx(0.7 / cells)
    largest = np.abs(exact.values[:, 1, 1]).max()
    assert metrics.infinity_mean_relative(_like(exact, values), exact) == pytest.approx(
        0.7 / largest / cells
    )


def test_a_mask_leaves_cells_out(exact):
    values = exact.values.copy()
    values[:, 0, 0] = 1e6
    mask = np.ones((4, 3), bool)
    mask[0, 0] = False
    assert metrics.relative_l2(_like(exact, values), exact, mask) == 0.0


def _sampled(function, count=720):
    angles = (np.arange(count) + 0.5) * 2 * np.pi / count
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    samples = np.broadcast_to(function(angles)[:, None, None], (count, 2, 2))
    return directions, samples


@pytest.mark.parametrize("width", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("bands", [1, 2, 5, 9])
def test_the_floor_of_one_arc_is_closed_form(width, bands):
    """An arc of constant intensity: ‖c‖² / ‖I‖² = w/2π (1 + 2 Σ sinc²(m w/2))."""
    directions, samples = _sampled(lambda angles: (np.abs(angles - np.pi) < width / 2) * 1.0, 14400)
    m = np.arange(1, bands)
    kept = width / (2 * np.pi) * (1 + 2 * np.sum((np.sin(m * width / 2) / (m * width / 2)) ** 2))
    basis = CircularHarmonics(bands)
    arc = basis.arc_integral(np.pi - width / 2, np.pi + width / 2)
    reference = Field(Grid((2, 2)), basis, np.broadcast_to(arc[:, None, None], (basis.size, 2, 2)))
    floor = metrics.representation_floor(reference, directions, samples)
    # 14400 samples place the arc's ends to 4e-4 rad.
    assert floor == pytest.approx(np.sqrt(1 - kept), abs=2e-3)
    assert metrics.angular_l2(reference, directions, samples) == pytest.approx(floor, abs=2e-3)


def test_no_field_beats_the_floor(rng):
    directions, samples = _sampled(lambda angles: np.exp(3 * np.cos(angles)) * (angles < 4))
    basis = CircularHarmonics(3)
    best = basis.project(lambda d: np.exp(3 * d[:, 0]), 64)
    values = np.broadcast_to(best[:, None, None], (5, 2, 2))
    field = Field(Grid((2, 2)), basis, values)
    floor = metrics.representation_floor(field, directions, samples)
    for _ in range(20):
        other = _like(field, values + rng.normal(size=values.shape) * 0.1)
        assert metrics.angular_l2(other, directions, samples) >= floor


def test_fields_that_do_not_fit_are_refused(exact):
    with pytest.raises(InputError, match="reference"):
        metrics.relative_l2(exact, exact.with_bands(2))
    with pytest.raises(InputError, match="mask"):
        metrics.relative_l2(exact, exact, np.ones((3, 4), bool))
    with pytest.raises(InputError, match="intensity"):
        metrics.angular_l2(exact, [[1.0, 0.0]], np.zeros((2, 4, 3)))
