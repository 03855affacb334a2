"""Neighbours taken together: the same scheme, and fewer operations."""

import numpy as np
import pytest
from schemes import every_scheme, is_linear
from stepping import Stepper, neighbours, plain_step, random_stencil

from flatland.harmonics import CircularHarmonics, SphericalHarmonics, basis_for
from flatland.kernels.orbits import operations, orbits_of, significant
from flatland.stencil import Stencil
from propagators import create

BANDS = {2: (1, 2, 3, 5, 9), 3: (1, 2, 4)}


def unfolded(stencil):
    """Transfer matrices that orbits stand for, each from its orbit's first one and parities."""
    transfer = np.full(stencil.transfer.shape, np.nan)
    for orbit in orbits_of(stencil):
        first = np.abs(stencil.offsets[orbit.members[0]])
        for member in orbit.members:
            turned = stencil.offsets[member] < 0
            if len(orbit.members) == 1:
                transfer[member] = orbit.transfer
                continue
            np.testing.assert_array_equal(np.abs(stencil.offsets[member]), first)
            signs = np.prod(stencil.basis.parities[:, turned], axis=1)
            transfer[member] = np.outer(signs, signs) * orbit.transfer
    return transfer


@every_scheme()
def test_orbits_are_the_scheme(propagator, dimension):
    for bands in BANDS[dimension]:
        stencil = propagator.stencil(basis_for(dimension, bands))
        size = np.abs(stencil.transfer).max()
        difference = np.abs(unfolded(stencil) - significant(stencil.transfer)).max()
        assert difference <= 2e-14 * size
        orbits = orbits_of(stencil)
        members = sorted(d for orbit in orbits for d in orbit.members)
        assert members == list(range(len(stencil.offsets)))
        # Axial offsets and diagonals alike: one orbit for each absolute offset.
        assert len(orbits) == len(np.unique(np.abs(stencil.offsets), axis=0))


@pytest.mark.parametrize(
    ("name", "dimension", "bands", "most"),
    [("dom8", 2, 5, 0.6), ("dom8", 2, 8, 0.5), ("dom26", 3, 3, 0.6), ("dom26", 3, 5, 0.37)],
)
def test_orbits_save_work(name, dimension, bands, most):
    stencil = create(name).stencil(basis_for(dimension, bands))
    couplings = np.count_nonzero(significant(stencil.transfer))
    assert operations(orbits_of(stencil)) <= most * couplings


@pytest.mark.parametrize("basis", [CircularHarmonics(2), SphericalHarmonics(2)], ids=repr)
def test_offsets_of_a_lopsided_scheme_stand_alone(basis, rng):
    stencil = random_stencil(rng, basis, neighbours(basis.dimension))
    orbits = orbits_of(stencil)
    assert [orbit.members for orbit in orbits] == [(d,) for d in range(len(stencil.offsets))]
    assert operations(orbits) == stencil.transfer.size


def test_an_orbit_with_one_member_missing_is_none(rng):
    whole = create("dom8").stencil(CircularHarmonics(3))
    stencil = Stencil(whole.basis, whole.offsets[:-1], whole.transfer[:-1])
    missing = np.abs(whole.offsets[-1])
    for orbit in orbits_of(stencil):
        alone = np.array_equal(np.abs(stencil.offsets[orbit.members[0]]), missing)
        assert len(orbit.members) == (1 if alone else 2 ** len(orbit.axes))
    values = rng.normal(size=(whole.basis.size, 4, 7))
    found = Stepper(stencil, (4, 7)).step(values)
    np.testing.assert_allclose(found, plain_step(stencil, values).arrived, atol=1e-13)


def test_one_matrix_that_is_off_parts_its_orbit(rng):
    stencil = create("dom8").stencil(CircularHarmonics(2))
    transfer = stencil.transfer.copy()
    transfer[0, 0, 0] *= 1 + 1e-9
    stencil = Stencil(stencil.basis, stencil.offsets, transfer)
    assert (0,) in [orbit.members for orbit in orbits_of(stencil)]
    values = rng.normal(size=(3, 5, 9))
    found = Stepper(stencil, (5, 9)).step(values)
    np.testing.assert_allclose(found, plain_step(stencil, values).arrived, rtol=0, atol=1e-13)


@every_scheme(is_linear)
@pytest.mark.parametrize("blocked", [False, True], ids=["open", "blocked"])
def test_sweeps_by_orbits_do_what_a_plain_step_does(propagator, dimension, blocked, rng):
    for bands in (2, 4) if dimension == 3 else (2, 5, 12):
        stencil = propagator.stencil(basis_for(dimension, bands))
        shape = (3, 4, 19) if dimension == 3 else (5, 35)
        values = rng.normal(size=(stencil.basis.size, *shape))
        tau = rng.uniform(size=(len(stencil.offsets), *shape)) if blocked else None
        found = Stepper(stencil, shape, tau).step(values)
        expected = plain_step(stencil, values, tau).arrived
        np.testing.assert_allclose(found, expected, rtol=0, atol=2e-12)
