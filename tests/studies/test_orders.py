"""Fitted orders: known slopes, known uncertainty."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from flatland.errors import InputError
from studies.orders import fitted_order, fitted_orders

SIZES = np.array([1.0, 1 / 2, 1 / 3, 1 / 4, 1 / 8])


@pytest.mark.parametrize("order", [-0.5, 0.0, 1.0, 2.0])
def test_a_power_law_is_found_whatever_its_factors(order):
    sizes = np.concatenate([SIZES, 3 * SIZES])
    errors = np.concatenate([0.7 * SIZES**order, 40 * SIZES**order])
    found = fitted_order(sizes, errors, ["a"] * 5 + ["b"] * 5)
    assert found.order == pytest.approx(order, abs=1e-12)
    assert found.low == pytest.approx(found.high, abs=1e-10)
    assert found.worst < 1e-12
    assert found.points == 10


def test_the_interval_holds_the_truth_as_often_as_it_says(rng):
    hits = 0
    for _ in range(400):
        noise = np.exp(0.1 * rng.normal(size=10))
        errors = np.concatenate([SIZES, 5 * SIZES]) * noise
        found = fitted_order(np.tile(SIZES, 2), errors, np.repeat([0, 1], 5))
        hits += found.low <= 1.0 <= found.high
    assert 0.92 < hits / 400 < 0.98  # 95 %, and three standard deviations of 1.1 %


@pytest.mark.parametrize(
    ("sizes", "errors"), [([1.0, 0.5], [1.0, 0.5]), (SIZES, -SIZES), (SIZES, 0 * SIZES)]
)
def test_what_cannot_be_fitted_is_refused(sizes, errors):
    with pytest.raises(InputError):
        fitted_order(sizes, errors, np.zeros(len(sizes)))


def test_schemes_and_bands_are_fitted_apart():
    rows = xr.Dataset(
        {
            "scheme": ("row", ["lpv"] * 5 + ["dom8"] * 5 + ["lone"]),
            "bands": ("row", [2] * 11),
            "scene": ("row", ["shelf"] * 11),
            "spacing": ("row", [*SIZES, *SIZES, 1.0]),
            "angular": ("row", [*SIZES, *(SIZES**2), 1.0]),
        }
    )
    found = fitted_orders(rows, "angular")
    assert {key: round(order.order, 9) for key, order in found.items()} == {
        ("lpv", 2): 1.0,
        ("dom8", 2): 2.0,
    }
