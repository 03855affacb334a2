"""Light that leaves the grid, added up in the written-out loop."""

import numpy as np
import pytest
from stepping import Stepper, neighbours, plain_step, random_stencil

from flatland.harmonics import basis_for
from flatland.stencil import Stencil

#: Rounding of sums over a few hundred border cells.
ROUNDING = {np.float64: 1e-13, np.float32: 1e-5}


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("blocked", [False, True], ids=["open", "blocked"])
@pytest.mark.parametrize(("dimension", "bands"), [(2, 1), (2, 9), (3, 2), (3, 3), (3, 5)])
def test_light_that_left_is_that_of_plain_steps(dimension, bands, blocked, dtype, rng):
    """Coefficients below, at and above the number of sums that one pass keeps."""
    offsets = neighbours(dimension, diagonal=False)
    stencil = random_stencil(rng, basis_for(dimension, bands), offsets)
    shape = (5, 3, 4)[:dimension]
    values = rng.normal(size=(stencil.basis.size, *shape)).astype(dtype)
    transmittance = rng.uniform(size=(len(offsets), *shape)) if blocked else None
    stepper = Stepper(stencil, shape, transmittance, dtype=dtype)
    assert not stepper.sweep.by_matrices
    _, _, sums = stepper.steps(values)
    expected = plain_step(stencil, values.astype(float), transmittance).left
    scale = float(np.abs(values).sum())
    assert sums.left[0] == pytest.approx(expected, abs=ROUNDING[dtype] * scale)
    assert stepper.sweep.outflow(stepper.buffer(values)) == pytest.approx(
        expected, abs=ROUNDING[dtype] * scale
    )


def test_scheme_that_sends_nothing_loses_nothing():
    basis, offsets = basis_for(3, 2), neighbours(3, diagonal=False)
    stencil = Stencil(basis, offsets, np.zeros((6, 4, 4)))
    newest, _, sums = Stepper(stencil, (3, 3, 3)).steps(np.ones((4, 3, 3, 3)))
    assert not newest.any()
    assert sums.left[0] == 0.0


def test_coefficients_that_carry_no_flux_are_not_looked_at():
    """Light of band 1 stays what it is: only the first coefficient's cells count."""
    basis, offsets = basis_for(2, 2), neighbours(2, diagonal=False)
    stencil = Stencil(basis, offsets, np.broadcast_to(np.eye(3) / 4, (4, 3, 3)).copy())
    values = np.zeros((3, 4, 4))
    values[1:] = np.nan
    _, _, sums = Stepper(stencil, (4, 4)).steps(values)
    assert sums.left[0] == 0.0
