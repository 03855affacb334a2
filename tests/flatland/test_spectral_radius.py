"""The search for the fastest wave: symmetry and compression that it may use, and when not."""

import itertools

import numpy as np
import pytest
from sphere import cube_symmetries, representation
from stepping import neighbours, random_stencil

from flatland.harmonics import CircularHarmonics, SphericalHarmonics, basis_for
from flatland.stability import compressed, has_grid_symmetry, symbol
from flatland.stencil import Stencil

ROUNDING = 1e-12


def symmetrized(stencil):
    """The mean of a scheme over all rotations and reflections of the cube."""
    number = {tuple(offset): d for d, offset in enumerate(stencil.offsets.tolist())}
    transfer = np.zeros_like(stencil.transfer)
    for turn in cube_symmetries():
        mixing = representation(stencil.basis, turn)
        images = [number[tuple(image)] for image in (stencil.offsets @ turn.T).tolist()]
        transfer[images] += mixing @ stencil.transfer @ mixing.T / 48
    return Stencil(stencil.basis, stencil.offsets, transfer)


def brute_force(stencil, count):
    axis = np.linspace(-np.pi, np.pi, count, endpoint=False)
    waves = np.array(list(itertools.product(axis, repeat=stencil.basis.dimension)))
    return np.abs(np.linalg.eigvals(stencil.symbol(waves))).max()


@pytest.mark.parametrize("diagonal", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_a_wedge_is_enough_for_schemes_with_the_symmetry_of_the_cube(diagonal, seed):
    rng = np.random.default_rng(seed)
    stencil = symmetrized(random_stencil(rng, SphericalHarmonics(2), neighbours(3, diagonal)))
    assert has_grid_symmetry(stencil.basis, stencil.offsets, stencil.transfer)
    sampled, radius = brute_force(stencil, 24), stencil.spectral_radius()
    assert sampled - 1e-9 <= radius <= sampled * 1.005


@pytest.mark.parametrize("dimension", [2, 3])
def test_schemes_of_no_symmetry_are_recognised(dimension, rng):
    stencil = random_stencil(rng, basis_for(dimension, 2), neighbours(dimension))
    assert not has_grid_symmetry(stencil.basis, stencil.offsets, stencil.transfer)
    few = stencil.offsets[:-1]
    assert not has_grid_symmetry(stencil.basis, few, stencil.transfer[:-1])


def test_a_square_that_only_mirrors_is_not_symmetric_enough():
    """Light that moves along x alone keeps under mirroring, not under a quarter turn."""
    basis = CircularHarmonics(2)
    offsets = np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])
    transfer = np.array([1.0, 1.0, 0.5, 0.5])[:, None, None] * np.eye(3) / 3
    assert not has_grid_symmetry(basis, offsets, transfer)
    assert has_grid_symmetry(basis, offsets, np.broadcast_to(np.eye(3), (4, 3, 3)))


@pytest.mark.parametrize(("writes", "reads"), [(2, 9), (9, 3), (2, 2), (9, 9)])
def test_compressed_matrices_have_the_same_large_eigenvalues(writes, reads, rng):
    offsets = neighbours(3, diagonal=False)
    left, right = rng.normal(size=(9, writes)), rng.normal(size=(reads, 9))
    transfer = left @ rng.normal(size=(6, writes, reads)) @ right
    small = compressed(transfer)
    assert small.shape == (6, *[min(writes, reads)] * 2)
    waves = rng.uniform(-np.pi, np.pi, (20, 3))
    found = np.abs(np.linalg.eigvals(symbol(offsets, small, waves))).max(axis=-1)
    expected = np.abs(np.linalg.eigvals(symbol(offsets, transfer, waves))).max(axis=-1)
    np.testing.assert_allclose(found, expected, rtol=1e-10)


def test_scheme_that_sends_nothing_has_radius_zero():
    stencil = Stencil(SphericalHarmonics(2), neighbours(3), np.zeros((26, 4, 4)))
    assert stencil.spectral_radius() == 0.0
